"""DATA by label: how many bytes each takes, checked against what the tokenizer stored.

The tokenizer does not report where its DATA labels are, so the statements are read here. What
was read must fill the very bytes that the image says are DATA; otherwise nothing is claimed,
and the report gives the total alone.
"""

from dataclasses import dataclass

from cgagen.stamp.compiled import Compiled
from cgagen.stamp.conditional import live_text
from cgagen.stamp.constants import NotUnderstoodError, value_at, words_of
from cgagen.stamp.definitions import constants_of, definitions_of
from cgagen.stamp.image import Use

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


def data_of(compiled: Compiled) -> tuple[DataBlock, ...] | None:
    """Return the DATA blocks in source order; None where they cannot be told apart."""
    filled: dict[int, Use] = {}
    found: list[tuple[str, int, int, set[int]]] = []
    pointer = 0
    try:
        definitions = list(definitions_of(live_text(compiled.source)))
        symbols = constants_of(definitions)
        for one in definitions:
            if one.kind != "DATA":
                continue
            pieces, pointer = _items(one.rest, pointer, symbols)
            first = pieces[0][0] if pieces else pointer
            if one.name or not found:
                symbols[one.name.upper()] = first
                found.append((one.name or _UNNAMED, one.line, first, set()))
            found[-1][3].update(address for address, _ in pieces)
            filled.update(pieces)
    except NotUnderstoodError:
        return None
    if filled != _stored(compiled):
        return None
    return tuple(DataBlock(name, line, first, len(held)) for name, line, first, held in found)


def _stored(compiled: Compiled) -> dict[int, Use]:
    flags = compiled.image.known_flags()
    kinds = (Use.RESERVED, Use.DATA)
    return {at: Use(flag & 3) for at, flag in enumerate(flags) if flag & 3 in kinds}


def _items(text: str, pointer: int, symbols: dict[str, int]) -> tuple[list[tuple[int, Use]], int]:
    """Return (address, use) of each byte that one DATA statement fills, and the next address."""
    tokens = [*words_of(text), ","]
    filled: list[tuple[int, Use]] = []
    place = 0
    while place < len(tokens):
        width, times, use = 1, 1, Use.DATA
        if tokens[place] == "@":
            pointer, place = value_at(tokens, place + 1, symbols)
            times = 0
        elif tokens[place] == "(":
            times, place = value_at(tokens, place + 1, symbols)
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
                _, place = value_at(tokens, place, None)
            if tokens[place] == "(":
                times, place = value_at(tokens, place + 1, symbols)
                place += 1
        if tokens[place] not in (",", "@"):
            raise NotUnderstoodError(tokens[place])
        place += tokens[place] == ","
        filled += [(pointer + index, use) for index in range(width * times)]
        pointer += width * times
    return filled, pointer
