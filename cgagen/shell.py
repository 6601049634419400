"""Commands that a user is told to type: as a shell takes them, whatever is in their paths."""

import shlex
from pathlib import Path


def command(*words: str | Path) -> str:
    """Return `cgagen` with its words, quoted where a shell would take them apart.

    A path that begins with a hyphen is told from an option by the folder that it lies in.

    >>> command("build", Path("my runs/best.genome"))
    "cgagen build 'my runs/best.genome'"
    >>> command("resume", Path("-old"))
    'cgagen resume ./-old'
    """
    return shlex.join(["cgagen", *(_word(word) for word in words)])


def _word(word: str | Path) -> str:
    text = str(word)
    return f"./{text}" if isinstance(word, Path) and text.startswith("-") else text
