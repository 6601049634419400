"""What a mistyped word was meant to be."""

import difflib
from collections.abc import Iterable

NEAR = 0.6
"""How alike two words are, 0 to 1, of which one may be meant for the other. Choice: difflib's."""


def near(word: str, known: Iterable[str]) -> str | None:
    """Return the known word that is most like another, upper and lower case being the same.

    >>> near("exhaustiv", ["smoke", "exhaustive"]), near("x", ["smoke"]), near("WAT", ["wait"])
    ('exhaustive', None, 'wait')
    """
    spelled = {one.casefold(): one for one in known}
    found = difflib.get_close_matches(word.casefold(), spelled, n=1, cutoff=NEAR)
    return spelled[found[0]] if found else None


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return words for a sentence that ask that; nothing where no word is near.

    >>> "no verb evolv" + did_you_mean("evolv", ["evolve", "info"])
    'no verb evolv (did you mean evolve?)'
    """
    found = near(word, known)
    return f" (did you mean {found}?)" if found else ""
