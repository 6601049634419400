"""What a baud word says, and bytes as the bits of a line.

Ref: S2 p. 395 to 399, 419 for the word; S9 (1.8) p. 325 for open lines.
"""

from typing import NamedTuple

from cgagen.emulator.commands.levels import LAST_PIN, drive, release
from cgagen.emulator.pins import SIN, Pins
from cgagen.emulator.timing import Timing

PERIOD = 0x1FFF
SEVEN_EVEN = 0x2000
INVERTED = 0x4000
OPEN = 0x8000

EXTRA_UNITS = 20
"""The bit time is so much longer than the word says. Ref: S2 p. 419, 431."""

MARK = 1
SPACE = 0


class Line(NamedTuple):
    """A line as one serial instruction sees it.

    Attributes:
        pin: 0 to 15, or the programming port.
        bit_ns: one bit.
        seven_even: seven data bits and even parity instead of eight data bits.
        inverted: a mark is low.
        is_open: a mark is not driven; the programming port does not care.
        flow_go: the level of the flow pin that permits to send.
    """

    pin: int
    bit_ns: int
    seven_even: bool
    inverted: bool
    is_open: bool
    flow_go: int

    def level(self, bit: int) -> int:
        """Return the level of a bit on the wire."""
        return bit ^ self.inverted


def line_of(timing: Timing, baud: int, pin: int) -> Line:
    """Take a baud word apart. The programming port is always inverted and driven.

    Its flow pin still follows bit 14 of the word (Ref: S9 (0.94) p. 60).
    """
    port = bool(pin & SIN)
    return Line(
        pin=SIN if port else pin & LAST_PIN,
        bit_ns=((baud & PERIOD) + EXTRA_UNITS) * timing.serial_unit_ns,
        seven_even=bool(baud & SEVEN_EVEN),
        inverted=port or bool(baud & INVERTED),
        is_open=bool(baud & OPEN),
        flow_go=int(bool(baud & INVERTED)),
    )


def set_line(pins: Pins, line: Line, bit: int) -> None:
    """Put a mark or a space on the line."""
    if line.pin == SIN:
        pins.send(line.level(bit))
    elif line.is_open and bit == MARK:
        release(pins, line.pin)
    else:
        drive(pins, line.pin, line.level(bit))


def data_bits(byte: int, seven_even: bool) -> int:
    """Return the eight bits behind the start bit, the first of them lowest.

    >>> bin(data_bits(0b0011010, seven_even=True))
    '0b10011010'
    """
    if not seven_even:
        return byte
    byte &= 0x7F
    return byte | (byte.bit_count() & 1) << 7
