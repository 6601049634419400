"""An emulated chip's port for a host that lives in real time.

The chip's time stands still while it listens and the host has not spoken yet, so a slow host is
not late and a fast chip does not run away; it goes on by itself when the host has been silent for
a while. What the host sends while the chip does not listen is lost, as on a Stamp. After a change
of DTR or BREAK the chip is given the time that it needs to see it: how long the host's own pauses
are is not judged here, for a busy computer cannot keep them. `HostPort` judges them.
"""

from collections.abc import Callable

from cgagen.bench_protocol import BAUD, BYTE_GAP_MS, PROMPT_GAP_MS
from cgagen.emulator.host_port import HostPort
from cgagen.emulator.loader import Phase
from cgagen.emulator.pins import SIN

SLICE_NS = 5_000_000
"""How far a chip goes while it listens in vain, before the host is asked again. Choice."""

RUN_NS = 4_000_000
"""How far it goes at once otherwise. Choice: less than any slice in which a chip listens."""

LOOK_NS = 100_000
"""How often somebody looks whether it listens by now. Choice."""

CHARACTER_NS = 10 * 1_000_000_000 // BAUD

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
    """

    cts = dsr = ri = cd = False

    def __init__(self, port: HostPort, deliver: Callable[[], None] = lambda: None) -> None:
        self.port = port
        self.deliver = deliver
        self.rts = False
        self.xonxoff = self.rtscts = False

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
            self._advance(CHARACTER_NS + GAP_NS * running)

    def take(self) -> bytes:
        """Return what has been heard."""
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
        """Bits per second; at any but 9,600 the chip hears garbage."""
        return self.port.baudrate

    @baudrate.setter
    def baudrate(self, baud: int) -> None:
        self.port.baudrate = baud

    @property
    def bytesize(self) -> int:
        """Bits of a character: eight."""
        return 8

    @bytesize.setter
    def bytesize(self, bits: int) -> None:
        _only(bits, 8)

    @property
    def parity(self) -> str:
        """None."""
        return "N"

    @parity.setter
    def parity(self, parity: str) -> None:
        _only(parity, "N")

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

    def _settle(self) -> None:
        """Let the chip see what its lines do, and no more."""
        until_ns = self._now_ns + MOST_SETTLE_NS
        while not self.port.loader.settled and self._now_ns < until_ns:
            self._advance(LOOK_NS)
        self.deliver()


def _only(value: object, wanted: object) -> None:
    if value != wanted:
        raise ValueError(f"a Stamp's port is 8N1 and not {value!r}")
