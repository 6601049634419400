"""An emulated chip's port for a host that lives in real time.

The chip's time stands still while it listens and the host has not spoken yet, so a slow host is
not late and a fast chip does not run away; it goes on by itself when the host has been silent for
a while. What the host sends while the chip does not listen is lost, as on a Stamp. After a change
of DTR or BREAK the chip is given the time that it needs to see it: how long the host's own pauses
are is not judged here, for a busy computer cannot keep them. `HostPort` judges them.
"""

from collections.abc import Callable
from typing import TypeVar

from cgagen.bench_protocol import BYTE_GAP_MS, PROMPT_GAP_MS
from cgagen.emulator.host_port import HostPort
from cgagen.emulator.line_watch import LineWatch
from cgagen.emulator.loader import Phase
from cgagen.emulator.pins import SIN
from cgagen.stamp.serial_mode import SerialMode

Value = TypeVar("Value", int, float, str)

SLICE_NS = 5_000_000
"""How far a chip goes while it listens in vain, before the host is asked again. Choice."""

RUN_NS = 4_000_000
"""How far it goes at once otherwise. Choice: less than any slice in which a chip listens."""

LOOK_NS = 100_000
"""How often somebody looks whether it listens by now. Choice."""

CHARACTER_BITS = 10

GAP_NS = BYTE_GAP_MS * 1_000_000
"""Behind each character that a program is to take: HEX needs time to store a number."""

LINE_NS = 2_000_000
"""What follows a change of BREAK: its echo, one character. Choice."""

MOST_SETTLE_NS = 100_000_000
"""No reset takes longer to be seen. Choice: twice the longest."""


class PacedPort:
    """The port, with pyserial's names, so that `serial.rfc2217.PortManager` can turn its knobs.

    Args:
        port: on the bench.
        deliver: called when what has been heard must reach the host before what follows.

    Attributes:
        on_other_rate: told once, for each speed that a host has set, that the chip sends in
            another mode than that, and in which.
    """

    cts = dsr = ri = cd = False

    def __init__(self, port: HostPort, deliver: Callable[[], None] = lambda: None) -> None:
        self.port = port
        self.deliver = deliver
        self.rts = False
        self.xonxoff = self.rtscts = False
        self.on_other_rate: Callable[[SerialMode, SerialMode], object] = lambda _sent, _heard: None
        self._bits, self._parity = 8, "N"
        self._told = False
        self._watch = LineWatch(port.bench.clock, port.chip.pins.sout, self.mode)

    @property
    def mode(self) -> SerialMode:
        """How the host listens and speaks."""
        return SerialMode(self.port.baudrate, self.port.uart.seven_even)

    @property
    def listens(self) -> bool:
        """Whether nothing will come from the chip before the host speaks, or not for long."""
        chip, loader = self.port.chip, self.port.loader
        if loader.phase is not Phase.RUNNING:
            return loader.settled
        waiting = chip.waiting
        if waiting is not None and waiting.pin == SIN:
            return True
        return chip.ended is not None or not chip.bookings()

    def say(self, data: bytes) -> None:
        """Send what the host has said, as soon as the chip listens or at least might."""
        until_ns = self._now_ns + PROMPT_GAP_MS * 1_000_000
        while not self.listens and self._now_ns < until_ns:
            self._advance(LOOK_NS)
        for byte in data:
            self.port.uart.send(bytes([byte]))
            running = self.port.loader.phase is Phase.RUNNING
            character_ns = CHARACTER_BITS * 1_000_000_000 // self.port.baudrate
            self._advance(character_ns + GAP_NS * running)

    def take(self) -> bytes:
        """Return what has been heard."""
        fits = None if self._told else self._watch.fitting(over=False)
        if fits is not None:
            self._told = True
            self.on_other_rate(fits, self.mode)
        return self.port.uart.take()

    def release(self) -> None:
        """Let go of the lines, as a computer that closes its port."""
        self.break_condition = self.dtr = False

    def forget(self) -> None:
        """Forget what is on its way in both directions."""
        self.port.reset_output_buffer()
        self.port.reset_input_buffer()

    # -- What a telnet client can set -----------------------------------------------------------

    @property
    def dtr(self) -> bool:
        """DTR; when it has been set, the chip has seen it."""
        return self.port.dtr

    @dtr.setter
    def dtr(self, asserted: bool) -> None:
        if asserted != self.port.dtr:
            self.port.dtr = asserted
            self._settle()

    @property
    def break_condition(self) -> bool:
        """BREAK; likewise."""
        return self.port.break_condition

    @break_condition.setter
    def break_condition(self, on: bool) -> None:
        if on != self.port.break_condition:
            self.port.break_condition = on
            self._advance(LINE_NS)
            self._settle()

    @property
    def baudrate(self) -> int:
        """Bits per second; the loader and DEBUG have 9,600, a SERIN what its program says."""
        return self.port.baudrate

    @baudrate.setter
    def baudrate(self, baud: int) -> None:
        self.port.baudrate = baud
        self._changed()

    @property
    def bytesize(self) -> int:
        """Bits of a character: eight, or seven with even parity."""
        return self._bits

    @bytesize.setter
    def bytesize(self, bits: int) -> None:
        self._bits = _only(bits, 8, 7)
        self._changed()

    @property
    def parity(self) -> str:
        """None with eight bits, or even with seven; a host sets one after the other."""
        return self._parity

    @parity.setter
    def parity(self, parity: str) -> None:
        self._parity = _only(parity, "N", "E")
        self._changed()

    @property
    def stopbits(self) -> float:
        """One."""
        return 1

    @stopbits.setter
    def stopbits(self, bits: float) -> None:
        _only(bits, 1)

    def reset_input_buffer(self) -> None:
        """Forget what the chip has sent and the host was not given."""
        self.port.reset_input_buffer()

    def reset_output_buffer(self) -> None:
        """Forget what has not been sent to the chip."""
        self.port.reset_output_buffer()

    @property
    def _now_ns(self) -> int:
        return self.port.bench.clock.now_ns

    def _advance(self, ns: int) -> None:
        self.port.run(self._now_ns + ns)

    def _changed(self) -> None:
        self.port.uart.seven_even = (self._bits, self._parity) == (7, "E")
        if self.mode != self._watch.mode:
            self._watch.set_mode(self.mode)
            self._told = False

    def _settle(self) -> None:
        """Let the chip see what its lines do, and no more."""
        until_ns = self._now_ns + MOST_SETTLE_NS
        while not self.port.loader.settled and self._now_ns < until_ns:
            self._advance(LOOK_NS)
        self.deliver()


def _only(value: Value, *wanted: Value) -> Value:
    if value not in wanted:
        raise ValueError(f"a Stamp's port is 8N1 or 7E1, which has no {value!r}")
    return value
