"""PWM, FREQOUT and DTMFOUT: analog values and tones out of one digital pin.

Ref: S2 p. 355, 199, 179; S7 (BS2PWM) for the 256 slots of a cycle of PWM. The chip makes tones by
the same fast pulses as PWM. Here a tone is a square wave that is high while the sine, or the sum
of both sines, is above zero (choice): it has the right frequency, and one edge where the chip has
hundreds.
"""

from cgagen.emulator.commands.levels import LAST_PIN, drive, release
from cgagen.emulator.pins import Pins
from cgagen.emulator.port import Items, Port, Result
from cgagen.emulator.requests import Command, Delay

PWM_SLOTS = 256
_BYTE = 0xFF

_MILLI_NS = 10**12
"""Nanoseconds in a second, times the millihertz in a hertz."""

DTMF_KEYS = "0123456789*#ABCD"
"""Ref: S2 p. 180: tones 0 to 9 are the digits, 10 star, 11 pound, 12 to 15 the fourth column."""

_ROWS_HZ = {"123A": 697, "456B": 770, "789C": 852, "*0#D": 941}
_COLUMNS_HZ = {"147*": 1209, "2580": 1336, "369#": 1477, "ABCD": 1633}


def pwm(port: Port, *, duty: int, duration: int, pin: int) -> Command[Result]:
    """Let the pin be high in `duty` of 256 slots, as evenly as can be; it ends as an input.

    Duration and duty are the low bytes (choice; S2 gives 0 to 255 as their range). The latch keeps
    the last level (choice).
    """
    pin, duty = pin & LAST_PIN, duty & _BYTE
    cycle_ns = port.timing.pwm_ns
    runs = _runs(duty)
    for _ in range(duration & _BYTE):
        start_slot = 0
        for end_slot, level in runs:
            drive(port.pins, pin, level)
            yield Delay(cycle_ns * end_slot // PWM_SLOTS - cycle_ns * start_slot // PWM_SLOTS)
            start_slot = end_slot
    release(port.pins, pin)
    return None


def _runs(duty: int) -> list[tuple[int, int]]:
    """Return the slots of a cycle as runs: where each ends, and its level."""
    runs: list[tuple[int, int]] = []
    for slot in range(PWM_SLOTS):
        level = duty * (slot + 1) // PWM_SLOTS - duty * slot // PWM_SLOTS
        if runs and runs[-1][1] == level:
            runs[-1] = (slot + 1, level)
        else:
            runs.append((slot + 1, level))
    return runs


def freqout(
    port: Port, *, pin: int, duration: int, frequency: int, second: int = 0
) -> Command[Result]:
    """Send a tone, or two mixed; the pin ends as an output and low (choice).

    Frequencies are taken as they are asked for, also above 32,767, where the chip sends other
    tones besides.
    """
    unit = port.timing.freqout_millihertz
    yield from _tones(
        port.pins,
        pin & LAST_PIN,
        duration * port.timing.freqout_ns,
        (frequency * unit, second * unit),
    )
    return None


def dtmfout(port: Port, items: Items, *, pin: int, off_time: int, on_time: int) -> Command[Result]:
    """Send telephone tones, each with a pause behind it; the pin ends as an input.

    The pause is low (choice). A tone's low four bits count (choice).
    """
    pin = pin & LAST_PIN
    for item in items:
        yield Delay(item.fetch_ns)
        (key,) = item.values()
        on_ns = on_time * port.timing.dtmf_on_ns
        yield from _tones(port.pins, pin, on_ns, dtmf_millihertz(key))
        yield Delay(off_time * port.timing.dtmf_off_ns)
    release(port.pins, pin)
    return None


def dtmf_millihertz(tone: int) -> tuple[int, int]:
    """Return the two frequencies of a telephone key. Ref: ITU-T Q.23.

    >>> dtmf_millihertz(10)
    (941000, 1209000)
    """
    key = DTMF_KEYS[tone & 15]
    row, column = (
        next(hertz for keys, hertz in table.items() if key in keys)
        for table in (_ROWS_HZ, _COLUMNS_HZ)
    )
    return row * 1000, column * 1000


def _tones(pins: Pins, pin: int, all_ns: int, millihertz: tuple[int, int]) -> Command[None]:
    """Drive the pin with the sign of the sum of up to two sines, then low."""
    now_ns, level = 0, 1
    edges = Edges([tone for tone in millihertz if tone])
    if not edges.silent:
        while now_ns < all_ns:
            drive(pins, pin, level)
            next_ns = min(edges.pop_ns(), all_ns)
            yield Delay(next_ns - now_ns)
            now_ns, level = next_ns, 1 - level
    drive(pins, pin, 0)
    if now_ns < all_ns:
        yield Delay(all_ns - now_ns)


class Edges:
    """When the sum of one or two sines that start at 0 changes its sign.

    sin a + sin b = 2 sin((a + b) / 2) cos((a - b) / 2): the zeros of both factors, and both are
    evenly spaced.

    Attributes:
        silent: there is no sine.
    """

    __slots__ = ("_combs", "silent")

    def __init__(self, millihertz: list[int]) -> None:
        first, second = (*millihertz, *millihertz)[:2] if millihertz else (0, 0)
        # Each comb: hertz of its zeros, and of which half of one the next is.
        self._combs = [[first + second, 2], [abs(first - second), 1]]
        self._combs = [comb for comb in self._combs if comb[0]]
        self.silent = not self._combs

    def pop_ns(self) -> int:
        """Return the next change, from the beginning of the tone."""
        comb = min(self._combs, key=_when_ns)
        at_ns = _when_ns(comb)
        comb[1] += 2
        return at_ns


def _when_ns(comb: list[int]) -> int:
    return comb[1] * _MILLI_NS // (2 * comb[0])
