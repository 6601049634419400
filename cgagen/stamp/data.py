"""DATA by label: how many bytes each takes, checked against what the tokenizer stored.

The tokenizer does not report where its DATA labels are, so the statements are read here. What
was read must fill the very bytes that the image says are DATA; otherwise nothing is claimed,
and the report gives the total alone.
"""

import re
from dataclasses import dataclass

from cgagen.stamp.compiled import Compiled
from cgagen.stamp.image import Use

_NAMED = re.compile(r"^[ \t]*([A-Za-z_]\w*)[ \t]+(DATA|CON|PIN)\b[ \t]*(.*)$", re.IGNORECASE)
_PLAIN = re.compile(r"^[ \t]*()(DATA)\b[ \t]*(.*)$", re.IGNORECASE)
_TOKEN = re.compile(
    r"\s*(?:(?P<text>\"[^\"]*\")|(?P<hex>\$[0-9A-Fa-f]+)|(?P<bin>%[01]+)|(?P<dec>\d+)"
    r"|(?P<name>[A-Za-z_]\w*)|(?P<mark>//|<<|>>|[-+*/&|^@(),]))"
)
_OPERATORS = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a // b,
    "//": lambda a, b: a % b,
    "<<": lambda a, b: a << b,
    ">>": lambda a, b: a >> b,
    "&": lambda a, b: a & b,
    "|": lambda a, b: a | b,
    "^": lambda a, b: a ^ b,
}
"""Operators of constants, applied from left to right. Ref: S2 p. 103."""

_UNNAMED = "(no label)"


@dataclass(frozen=True, slots=True)
class DataBlock:
    """The bytes under one DATA label, those of the lines below it without a label included.

    Attributes:
        name: the label.
        line: its line, from 1.
        address: its first byte in the EEPROM.
        bytes: how many, reserved ones included.
    """

    name: str
    line: int
    address: int
    bytes: int


class _NotUnderstoodError(Exception):
    """A constant that this reader leaves to the tokenizer."""


def data_of(compiled: Compiled) -> tuple[DataBlock, ...] | None:
    """Return the DATA blocks in source order; None where they cannot be told apart."""
    symbols: dict[str, int] = {}
    filled: dict[int, Use] = {}
    found: list[tuple[str, int, int, set[int]]] = []
    pointer = 0
    try:
        for number, line in enumerate(re.split(r"\r\n|\r|\n", compiled.source), 1):
            match = _NAMED.match(_code_of(line)) or _PLAIN.match(_code_of(line))
            if match is None:
                continue
            name, kind, rest = match[1], match[2].upper(), match[3]
            if kind != "DATA":
                _define(symbols, name, rest)
                continue
            pieces, pointer = _items(rest, pointer, symbols)
            first = pieces[0][0] if pieces else pointer
            if name or not found:
                symbols[name.upper()] = first
                found.append((name or _UNNAMED, number, first, set()))
            found[-1][3].update(address for address, _ in pieces)
            filled.update(pieces)
    except _NotUnderstoodError:
        return None
    if filled != _stored(compiled):
        return None
    return tuple(DataBlock(name, line, first, len(held)) for name, line, first, held in found)


def _stored(compiled: Compiled) -> dict[int, Use]:
    flags = compiled.image.known_flags()
    kinds = (Use.RESERVED, Use.DATA)
    return {at: Use(flag & 3) for at, flag in enumerate(flags) if flag & 3 in kinds}


def _define(symbols: dict[str, int], name: str, rest: str) -> None:
    try:
        value, _ = _value(_tokens(rest), 0, symbols)
    except _NotUnderstoodError:
        return  # only matters if a DATA statement needs it
    symbols[name.upper()] = value


def _code_of(line: str) -> str:
    inside = False
    for place, char in enumerate(line):
        if char == '"':
            inside = not inside
        elif char == "'" and not inside:
            return line[:place]
    return line


def _tokens(text: str) -> list[str]:
    tokens, place = [], 0
    text = text.rstrip()
    while place < len(text):
        match = _TOKEN.match(text, place)
        if match is None:
            raise _NotUnderstoodError(text[place:])
        tokens.append(match[0].strip())
        place = match.end()
    return tokens


def _items(text: str, pointer: int, symbols: dict[str, int]) -> tuple[list[tuple[int, Use]], int]:
    """Return (address, use) of each byte that one DATA statement fills, and the next address."""
    tokens = [*_tokens(text), ","]
    filled: list[tuple[int, Use]] = []
    place = 0
    while place < len(tokens):
        width, times, use = 1, 1, Use.DATA
        if tokens[place] == "@":
            pointer, place = _value(tokens, place + 1, symbols)
            times = 0
        elif tokens[place] == "(":
            times, place = _value(tokens, place + 1, symbols)
            place, use = place + 1, Use.RESERVED
        else:
            if tokens[place].upper() in ("WORD", "BYTE"):
                width = 2 if tokens[place].upper() == "WORD" else 1
                place += 1
            if tokens[place].startswith('"') and len(tokens[place]) > 3:
                width, place = len(tokens[place]) - 2, place + 1
            elif tokens[place] == "(":
                use = Use.RESERVED
            else:
                _, place = _value(tokens, place, None)
            if tokens[place] == "(":
                times, place = _value(tokens, place + 1, symbols)
                place += 1
        if tokens[place] not in (",", "@"):
            raise _NotUnderstoodError(tokens[place])
        place += tokens[place] == ","
        filled += [(pointer + index, use) for index in range(width * times)]
        pointer += width * times
    return filled, pointer


def _value(tokens: list[str], place: int, symbols: dict[str, int] | None) -> tuple[int, int]:
    """Return the 16-bit value of a constant expression, and the place behind it.

    Without symbols the value does not matter, and any name may stand there (CR, a label below).
    """
    value, place = _operand(tokens, place, symbols)
    while place < len(tokens) and tokens[place] in _OPERATORS:
        other, after = _operand(tokens, place + 1, symbols)
        if tokens[place] in ("/", "//") and not other:
            raise _NotUnderstoodError("division by 0")
        value = _OPERATORS[tokens[place]](value, other) & 0xFFFF
        place = after
    return value, place


def _operand(tokens: list[str], place: int, symbols: dict[str, int] | None) -> tuple[int, int]:
    word = tokens[place] if place < len(tokens) else ""
    if word == "-":
        value, place = _operand(tokens, place + 1, symbols)
        return -value & 0xFFFF, place
    if word.startswith("$"):
        return int(word[1:], 16), place + 1
    if word.startswith("%"):
        return int(word[1:], 2), place + 1
    if word.isdigit():
        return int(word), place + 1
    if word.startswith('"') and len(word) == 3:
        return ord(word[1]), place + 1
    if symbols is None and word[:1].isalpha():
        return 1, place + 1
    if symbols is not None and word.upper() in symbols:
        return symbols[word.upper()], place + 1
    raise _NotUnderstoodError(word)
