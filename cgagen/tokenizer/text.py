"""The source as text: what may be sent to the tokenizer, and where a character stands."""

import re
from bisect import bisect_left, bisect_right

from cgagen.errors import SourceError

MOST_CHARACTERS = 65_535
"""Longest source: places in it are 16-bit numbers. Ref: S3."""

_LINE_END = re.compile(r"\r\n|\r|\n")
_UNUSUAL = re.compile(r"[^\t\r\n -~]")
_PAGE = re.compile(r"(?<![^\r\n])[ \t\f]*\f[ \t\f]*(?=[\r\n]|\Z)")
"""A line of nothing but form feeds: a page of an old listing ends."""
_DOS_END = re.compile(r"\x1a[\s\x1a]*\Z")
"""How CP/M and DOS ended texts."""
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


class Sent:
    """A source as it is sent to the tokenizer, and where its characters stand in the original.

    All line ends are sent as CR LF, the way Parallax's editor writes them, and the last line has
    one: the tokenizer misses a directive on the line behind an empty comment that ends in LF or
    CR, and without a final line end never returns from certain comments. Ref: S3, measured. Lines
    and columns stay what they are.

    Attributes:
        text: what is sent.
        strays: places in the original of control characters between statements, which the
            tokenizer takes for blanks.
    """

    def __init__(self, source: str, masked: str, strays: tuple[int, ...]) -> None:
        self.strays = strays
        self._length = len(source)
        self._added: list[int] = []
        parts: list[str] = []
        begin = length = 0
        for end in _LINE_END.finditer(masked):
            parts += (masked[begin : end.start()], "\r\n")
            length += end.start() - begin + 2
            begin = end.end()
            if end[0] != "\r\n":
                self._added.append(length - 1)
        rest = masked[begin:]
        self.text = "".join(parts) + (rest + "\r\n" if rest or not parts else "")

    def original(self, offset: int) -> int:
        r"""Return the place in the original of a character that was sent.

        >>> [sendable("a\nb", "x").original(place) for place in range(4)]
        [0, 1, 1, 2]
        """
        return min(offset - bisect_left(self._added, offset + 1), self._length)


def sendable(source: str, name: str) -> Sent:
    r"""Return the source as it may be sent: plain ASCII, lines ended by CR LF.

    The tokenizer turns some characters into others silently; those are refused. In comments,
    which it skips, they are harmless and are masked.

    >>> sendable("a\rb\r\n", "x").text
    'a\r\nb\r\n'

    Raises:
        SourceError: with line and column of the character, or for a source that is too long.
    """
    masked = source
    strays: list[int] = []
    if _UNUSUAL.search(source) is not None:
        masked = _masked(source, strays)
        found = _UNUSUAL.search(masked)
        if found is not None:
            line, column = Lines(source).place(found.start())
            raise SourceError(
                f"{name}:{line}:{column}: {_what(found[0])}; write it in plain ASCII",
                line=line,
                column=column,
                length=1,
            )
    sent = Sent(source, masked, tuple(strays))
    if len(sent.text) > MOST_CHARACTERS:
        raise SourceError(
            f"{name}: the source has {len(sent.text):,} characters, two for each line end, more "
            f"than the {MOST_CHARACTERS:,} that the tokenizer can number; split it into program "
            "slots"
        )
    return sent


def _masked(source: str, strays: list[int]) -> str:
    """Return a source with what is harmless as `?` or a blank, and note what strays in code.

    A Ctrl-Z at the end and a form feed in a line of its own make no difference to the tokenizer
    (Ref: S3, by compiling); in a statement, such characters end it or are refused.
    """
    parts: list[str] = []
    for line in re.split(r"(\r\n|\r|\n)", source):
        code = _CODE.match(line)
        start = code.end() if code else 0
        comment = line[start:]
        if comment.startswith("'") and "{$" not in comment:
            comment = _UNUSUAL.sub("?", comment)
        parts.append(line[:start] + comment)
    masked = "".join(parts)
    for harmless in (_PAGE, _DOS_END):
        for found in harmless.finditer(masked):
            strays += (at for at in range(*found.span()) if masked[at] in "\f\x1a")
        masked = harmless.sub(lambda found: re.sub(r"[\f\x1a]", " ", found[0]), masked)
    return masked


def _what(char: str) -> str:
    if char > "\x7f":
        shown = char if char.isprintable() else "?"
        return f"the tokenizer would change the character {shown!r} (U+{ord(char):04X}) silently"
    return f"the tokenizer would stop at or change the control character {ord(char)} silently"
