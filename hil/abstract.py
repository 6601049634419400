"""A register file of which only some is known: bits that are 0, 1, a sensor's, or anything.

A bit of a sensor's word has a number of its own, so that names that share RAM, copies and arrays
are followed bit by bit. Words 0 to 2 are the pins: INS, OUTS and DIRS.
"""

from collections.abc import Iterable
from typing import NamedTuple

UNKNOWN = 2
"""A bit that nothing has set."""

BITS = 256
OUTS_BIT, DIRS_BIT, VARIABLES_BIT = 16, 32, 48
"""Where these begin in the register file."""

_FIRST = 3


class Sensor(NamedTuple):
    """The word of a sensor, whatever it is."""

    number: int


Value = int | Sensor
Memory = tuple[int, ...]


class Refused(Exception):  # noqa: N818  never leaves the data-flow
    """What is done is not understood; the text says what."""


class Unset(Refused):
    """Bits are read that nothing has set.

    Attributes:
        bit: of the register file, the first that belongs to what is read.
    """

    def __init__(self, bit: int) -> None:
        super().__init__(f"bits are read that nothing has set, from {bit} of the register file on")
        self.bit = bit


def nothing_known() -> list[int]:
    """Return a register file in which all bits are unknown."""
    return [UNKNOWN] * BITS


def sensor_bits(number: int) -> range:
    """Return what stands for the bits of a sensor's word, from bit 0 on."""
    return range(_FIRST + 16 * number, _FIRST + 16 * number + 16)


def place_of(element: int, size_bits: int) -> int:
    """Return the first bit of an element; one past the end wraps, as on the chip."""
    return element * size_bits & BITS - 1


def read(memory: Memory, size_bits: int, element: int, names: tuple[str, ...]) -> Value:
    """Return what is in an element.

    Args:
        memory: the register file.
        size_bits: 1, 4, 8 or 16.
        element: its number.
        names: of the sensors.

    Raises:
        Refused: it is neither a number nor a sensor's whole word.
    """
    first = place_of(element, size_bits)
    bits = memory[first : first + size_bits]
    if first < OUTS_BIT:
        raise Refused("pins are read")
    if max(bits) < UNKNOWN:
        return sum(bit << n for n, bit in enumerate(bits))
    number, rest = divmod(bits[0] - _FIRST, 16)
    if bits[0] >= _FIRST and size_bits == 16 and not rest and bits == tuple(sensor_bits(number)):
        return Sensor(number)
    parts = sorted({(bit - _FIRST) >> 4 for bit in bits if bit >= _FIRST})
    if parts:
        raise Refused(f"a part of {names[parts[0]]} is read")
    raise Unset(first)


def written(memory: Memory, size_bits: int, element: int, value: Value | None) -> Memory:
    """Return the register file with a value in an element; None for one that is unknown."""
    first = place_of(element, size_bits)
    if first < OUTS_BIT:
        return memory
    bits: Iterable[int]
    if value is None:
        bits = [UNKNOWN] * size_bits
    elif isinstance(value, Sensor):
        bits = sensor_bits(value.number)[:size_bits]
    else:
        bits = (value >> n & 1 for n in range(size_bits))
    return (*memory[:first], *bits, *memory[first + size_bits :])
