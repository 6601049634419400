"""Where a PBASIC program keeps its variables: the tokenizer's rule, applied to the source.

Words come first, then bytes, nibbles and bits, each size in the order of the source, from W0
up. A variable that names another one, or a part of it, is an alias and takes no room.
Ref: S2 p. 85 to 91; S3 for the order, asked in `tests/test_symbols.py`.
"""

import re
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from cgagen.stamp.conditional import live_text
from cgagen.stamp.constants import NotUnderstoodError, value_at, words_of
from cgagen.stamp.definitions import Definition, constants_of, definitions_of

FIRST_VARIABLE = 3
"""The word W0 of the register file. Ref: S2 p. 83, 85."""

SIZES = {"WORD": 16, "BYTE": 8, "NIB": 4, "BIT": 1}
_ARRAY = re.compile(r"(WORD|BYTE|NIB|BIT)\s*(?:\((.*)\))?", re.IGNORECASE)
_VARIABLE = re.compile(r"(\w+)((?:\s*\.\s*\w+)*)(?:\s*\(\s*(\d+)\s*\))?")


class Place(NamedTuple):
    """A variable: bits of one element, number of the first, how many there are."""

    size_bits: int
    element: int
    length: int


def _fixed() -> dict[str, Place]:
    words = {"INS": 0, "OUTS": 1, "DIRS": 2, **{f"W{n}": n + FIRST_VARIABLE for n in range(13)}}
    places = {name: Place(16, element, 1) for name, element in words.items()}
    places |= {f"B{n}": Place(8, n + 2 * FIRST_VARIABLE, 1) for n in range(26)}
    for word, base in (("IN", 0), ("OUT", 1), ("DIR", 2)):
        places |= {f"{word}L": Place(8, 2 * base, 1), f"{word}H": Place(8, 2 * base + 1, 1)}
        places |= {f"{word}{char}": Place(4, 4 * base + n, 1) for n, char in enumerate("ABCD")}
        places |= {f"{word}{n}": Place(1, 16 * base + n, 1) for n in range(16)}
    return places


FIXED = _fixed()
"""Places of the names that every chip has. Ref: S2 p. 83 to 85."""


def _modifiers() -> dict[str, tuple[int, int]]:
    """Return bits and number by modifier; -1 is the highest."""
    rows: dict[str, tuple[int, int]] = {}
    for word, bits in (("BYTE", 8), ("NIB", 4), ("BIT", 1)):
        rows |= {f"{word}{n}": (bits, n) for n in range(16 // bits)}
        rows |= {f"LOW{word}": (bits, 0), f"HIGH{word}": (bits, -1)}
    return rows


MODIFIERS = _modifiers()
"""Parts of a variable: size in bits, and which of them. Ref: S2 p. 90."""


def layout_of(source: str) -> dict[str, Place]:
    r"""Return the place of each variable, by its name in lower case.

    Raises:
        NotUnderstoodError: a definition that only the tokenizer understands.

    >>> layout_of("b VAR Bit\nw VAR Word(2)\nn VAR Nib ' nib\nalias VAR w.HIGHBYTE\n")["n"]
    Place(size_bits=4, element=20, length=1)
    """
    definitions = list(definitions_of(live_text(source)))
    return places_of(definitions, constants_of(definitions))


def places_of(definitions: Sequence[Definition], constants: Mapping[str, int]) -> dict[str, Place]:
    """Return the same from what was read of a source; constants by name in capitals.

    Raises:
        NotUnderstoodError: see `layout_of`.
    """
    places: dict[str, Place] = {}
    bit = FIRST_VARIABLE * 16
    variables = [one for one in definitions if one.kind == "VAR"]
    for size_bits in SIZES.values():
        for one in variables:
            found = _ARRAY.fullmatch(one.rest)
            if found is not None and SIZES[found[1].upper()] == size_bits:
                length = 1 if found[2] is None else _length(found[2], constants)
                places[one.name.lower()] = Place(size_bits, bit // size_bits, length)
                bit += size_bits * length
    for one in variables:
        if one.name.lower() not in places:
            target = place_in(places, one.rest)
            if target is None:
                raise NotUnderstoodError(one.rest)
            places[one.name.lower()] = target
    return places


def place_in(places: Mapping[str, Place], text: str) -> Place | None:
    """Return the place of a variable as a program writes it; None where there is none.

    Args:
        places: by name in lower case; the names that every chip has need not be in it.
        text: a name, a part of one, an element: `count`, `count.BIT3`, `row(2)`, `W0.HIGHBYTE`.

    >>> place_in({"row": Place(8, 10, 4)}, "row(2)"), place_in({}, "w1.BIT3")
    (Place(size_bits=8, element=12, length=1), Place(size_bits=1, element=67, length=1))
    """
    found = _VARIABLE.fullmatch(text.strip())
    place = found and (places.get(found[1].lower()) or FIXED.get(found[1].upper()))
    if found is None or place is None:
        return None
    for word in found[2].split(".")[1:]:
        bits, number = MODIFIERS.get(word.strip().upper(), (16, 0))
        parts = place.size_bits // bits
        if bits >= place.size_bits or number >= parts:
            return None
        place = Place(bits, place.element * parts + number % parts, 1)
    return place if found[3] is None else Place(place.size_bits, place.element + int(found[3]), 1)


def _length(text: str, constants: Mapping[str, int]) -> int:
    words = words_of(text)
    value, end = value_at(words, 0, constants)
    if end != len(words):
        raise NotUnderstoodError(text)
    return value
