"""SHIFTOUT and SHIFTIN: bits with a clock of the chip's own.

Ref: S2 p. 431 to 440; S9 (1.8) p. 330, 333 for the order of events.
"""

from cgagen.emulator.commands.levels import LAST_PIN, drive, release
from cgagen.emulator.pins import Pins
from cgagen.emulator.port import Inputs, Items, Port, Result
from cgagen.emulator.requests import Command, Delay
from cgagen.emulator.timing import Timing

MSB_FIRST_OUT = 1
"""Mode bit of SHIFTOUT: LSBFIRST is 0, MSBFIRST 1. Ref: S2 p. 436."""

LSB_FIRST_IN = 1
AFTER_CLOCK = 2
"""Mode bits of SHIFTIN: MSBPRE 0, LSBPRE 1, MSBPOST 2, LSBPOST 3. Ref: S2 p. 432."""

MOST_BITS = 16


def shiftout(
    port: Port, items: Items, *, mode: int, data_pin: int, clock_pin: int
) -> Command[Result]:
    """Put the low bits of each value on the data pin, each with a clock pulse behind it.

    No bits are sent for a count of 0, and 16 for one above 16 (choice).
    """
    data_pin, clock_pin = data_pin & LAST_PIN, clock_pin & LAST_PIN
    pins, timing = port.pins, port.timing
    drive(pins, clock_pin, 0)
    gap_ns, setup_ns = timing.shift_setup_ns, timing.shift_setup_ns
    for item in items:
        yield Delay(item.fetch_ns)
        count, value = item.values()
        for place in _places(count, bool(mode & MSB_FIRST_OUT)):
            yield Delay(gap_ns)
            drive(pins, data_pin, value >> place & 1)
            yield Delay(setup_ns)
            yield from _clock_high(pins, timing, clock_pin)
            gap_ns, setup_ns = timing.shift_hold_ns, timing.shift_low_ns - timing.shift_hold_ns
    return None


def shiftin(
    port: Port, items: Inputs, *, mode: int, data_pin: int, clock_pin: int
) -> Command[Result]:
    """Read bits just before each clock pulse, or behind it half-way to the next (choice).

    Fewer than 8 bits end up in the low places in either order (choice for LSB first).
    """
    data_pin, clock_pin = data_pin & LAST_PIN, clock_pin & LAST_PIN
    pins, timing = port.pins, port.timing
    drive(pins, clock_pin, 0)
    release(pins, data_pin)
    gap_ns = 2 * timing.shift_setup_ns
    for item in items:
        yield Delay(item.fetch_ns)
        count, value = item.values()
        for place in _places(count, not mode & LSB_FIRST_IN):
            yield Delay(gap_ns)
            gap_ns = timing.shift_low_ns
            if mode & AFTER_CLOCK:
                yield from _clock_high(pins, timing, clock_pin)
                yield Delay(gap_ns // 2)
                gap_ns -= gap_ns // 2
                value |= pins.level(data_pin) << place
            else:
                value |= pins.level(data_pin) << place
                yield from _clock_high(pins, timing, clock_pin)
        item.store(value)
    return None


def _places(count: int, msb_first: bool) -> range:
    """Return the places of the bits in their order on the wire."""
    count = min(count, MOST_BITS)
    return range(count - 1, -1, -1) if msb_first else range(count)


def _clock_high(pins: Pins, timing: Timing, clock_pin: int) -> Command[None]:
    drive(pins, clock_pin, 1)
    yield Delay(timing.shift_high_ns)
    drive(pins, clock_pin, 0)
