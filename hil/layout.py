"""Where a PBASIC program keeps its variables: the tokenizer's rule, applied to the source.

Words come first, then bytes, nibbles and bits, each size in the order of the source, from W0
up. A variable that names another one is an alias and takes no room. Ref: S2 p. 88.
"""

import re
from typing import NamedTuple

from cgagen.emulator.registers import FIRST_VARIABLE

SIZES = {"WORD": 16, "BYTE": 8, "NIB": 4, "BIT": 1}
_VARIABLE = re.compile(
    r"^(\w+)[ \t]+VAR[ \t]+(Word|Byte|Nib|Bit)(?:\((\d+)\))?[ \t]*(?:'|$)", re.M | re.I
)


class Place(NamedTuple):
    """A variable: bits of one element, number of the first, how many there are."""

    size_bits: int
    element: int
    length: int


def layout_of(source: str) -> dict[str, Place]:
    r"""Return the place of each variable, by its name in lower case.

    >>> layout_of("b VAR Bit\nw VAR Word(2)\nn VAR Nib ' nib\nalias VAR w\n")["n"]
    Place(size_bits=4, element=20, length=1)
    """
    rows = [
        (name.lower(), SIZES[size.upper()], int(length or 1))
        for name, size, length in _VARIABLE.findall(source)
    ]
    places, bit = {}, FIRST_VARIABLE * 16
    for size_bits in SIZES.values():
        for name, size, length in rows:
            if size == size_bits:
                places[name] = Place(size, bit // size, length)
                bit += size * length
    return places


def line_of_label(source: str, label: str) -> int | None:
    """Return the line, from 1, on which a label stands; None where it is missing."""
    found = re.search(rf"^{label}:", source, re.M | re.I)
    return source.count("\n", 0, found.start()) + 1 if found else None
