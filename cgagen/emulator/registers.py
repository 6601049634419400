"""The register file: 16 words that are read and written in four sizes, three of them pins.

Word 0 is INS, word 1 OUTS, word 2 DIRS, words 3 to 15 are W0 to W12. Elements of a size count
from bit 0 of INS: byte 6 is the low byte of W0. Ref: S2 p. 82 to 85, S3.

An element past the end wraps to the start, as its number has just bits enough for the file; a
write to INS does nothing. Ref: choice, both.
"""

from cgagen.emulator.pins import Pins
from cgagen.stamp.layout import FIRST_VARIABLE, FIXED

__all__ = ["DIRS", "ELEMENTS", "FIRST_VARIABLE", "INS", "OUTS", "WORDS", "Registers", "element_of"]

WORDS = 16
INS, OUTS, DIRS = range(3)
ELEMENTS = {1: 256, 4: 64, 8: 32, 16: 16}
"""How many elements of a size there are. Ref: S3."""

_WORD = 0xFFFF


class Registers:
    """The register file of one chip.

    Args:
        pins: whose levels, latch and directions words 0 to 2 are.

    Attributes:
        pins: see above; a chip with an auxiliary port changes them.
        words: the words; 0 to 2 are always 0 here, use `read`.

    >>> registers = Registers(Pins("demo"))
    >>> registers.write(16, 3, 0x1234); registers.read(8, 7), registers.read(4, 12)
    (18, 4)
    """

    __slots__ = ("pins", "words")

    def __init__(self, pins: Pins) -> None:
        self.pins = pins
        self.words = [0] * WORDS

    def read(self, size_bits: int, element: int) -> int:
        """Return an element.

        Args:
            size_bits: 1, 4, 8 or 16.
            element: its number; wraps.
        """
        place = element * size_bits
        index = place >> 4 & 15
        if index >= FIRST_VARIABLE:
            word = self.words[index]
        elif index == OUTS:
            word = self.pins.latch
        elif index == DIRS:
            word = self.pins.directions
        elif size_bits == 1:
            return self.pins.level(place & 15)
        else:
            word = self.pins.levels((1 << size_bits) - 1 << (place & 15))
        return word >> (place & 15) & (1 << size_bits) - 1

    def write(self, size_bits: int, element: int, value: int) -> None:
        """Store a value, cut to the element's size.

        Args:
            size_bits: 1, 4, 8 or 16.
            element: its number; wraps.
            value: any number.
        """
        place = element * size_bits
        index, shift = place >> 4 & 15, place & 15
        mask = (1 << size_bits) - 1 << shift
        stored = value << shift & mask
        if index >= FIRST_VARIABLE:
            self.words[index] = self.words[index] & (mask ^ _WORD) | stored
        elif index == OUTS:
            self.pins.set_latch(self.pins.latch & (mask ^ _WORD) | stored)
        elif index == DIRS:
            self.pins.set_directions(self.pins.directions & (mask ^ _WORD) | stored)

    def read_byte(self, element: int) -> int:
        """Return a byte; 6 is B0."""
        return self.read(8, element)

    def write_byte(self, element: int, value: int) -> None:
        """Store a byte; 6 is B0."""
        self.write(8, element, value)

    def __getitem__(self, name: str) -> int:
        """Return a register by one of its fixed names; see `element_of`.

        Raises:
            KeyError: there is no such register.
        """
        return self.read(*element_of(name))

    def __setitem__(self, name: str, value: int) -> None:
        """Store a value in a register by its name.

        Raises:
            KeyError: there is no such register.
        """
        self.write(*element_of(name), value)


def element_of(name: str) -> tuple[int, int]:
    """Return size in bits and number of a register with a fixed name, upper or lower case.

    Raises:
        KeyError: there is none.

    >>> element_of("B3"), element_of("OUTA")
    ((8, 9), (4, 4))
    """
    place = FIXED[name.upper()]
    return place.size_bits, place.element
