"""XOUT: X-10 commands over the mains, in step with its zero crossings.

Ref: S2 p. 465 to 468 for the instruction; X-10's rules for the PL513 and TW523 for the signal.
"""

from itertools import chain, repeat

from cgagen.emulator.commands.levels import FOREVER_NS, LAST_PIN, drive, release
from cgagen.emulator.port import Items, Port, Result
from cgagen.emulator.requests import Command, Delay, Until
from cgagen.emulator.timing import X10

START = (1, 1, 1, 0)
"""Sent without complements, one bit at a crossing."""

_CODES = "0110 1110 0010 1010 0001 1001 0101 1101 0111 1111 0011 1011 0000 1000 0100 1100".split()
"""Houses A to P, and keys 1 to 16. Commands use the same codes: UNITON is %10010, entry 2 with
the fifth bit set, and On is 0010 1 on the line."""

_KEY_BITS = 5


def xout(port: Port, items: Items, *, pin: int, zero_pin: int) -> Command[Result]:
    """Send each command as often as it says, without gaps, and three periods of silence behind it.

    Every change of the zero-crossing pin is a crossing. Where it never changes, the instruction
    waits for ever (Ref: S2 p. 465).
    """
    pin, zero_pin = pin & LAST_PIN, zero_pin & LAST_PIN
    drive(port.pins, pin, 0)
    release(port.pins, zero_pin)
    known = port.pins.level(zero_pin)
    for item in items:
        yield Delay(item.fetch_ns)
        code, inverted_cycles = item.values()
        frames = repeat(frame(code), ~inverted_cycles & 0xFFFF)
        for bit in chain(chain.from_iterable(frames), repeat(0, X10.gap_crossings)):
            yield Until(zero_pin, 1 - known, FOREVER_NS)
            known = 1 - known
            if bit:
                yield from _bursts(port, pin)
    return None


def frame(code: int) -> tuple[int, ...]:
    """Return what goes out at 22 crossings.

    Args:
        code: house + 16 * key; 16 * 16 is the bit that makes a command of a key. Ref: S3.

    >>> "".join(map(str, frame(0 + 16 * 1)))
    '1110011010011010100101'
    """
    house, key = code & 15, code >> 4 & 31
    bits = [int(bit) for bit in _CODES[house] + _CODES[key & 15]] + [key >> _KEY_BITS - 1]
    return START + tuple(half for bit in bits for half in (bit, 1 - bit))


def _bursts(port: Port, pin: int) -> Command[None]:
    for burst in range(X10.bursts):
        drive(port.pins, pin, 1)
        yield Delay(X10.burst_ns)
        drive(port.pins, pin, 0)
        if burst < X10.bursts - 1:
            yield Delay(X10.spacing_ns - X10.burst_ns)
