"""A source as pieces of text: code without comments, labels, and the words of each statement.

This is no second tokenizer: what is live, and where it lies, comes from the source map.
"""

import re
from dataclasses import dataclass

from cgagen.stamp.compiled import Compiled, Statement

START = "(start)"
"""Name of the code before the first label."""

_COMMENT = re.compile(r"\"[^\"\r\n]*\"?|'[^\r\n]*")
_LABEL = re.compile(r"(?:^|(?<=[\r\n:]))[ \t]*([A-Za-z_]\w*)[ \t]*:")
_NOT_LABELS = frozenset(
    "DO LOOP ELSE ENDIF NEXT RETURN END STOP EXIT ENDSELECT MAINIO AUXIO".split()
)
"""Statements of one word: a colon behind them only ends them. Ref: S2 chapter 5."""

_WORD = re.compile(r"[A-Za-z_]\w*")
_LINE_END = re.compile(r"\r\n|\r|\n")


@dataclass(frozen=True, slots=True)
class Label:
    """A label, and where it stands."""

    name: str
    offset: int


@dataclass(frozen=True, slots=True)
class Piece:
    """One live statement: its words in capitals, its text, and how it lies in its line."""

    statement: Statement
    words: tuple[str, ...]
    text: str
    starts_line: bool


def lines_of(source: str) -> list[str]:
    r"""Return the lines of a source, as the lines of a source map are counted.

    CR, LF and CR LF end a line, and nothing else does: a form feed is one of its characters.

    >>> lines_of("a\r\nb\rc\fd\n")
    ['a', 'b', 'c\x0cd']
    """
    *lines, last = _LINE_END.split(source)
    return [*lines, last] if last else lines


def blanked(source: str) -> str:
    """Return the source with comments and texts as blanks, every place as it was.

    >>> blanked("HIGH 3 ' on")
    'HIGH 3     '
    """
    return _COMMENT.sub(lambda found: " " * len(found[0]), source)


def labels_of(code: str) -> tuple[Label, ...]:
    r"""Return the labels of a blanked source, in order.

    >>> [label.name for label in labels_of("a: HIGH 1\nDO : LOOP\nb:\n")]
    ['a', 'b']
    """
    return tuple(
        Label(found[1], found.start(1))
        for found in _LABEL.finditer(code)
        if found[1].upper() not in _NOT_LABELS
    )


def pieces_of(compiled: Compiled, code: str, labels: tuple[Label, ...]) -> tuple[Piece, ...]:
    """Return the live statements in source order, each up to the next statement or label."""
    statements = compiled.source_map.statements
    cuts = sorted({s.offset for s in statements} | {label.offset for label in labels})
    ends = dict(zip(cuts, [*cuts[1:], len(code)], strict=True))
    pieces = []
    for statement in statements:
        text = code[statement.offset : ends[statement.offset]]
        before = code[statement.offset - statement.column + 1 : statement.offset]
        pieces.append(
            Piece(
                statement,
                tuple(word.upper() for word in _WORD.findall(text)),
                text,
                not before.strip() or before.rstrip().endswith(":"),
            )
        )
    return tuple(pieces)
