"""The source as text: what may be sent to the tokenizer, and where a character stands."""

import re
from bisect import bisect_right

from cgagen.errors import SourceError

MOST_CHARACTERS = 65_535
"""Longest source: places in it are 16-bit numbers. Ref: S3."""

_LINE_END = re.compile(r"\r\n|\r|\n")
_REFUSED = re.compile(r"[^\t\r\n -~]")
_CODE = re.compile(r"(?:[^'\"\r\n]|\"[^\"\r\n]*\"?)*")
"""What of a line comes before its comment."""


class Lines:
    """Line and column, from 1, of every character of a source."""

    def __init__(self, source: str) -> None:
        self._starts = [0, *(end.end() for end in _LINE_END.finditer(source))]

    def place(self, offset: int) -> tuple[int, int]:
        r"""Return line and column of a character.

        >>> Lines("a\r\nbc\rd").place(4)
        (2, 2)
        """
        line = bisect_right(self._starts, offset)
        return line, offset - self._starts[line - 1] + 1


def sendable(source: str, name: str) -> str:
    """Return the source as it may be sent: plain ASCII, ended by a line feed, of equal places.

    The tokenizer turns some characters into others and stops silently at some; those are
    refused. In comments, which it skips, foreign letters are harmless and are masked. Without a
    final line end it never returns from certain comments.

    Raises:
        SourceError: with line and column of the character, or for a source that is too long.
    """
    text = source if source.endswith(("\n", "\r")) else source + "\n"
    if len(text) > MOST_CHARACTERS:
        raise SourceError(
            f"{name}: the source has {len(text):,} characters, more than the {MOST_CHARACTERS:,} "
            "that the tokenizer can number; split it into program slots"
        )
    if _REFUSED.search(text) is None:
        return text
    masked = "".join(_masked(line) for line in re.split(r"(\r\n|\r|\n)", text))
    found = _REFUSED.search(masked)
    if found is None:
        return masked
    line, column = Lines(source).place(found.start())
    raise SourceError(
        f"{name}:{line}:{column}: {_what(found[0])}; write it in plain ASCII",
        line=line,
        column=column,
        length=1,
    )


def _masked(line: str) -> str:
    code = _CODE.match(line)
    start = code.end() if code else 0
    comment = line[start:]
    if not comment.startswith("'") or "{$" in comment:
        return line
    return line[:start] + "".join("?" if char > "\x7f" else char for char in comment)


def _what(char: str) -> str:
    if char > "\x7f":
        shown = char if char.isprintable() else "?"
        return f"the tokenizer would change the character {shown!r} (U+{ord(char):04X}) silently"
    return f"the tokenizer would stop at or change the control character {ord(char)} silently"
