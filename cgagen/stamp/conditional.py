"""Conditional compilation: which text of a source the tokenizer sees.

The rules were found by asking the tokenizer (Ref: S3, `tests/test_symbols.py` asks it again):
arithmetic ranks over comparisons, these over NOT, that over AND, OR and XOR; each rank goes from
left to right on 16 bits; true is 65,535, and so is a #DEFINE without a value; a name that was
never defined is 0; `$STAMP` compares as the number of the model.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass, field

from cgagen.stamp.constants import (
    CONTROL,
    OPERATORS,
    NotUnderstoodError,
    applied,
    operand_at,
    words_of,
)

TRUE = 0xFFFF

_MODELS = {"BS2": 2, "BS2E": 3, "BS2SX": 4, "BS2P": 5, "BS2PE": 6}
_STAMP = re.compile(r"'[ \t]*\{[ \t]*\$STAMP[ \t]+(\w+)", re.IGNORECASE)
_LANGUAGE = re.compile(r"'[ \t]*\{[ \t]*\$PBASIC[ \t]+(\d)\.(\d)", re.IGNORECASE)
_PIECE = re.compile(r"\"[^\"\r\n]*\"?|'[^\r\n]*|#[A-Za-z]+|\r\n|[\s\S]", re.IGNORECASE)
_COMPARISONS: dict[str, Callable[[int, int], bool]] = {
    "=": lambda a, b: a == b,
    "<>": lambda a, b: a != b,
    "><": lambda a, b: a != b,
    "<": lambda a, b: a < b,
    ">": lambda a, b: a > b,
    "<=": lambda a, b: a <= b,
    "=<": lambda a, b: a <= b,
    ">=": lambda a, b: a >= b,
    "=>": lambda a, b: a >= b,
}
_LOGIC: dict[str, Callable[[int, int], int]] = {
    "AND": lambda a, b: a & b,
    "OR": lambda a, b: a | b,
    "XOR": lambda a, b: a ^ b,
}


class _Names(dict[str, int]):
    """Values of names; a name that was never defined is 0."""

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and (name[:1].isalpha() or name[:1] == "_")

    def __missing__(self, name: str) -> int:
        return 0


@dataclass(slots=True)
class _Level:
    """A #IF or #SELECT that is open.

    Attributes:
        outside: the text around it is seen.
        live: the text that is being read is.
        done: one of its branches was seen.
        chosen: what #SELECT compares with; None for #IF.
    """

    outside: bool
    live: bool
    done: bool
    chosen: int | None = None


@dataclass(slots=True)
class _Reader:
    names: _Names
    levels: list[_Level] = field(default_factory=list)

    @property
    def live(self) -> bool:
        return not self.levels or self.levels[-1].live

    def directive(self, word: str, rest: str) -> None:
        """Take a directive with what stands behind it."""
        match word:
            case "#DEFINE" if self.live:
                name, _, value = rest.partition("=")
                self.names[name.strip().upper()] = self._value(value) if value else TRUE
            case "#IF":
                truth = self.live and bool(self._value(rest))
                self.levels.append(_Level(self.live, truth, truth))
            case "#SELECT":
                chosen = self._value(rest) if self.live else 0
                self.levels.append(_Level(self.live, False, False, chosen))
            case "#CASE" | "#ELSE":
                level = self._open()
                level.live = level.outside and not level.done and self._meets(word, rest, level)
                level.done |= level.live
            case "#ENDIF" | "#ENDSELECT":
                self._open()
                self.levels.pop()

    def _open(self) -> _Level:
        if not self.levels:
            raise NotUnderstoodError("a directive without its beginning")
        return self.levels[-1]

    def _meets(self, word: str, rest: str, level: _Level) -> bool:
        if word == "#ELSE" or not rest.strip():  # #CASE #ELSE has nothing between
            return True
        return any(self._is_case(words, level.chosen or 0) for words in _split(words_of(rest)))

    def _is_case(self, words: list[str], chosen: int) -> bool:
        upper = [word.upper() for word in words]
        if words and words[0] in _COMPARISONS:
            return _COMPARISONS[words[0]](chosen, self._all(words[1:]))
        if "TO" in upper:
            middle = upper.index("TO")
            return self._all(words[:middle]) <= chosen <= self._all(words[middle + 1 :])
        return self._all(words) == chosen

    def _value(self, text: str) -> int:
        return self._all(words_of(text))

    def _all(self, words: list[str]) -> int:
        value, place = self._logic(words, 0)
        if place != len(words):
            raise NotUnderstoodError(words[place])
        return value

    def _logic(self, words: list[str], place: int) -> tuple[int, int]:
        value, place = self._negated(words, place)
        while place < len(words) and words[place].upper() in _LOGIC:
            other, after = self._negated(words, place + 1)
            value, place = _LOGIC[words[place].upper()](value, other), after
        return value, place

    def _negated(self, words: list[str], place: int) -> tuple[int, int]:
        if place < len(words) and words[place].upper() == "NOT":
            value, place = self._negated(words, place + 1)
            return value ^ TRUE, place
        value, place = self._sum(words, place)
        while place < len(words) and words[place] in _COMPARISONS:
            other, after = self._sum(words, place + 1)
            value, place = TRUE * _COMPARISONS[words[place]](value, other), after
        return value, place

    def _sum(self, words: list[str], place: int) -> tuple[int, int]:
        value, place = self._operand(words, place)
        while place < len(words) and words[place] in OPERATORS:
            other, after = self._operand(words, place + 1)
            value, place = applied(words[place], value, other), after
        return value, place

    def _operand(self, words: list[str], place: int) -> tuple[int, int]:
        word = words[place].upper() if place < len(words) else ""
        if word == "(":
            value, place = self._logic(words, place + 1)
            if place >= len(words) or words[place] != ")":
                raise NotUnderstoodError("a bracket that is not closed")
            return value, place + 1
        if word in ("$STAMP", "$PBASIC"):
            return self.names[word], place + 1
        return operand_at(words, place, self.names)


def live_text(source: str) -> str:
    r"""Return what of a source is compiled, every place as it was, all else as blanks.

    Comments, directives and the branches that are not taken are blank; line ends stay.

    Raises:
        NotUnderstoodError: a condition that only the tokenizer understands.

    >>> live_text("#IF 1 #THEN\nHIGH 3 ' on\n#ELSE\nLOW 3\n#ENDIF\n").split()
    ['HIGH', '3']
    """
    stamp, language = _STAMP.search(source), _LANGUAGE.search(source)
    names = _Names(CONTROL | _MODELS)
    names["$STAMP"] = _MODELS.get(stamp[1].upper(), 0) if stamp else 0
    names["$PBASIC"] = int(language[1] + language[2] + "0") if language else 200
    reader, pieces = _Reader(names), _PIECE.findall(source)
    out: list[str] = []
    index = 0
    while index < len(pieces):
        piece = pieces[index]
        if piece.startswith("#") and len(piece) > 1:
            word, after = piece.upper(), _end_of_directive(pieces, index)
            text = "".join(pieces[index + 1 : after])
            reader.directive(word, text)
            out.append(" " * sum(map(len, pieces[index:after])))
            index = after
            continue
        kept = piece in ("\r", "\n", "\r\n") or (reader.live and not piece.startswith("'"))
        out.append(piece if kept else " " * len(piece))
        index += 1
    return "".join(out)


def _end_of_directive(pieces: list[str], index: int) -> int:
    """Return the index behind a directive and what belongs to it."""
    word = pieces[index].upper()
    after = index + 1
    if word == "#CASE":
        while after < len(pieces) and pieces[after] in " \t":
            after += 1
        if after < len(pieces) and pieces[after].upper() == "#ELSE":
            pieces[after] = " " * len(pieces[after])
            return after + 1
    if word in ("#DEFINE", "#IF", "#SELECT", "#CASE", "#ERROR"):
        while after < len(pieces) and not _ends(pieces[after]):
            after += 1
        if word == "#IF" and after < len(pieces) and pieces[after].upper() == "#THEN":
            pieces[after] = " " * len(pieces[after])
            return after + 1
    return after


def _ends(piece: str) -> bool:
    return piece in ("\r", "\n", "\r\n", ":") or piece[0] in "'#"


def _split(words: list[str]) -> list[list[str]]:
    """Return the words between commas."""
    parts: list[list[str]] = [[]]
    for word in words:
        if word == ",":
            parts.append([])
        else:
            parts[-1].append(word)
    return parts
