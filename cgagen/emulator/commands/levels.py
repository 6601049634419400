"""What every instruction with pins does with them."""

from cgagen.emulator.clock import NEVER_NS
from cgagen.emulator.pins import Pins

FOREVER_NS = NEVER_NS
"""A time-out that never comes."""

LAST_PIN = 15
"""Ref: choice: a pin operand's low four bits count; the manual has no pin above 15."""


def drive(pins: Pins, pin: int, level: int) -> None:
    """Make a pin an output of this level; the latch first, so that the other level never shows."""
    mask = 1 << pin
    pins.set_latch(pins.latch | mask if level else pins.latch & ~mask)
    pins.set_directions(pins.directions | mask)


def release(pins: Pins, pin: int) -> None:
    """Make a pin an input."""
    pins.set_directions(pins.directions & ~(1 << pin))


def pull_low(pins: Pins, pin: int, low: bool) -> None:
    """Drive an open-collector line low, or let go of it."""
    if low:
        drive(pins, pin, 0)
    else:
        release(pins, pin)
