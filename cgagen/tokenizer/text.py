"""The source as text: what may be sent to the tokenizer, and where a character stands."""

import re
from bisect import bisect_right

from cgagen.errors import SourceError

MOST_CHARACTERS = 65_535
"""Longest source: places in it are 16-bit numbers. Ref: S3."""

_LINE_END = re.compile(r"\r\n|\r|\n")
_UNUSUAL = re.compile(r"[^\t\r\n -~]")
_FOREIGN = re.compile(r"[^\x00-~]")
_CONTROL = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f]")
_CODE = re.compile(r"(?:[^'\"\r\n]|\"[^\"\r\n]*\"?)*")
"""What of a line comes before its comment."""
_DIRECTIVE = re.compile(r"'[ \t]*\{[ \t]*\$[^}]*\}?")
_SENT_END = "\r\n"
_CONTROLS_AND_BLANKS = "".join(map(chr, range(33)))
_CUTS = "\x00\x03\x1a"
"""A source may be meant to end there: Parallax's package drops what is behind the first two
(Ref: S3, measured), and DOS what is behind Ctrl-Z."""


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
    and columns stay what they are. A source that only two characters for each line end make too
    long is sent without its comments.

    Attributes:
        text: what is sent.
        source: the original, with blanks for the control characters in `strays`.
        strays: places in the original of control characters that the tokenizer takes for line
            ends where a blank means the same.
    """

    def __init__(self, source: str, masked: str, strays: tuple[int, ...]) -> None:
        self.source = _CONTROL.sub(" ", source) if strays else source
        self.strays = strays
        self._pieces: list[tuple[int, int]] = []
        """Places in the text and in the original; between two of them both count alike."""
        ends = [found.span() for found in _LINE_END.finditer(masked)]
        if not ends or ends[-1][1] < len(masked):
            ends.append((len(masked), len(masked)))
        begins = [0, *(behind for _, behind in ends[:-1])]
        lines = [masked[begin:end] for begin, (end, _) in zip(begins, ends, strict=True)]
        if sum(map(len, lines)) + len(_SENT_END) * len(lines) > MOST_CHARACTERS:
            lines = [line.removesuffix(_plain_comment(line)) for line in lines]
        self.text = _SENT_END.join(lines) + _SENT_END
        place = 0
        for begin, line, (end, _) in zip(begins, lines, ends, strict=True):
            self._pieces += [(place, begin), (place + len(line), end)]
            place += len(line) + len(_SENT_END)

    def original(self, offset: int) -> int:
        r"""Return the place in the original of a character that was sent.

        >>> [sendable("a\nb", "x").original(place) for place in range(4)]
        [0, 1, 2, 2]
        """
        piece = bisect_right(self._pieces, (offset, len(self.source) + 1)) - 1
        began, place = self._pieces[piece]
        behind = self._pieces[piece + 1][1] if piece + 1 < len(self._pieces) else len(self.source)
        return min(place + offset - began, behind)


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
    characters = len(sent.text)
    if characters <= MOST_CHARACTERS:
        characters = sum(len(line) + 1 for line in _LINE_END.split(source)) - 1
    if characters > MOST_CHARACTERS:
        raise SourceError(
            f"{name}: the source has {characters:,} characters, more than the {MOST_CHARACTERS:,} "
            "that the tokenizer can number; split it into program slots"
        )
    return sent


def _masked(source: str, strays: list[int]) -> str:
    """Return a source with what is harmless as `?` or a blank, and note what strays in code.

    The tokenizer ends a line at any control character, a comment too (Ref: S3, by compiling). At
    the edge of a line, and before nothing but a comment, that makes no other program than a blank.
    """
    parts: list[str] = []
    begin = 0
    over = len(source.rstrip(_CONTROLS_AND_BLANKS))
    for line in re.split(r"(\r\n|\r|\n)", source):
        code, said, comment = parts_of(line)
        harmless = not _CONTROL.search(comment) or not _readable(comment)
        comment = (_UNUSUAL if harmless else _FOREIGN).sub("?", comment)
        masked = code + said + comment
        for found in _CONTROL.finditer(masked):
            at = found.start()
            if (found[0] not in _CUTS or begin + at >= over) and _at_an_edge(masked, at, len(code)):
                strays.append(begin + at)
                masked = f"{masked[:at]} {masked[at + 1 :]}"
        parts.append(masked)
        begin += len(line)
    return "".join(parts)


def parts_of(line: str) -> tuple[str, str, str]:
    """Return the code of a line, the directive of its comment, and the rest of the comment."""
    code = _CODE.match(line)
    start = code.end() if code else 0
    directive = _DIRECTIVE.match(line, start)
    end = directive.end() if directive else start
    return line[:start], line[start:end], line[end:]


def _plain_comment(line: str) -> str:
    return "".join(parts_of(line)[1:]) if not parts_of(line)[1] else ""


def _readable(comment: str) -> str:
    """Return what the tokenizer would read behind the first control character of a comment."""
    return re.sub(r"[^!-~]", "", _CONTROL.split(comment, 1)[-1])


def _at_an_edge(line: str, at: int, comment: int) -> bool:
    """Whether nothing but blanks and a comment is before a place in a line, or behind it."""
    before, behind = line[:at], line[at:comment] if at < comment else line[at:]
    return not before.strip(_CONTROLS_AND_BLANKS) or not behind.strip(_CONTROLS_AND_BLANKS)


def _what(char: str) -> str:
    if char > "\x7f":
        shown = char if char.isprintable() else "?"
        return f"the tokenizer would change the character {shown!r} (U+{ord(char):04X}) silently"
    return f"the tokenizer would stop at or change the control character {ord(char)} silently"
