"""SERIN, which DEBUGIN is too: serial input with parity, time-out and flow pin.

Ref: S2 p. 393 to 413; S9 (1.8) p. 315 for the time-out, which every byte starts anew; S2 p. 411 for
bytes that are garbled because the chip is still busy with the item before.
"""

from cgagen.emulator.commands.levels import FOREVER_NS, LAST_PIN, drive, release
from cgagen.emulator.commands.lists import receive
from cgagen.emulator.commands.serial_line import SPACE, Line, line_of
from cgagen.emulator.pins import SIN, Pins
from cgagen.emulator.port import Inputs, Jump, Port, Result
from cgagen.emulator.requests import Command, Delay, Until

_DATA_BITS = 8


class _Abandoned(Exception):  # noqa: N818 - no error: the instruction goes on elsewhere
    """Ends the list in the middle."""

    def __init__(self, address: int) -> None:
        super().__init__(address)
        self.address = address


class _SerialReceiver:
    """Takes bytes off a line.

    A bit is read in its middle. The start bit is a level, not an edge, and neither it nor the
    stop bit is looked at again. What the chip does between two bytes overlaps with the stop bit up
    to its middle; what takes longer makes it late for the next start bit, unless a flow pin holds
    the sender. That pin is a handshake byte by byte (Ref: S9 (1.8) p. 307): it says "go" in the
    moment in which the line is looked at for a start bit, and "stop" with the byte's last bit, so
    that a sender that asks behind its stop bit has to wait.
    """

    __slots__ = (
        "_flow_pin",
        "_line",
        "_parity_target",
        "_pins",
        "_stop_ns",
        "_timeout_target",
        "_wait_ns",
    )

    def __init__(
        self,
        pins: Pins,
        line: Line,
        wait_ns: int,
        timeout_target: int | None,
        parity_target: int | None,
        flow_pin: int | None,
    ) -> None:
        self._flow_pin = flow_pin
        self._pins = pins
        self._line = line
        self._wait_ns = wait_ns
        self._timeout_target = timeout_target
        self._parity_target = parity_target
        self._stop_ns = 0

    def busy(self, ns: int) -> Command[None]:
        """Fetch an item."""
        self._stop_ns = max(0, self._stop_ns - ns)
        yield Delay(ns)

    def finish(self) -> Command[None]:
        """Wait for the middle of the stop bit, where it is not over."""
        if self._stop_ns:
            yield Delay(self._stop_ns)
        self._stop_ns = 0

    def permit(self, go: bool) -> None:
        """Tell the sender, where it can be told, whether to send."""
        if self._flow_pin is not None:
            level = self._line.flow_go if go else 1 - self._line.flow_go
            drive(self._pins, self._flow_pin & LAST_PIN, level)

    def byte(self) -> Command[int]:
        """Receive one byte; the time-out is that of its start bit."""
        line = self._line
        yield from self.finish()
        self.permit(True)
        started = yield Until(line.pin, line.level(SPACE), self._wait_ns)
        if started is None and self._timeout_target is not None:
            raise _Abandoned(self._timeout_target)
        yield Delay(line.bit_ns + line.bit_ns // 2)
        bits = self._pins.level(line.pin) ^ line.inverted
        for place in range(1, _DATA_BITS):
            yield Delay(line.bit_ns)
            bits |= (self._pins.level(line.pin) ^ line.inverted) << place
        self._stop_ns = line.bit_ns
        self.permit(False)
        if not line.seven_even:
            return bits
        if bits.bit_count() & 1 and self._parity_target is not None:
            raise _Abandoned(self._parity_target)
        return bits & 0x7F


def serin(
    port: Port,
    items: Inputs,
    *,
    timeout: int,
    baud: int,
    pin: int,
    flow_pin: int | None = None,
    timeout_target: int | None = None,
    parity_target: int | None = None,
) -> Command[Result]:
    """SERIN and DEBUGIN, with and without a flow pin.

    Behind the instruction the flow pin says "stop". Without a label for it there is no time-out,
    and no label for parity means that parity is not looked at.
    """
    line = line_of(port.timing, baud, pin)
    wait_ns = FOREVER_NS
    if timeout_target is not None:
        wait_ns = timeout * port.timing.serin_timeout_ns
    receiver = _SerialReceiver(port.pins, line, wait_ns, timeout_target, parity_target, flow_pin)
    if line.pin != SIN:
        release(port.pins, line.pin)
    result: Result = None
    try:
        yield from receive(port, items, receiver)
    except _Abandoned as abandoned:
        result = Jump(abandoned.address)
    receiver.permit(False)
    yield from receiver.finish()
    return result
