"""PULSOUT, PULSIN, RCTIME and COUNT: one pin and a stopwatch.

Ref: S2 p. 343 to 351, 363 to 367, 149; S9 (1.8) p. 289 to 292.
"""

from cgagen.emulator.commands.levels import LAST_PIN, release
from cgagen.emulator.port import Port, Result
from cgagen.emulator.requests import Command, Delay, Until

LONGEST_COUNT = 0xFFFF
OVERFLOW = 0
"""What PULSIN and RCTIME return when nothing was measured. Ref: S2 p. 343, 363."""


def pulsout(port: Port, *, duration: int, pin: int) -> Command[Result]:
    """Make the pin an output, invert its latch, wait, invert it back.

    A duration of 0 gives no pulse (choice).
    """
    pins, mask = port.pins, 1 << (pin & LAST_PIN)
    if not pins.directions & mask:
        pins.set_directions(pins.directions | mask)
        yield Delay(port.timing.pulsout_glitch_ns)
    if duration:
        pins.set_latch(pins.latch ^ mask)
        yield Delay(duration * port.timing.pulsout_ns)
        pins.set_latch(pins.latch ^ mask)
    return None


def pulsin(port: Port, *, state: int, pin: int) -> Command[Result]:
    """Measure a pulse in whole units.

    It must begin while the instruction runs: a pin that has the level already must lose it first.
    Both the wait for the beginning and the pulse itself may last 65,535 units.
    """
    pin, state = pin & LAST_PIN, state & 1
    unit_ns = port.timing.pulsin_ns
    left_ns = LONGEST_COUNT * unit_ns
    release(port.pins, pin)
    for level in (1 - state, state):
        waited_ns = yield Until(pin, level, left_ns)
        if waited_ns is None:
            return OVERFLOW
        left_ns -= waited_ns
    width_ns = yield Until(pin, 1 - state, (LONGEST_COUNT + 1) * unit_ns - 1)
    return OVERFLOW if width_ns is None else _count(width_ns, unit_ns)


def rctime(port: Port, *, state: int, pin: int) -> Command[Result]:
    """Measure how long the pin keeps a level that it has; 1 where it has not. Ref: S2 p. 363."""
    pin, state = pin & LAST_PIN, state & 1
    unit_ns = port.timing.rctime_ns
    release(port.pins, pin)
    if port.pins.level(pin) != state:
        return 1
    kept_ns = yield Until(pin, 1 - state, (LONGEST_COUNT + 1) * unit_ns - 1)
    return OVERFLOW if kept_ns is None else _count(kept_ns, unit_ns)


def count(port: Port, *, duration: int, pin: int) -> Command[Result]:
    """Count changes of the pin, two of which are a cycle.

    The pin is looked at once in every shortest pulse; what is over before the next look was not
    there. A duration of 0 counts nothing (choice).
    """
    pin = pin & LAST_PIN
    step_ns, all_ns = port.timing.count_pulse_ns, duration * port.timing.count_ns
    release(port.pins, pin)
    known = port.pins.level(pin)
    changes = now_ns = 0
    while True:
        waited_ns = yield Until(pin, 1 - known, all_ns - now_ns)
        if waited_ns is None:
            return changes // 2
        now_ns += waited_ns
        look_ns = -now_ns % step_ns
        if now_ns + look_ns > all_ns:
            yield Delay(all_ns - now_ns)
            return changes // 2
        if look_ns:
            yield Delay(look_ns)
            now_ns += look_ns
        level = port.pins.level(pin)
        changes += level != known
        known = level


def _count(passed_ns: int, unit_ns: int) -> int:
    """Return whole units, 1 at least. Ref: S9 (1.8) p. 289 (1 to 65535), S2 p. 363."""
    return max(1, passed_ns // unit_ns)
