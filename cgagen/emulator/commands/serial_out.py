"""SEROUT, which DEBUG is too: serial output with pace, or with a flow pin and a time-out.

Ref: S2 p. 415 to 429.
"""

from functools import lru_cache
from itertools import groupby

from cgagen.emulator.commands.levels import FOREVER_NS, LAST_PIN, release
from cgagen.emulator.commands.lists import bytes_of
from cgagen.emulator.commands.serial_line import MARK, SPACE, Line, data_bits, line_of, set_line
from cgagen.emulator.pins import SIN, Pins
from cgagen.emulator.port import Items, Jump, Port, Result
from cgagen.emulator.requests import Command, Delay, Until


def serout(port: Port, items: Items, *, baud: int, pin: int, pace: int = 0) -> Command[Result]:
    """SEROUT and DEBUG.

    The pin becomes an output and stays one; on an open line it ends as an input. The pace is a
    pause between bytes, not before the first.
    """
    line = line_of(port.timing, baud, pin)
    pause_ns = pace * port.timing.serout_pace_ns
    set_line(port.pins, line, MARK)
    sent = False
    for item in items:
        yield Delay(item.fetch_ns)
        for byte in bytes_of(port, item.values()):
            if sent and pause_ns:
                yield Delay(pause_ns)
            yield from send_byte(port.pins, line, byte)
            sent = True
    return None


def serout_flow(
    port: Port,
    items: Items,
    *,
    baud: int,
    pin: int,
    flow_pin: int,
    timeout: int = 0,
    timeout_target: int | None = None,
) -> Command[Result]:
    r"""SEROUT pin\fpin: permission is waited for before each byte.

    With a label the wait for each byte is bounded; when it ends, the rest of the list is not sent.
    """
    line = line_of(port.timing, baud, pin)
    wait_ns = FOREVER_NS
    if timeout_target is not None:
        wait_ns = timeout * port.timing.serout_timeout_ns
    release(port.pins, flow_pin & LAST_PIN)
    set_line(port.pins, line, MARK)
    for item in items:
        yield Delay(item.fetch_ns)
        for byte in bytes_of(port, item.values()):
            granted = yield Until(flow_pin & LAST_PIN, line.flow_go, wait_ns)
            if granted is None and timeout_target is not None:
                return Jump(timeout_target)
            yield from send_byte(port.pins, line, byte)
    return None


def send_byte(pins: Pins, line: Line, byte: int) -> Command[None]:
    """Send a start bit, eight bits and a stop bit; bits of one level are one wait."""
    waits = _waits(data_bits(byte, line.seven_even), line.bit_ns)
    if line.pin == SIN:  # always inverted; the way that DEBUG goes, so without a detour
        for bit, wait in waits:
            pins.send(1 - bit)
            yield wait
        return
    for bit, wait in waits:
        set_line(pins, line, bit)
        yield wait


FRAME_BITS = 10


@lru_cache(maxsize=4096)
def _waits(data: int, bit_ns: int) -> tuple[tuple[int, Delay], ...]:
    """Return the levels of a frame and how long each lasts.

    >>> [(bit, wait.ns) for bit, wait in _waits(0x41, 104)]
    [(0, 104), (1, 104), (0, 520), (1, 104), (0, 104), (1, 104)]
    """
    frame = MARK << FRAME_BITS - 1 | data << 1 | SPACE
    runs = groupby(frame >> place & 1 for place in range(FRAME_BITS))
    return tuple((bit, Delay(len([*run]) * bit_ns)) for bit, run in runs)
