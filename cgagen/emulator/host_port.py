r"""A computer's serial port with an emulated Stamp on it, in process, on the bench's own time.

It has the names of pyserial's ports, and a clock to wait with::

    from cgagen.emulator.host_port import HostPort
    from cgagen.emulator.programs import bench_of_image

    port = HostPort(bench_of_image(image))      # or any bench, and the name of one of its chips
    port.break_condition = True
    port.dtr = True
    port.sleep(0.005)                           # seconds of the chip's time
    port.dtr = False
    port.sleep(0.06)
    port.break_condition = False
    port.sleep(0.02)
    port.reset_input_buffer()                   # the BREAK has come back as a 00
    port.write(b"B")
    assert port.read(2) == b"B\xbe"             # its echo and the answer
    port.now_s()                                # the time that has passed on the bench

Nothing happens between two calls. `read`, `sleep` and `flush` let the bench go on; `read` at most
for `timeout` seconds. A program that goes astray, as half a download does, stops its chip until
the next reset; what it did is in `faults`.
"""

from collections.abc import Callable

from cgagen.emulator.bench import Bench
from cgagen.emulator.loader import Atn, Loader, RomLine
from cgagen.errors import BenchError, CgagenError

MOST_BAUD = 1_000_000


class HostPort:
    """The port; one for each chip of a bench.

    Args:
        bench: with the chip on it, and nothing else on its programming port.
        chip: its name.
        timeout: seconds of the bench's time that `read` may take.
        atn: the board's circuit between DTR and ATN.
        legs: 24 or 40, which a BS2p and a BS2pe tell when they are identified.
        version: place of the loader's version among those of the model, 0 is the oldest.

    Attributes:
        bench: see above; nobody else may run it inside a call.
        loader: the chip's ROM.
        uart: the bits.
        timeout: see above.
        rts: has no effect on a Stamp.
        faults: what chips did that ended their programs; the newest last.
        on_fault: told each of them.

    Raises:
        BenchError: no such chip, something else is on its port, or it has a port already.
    """

    cts = dsr = ri = cd = False

    def __init__(
        self,
        bench: Bench,
        chip: str = "main",
        *,
        timeout: float = 0.2,
        atn: Atn = Atn.CAPACITOR,
        legs: int = 24,
        version: int = 0,
    ) -> None:
        self.bench = bench
        self.chip = bench.chip(chip)
        self.timeout = timeout
        self.rts = False
        self.faults: list[CgagenError] = []
        self.on_fault: Callable[[CgagenError], None] = _nothing
        self.is_open = True
        self.uart = bench.host(chip)
        self.uart.keeps_errors = True
        line = bench.add_part(RomLine(f"{chip}_rom_line", bench.clock, self.chip.pins))
        self.loader = bench.add_part(Loader(self.chip, line, atn, legs, version))
        self.loader.on_change = self._reprogrammed
        self.uart.heard = self._heard
        self._wanted = 0

    # -- Bytes ----------------------------------------------------------------------------------

    def write(self, data: bytes) -> int:
        """Send bytes behind those that wait; they leave as the bench goes on."""
        self._refuse_closed()
        self.uart.send(bytes(data))
        return len(data)

    def read(self, size: int = 1) -> bytes:
        """Return so many bytes, or what has come when `timeout` is over."""
        self._refuse_closed()
        self._wanted = size
        if self.in_waiting < size:
            self.run(self.bench.clock.now_ns + _ns(self.timeout))
        self._wanted = 0
        return self.uart.take(size)

    def flush(self) -> None:
        """Let the bench go on until everything is sent."""
        while self.uart.waiting or self.uart.sending:
            self.run(self.bench.clock.next_ns())

    @property
    def in_waiting(self) -> int:
        """Bytes that can be read at once."""
        return self.uart.unread

    @property
    def out_waiting(self) -> int:
        """Bytes that have not begun to be sent."""
        return self.uart.waiting

    def reset_input_buffer(self) -> None:
        """Forget what has come."""
        self.uart.take()

    def reset_output_buffer(self) -> None:
        """Forget what has not been sent."""
        self.uart.drop()

    # -- Lines ----------------------------------------------------------------------------------

    @property
    def dtr(self) -> bool:
        """DTR, asserted or not; the board makes ATN of it."""
        return self.loader.dtr

    @dtr.setter
    def dtr(self, asserted: bool) -> None:
        self.loader.dtr = bool(asserted)

    @property
    def break_condition(self) -> bool:
        """Whether the line to the chip is held at space."""
        return self.uart.breaks

    @break_condition.setter
    def break_condition(self, on: bool) -> None:
        self.uart.hold_break(bool(on))

    def send_break(self, duration: float = 0.25) -> None:
        """Hold the line at space for so many seconds."""
        self.break_condition = True
        self.sleep(duration)
        self.break_condition = False

    @property
    def baudrate(self) -> int:
        """Bits per second; at another than the chip's, it hears garbage."""
        return self.uart.baud

    @baudrate.setter
    def baudrate(self, baud: int) -> None:
        if not 1 <= baud <= MOST_BAUD:
            raise ValueError(f"{baud} is no baud rate; give 1 to {MOST_BAUD}")
        self.uart.baud = baud

    # -- Time -----------------------------------------------------------------------------------

    def now_s(self) -> float:
        """Return the bench's time in seconds."""
        return self.bench.clock.now_ns / 1e9

    def sleep(self, seconds: float) -> None:
        """Let the bench go on for so long."""
        self.run(self.bench.clock.now_ns + _ns(seconds))

    def run(self, until_ns: int) -> None:
        """Let the bench go on to a time; `read` ends it earlier.

        What goes wrong on the bench ends the program of a chip and is kept in `faults`.
        """
        while True:
            try:
                self.bench.run(until_ns)
            except CgagenError as error:
                self.faults.append(error)
                self.on_fault(error)
                continue
            return

    def close(self) -> None:
        """Let go of DTR and of the line, as a computer does."""
        self.is_open = False
        self.uart.drop()
        self.break_condition = self.dtr = False

    def _refuse_closed(self) -> None:
        if not self.is_open:
            raise BenchError(f"the port of {self.chip.name} is closed; make another one")

    def _heard(self, _byte: int) -> None:
        if self._wanted and self.in_waiting >= self._wanted:
            self.bench.clock.stop()

    def _reprogrammed(self, slot: int) -> None:
        """The lines of the program that was there say nothing any more."""
        self.bench.programs.get(self.chip.name, {}).pop(slot, None)


def _nothing(_error: CgagenError) -> None:
    pass


def _ns(seconds: float) -> int:
    return max(0, round(seconds * 1e9))
