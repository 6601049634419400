"""Whoever sits at the terminal of a chip's programming port: what they type and what they see."""

from collections.abc import Callable
from typing import ClassVar

from cgagen.emulator.bench import Bench
from cgagen.emulator.chip import Chip
from cgagen.emulator.commands.serial_line import line_of
from cgagen.emulator.expressions import depends_on_pins
from cgagen.emulator.line_watch import LineWatch
from cgagen.emulator.parts.part import Part
from cgagen.emulator.parts.uart import Uart
from cgagen.emulator.pins import SIN
from cgagen.stamp.program import Kind
from cgagen.stamp.serial_mode import DEBUG_MODE, SerialMode, usual

More = Callable[[bool], bytes | None]
"""Asked for more to type; the argument says that the chip can do nothing without it. Returns
nothing yet (b""), or that nothing will come any more (None)."""


class Conversation(Part):
    """A terminal on the programming port.

    Where the bench has something else on SIN, the terminal only shows what the chip sends.

    Text waits until the chip waits for a byte there, so that nothing is lost. With `at_once` it
    goes out as it comes, and what no SERIN takes is lost, as on a desk.

    Args:
        bench: with the chip on it.
        chip: whose port it is.
        seen: told every byte that the chip sends.
        more: where text comes from.
        at_once: see above.
        echo: what is typed comes back over the board's wiring, and is seen.
        mode: of the terminal, both ways.

    Attributes:
        silent: nothing more will be typed.
        typed: bytes that were.
        mode: see above.
        watch: of what the chip sends.
        listened: how a SERIN listened to what was typed, where that is not the terminal's mode.
    """

    CIRCUIT: ClassVar[frozenset[str]] = frozenset(
        {"_chip", "_host", "_more", "_seen", "listened", "watch"}
    )

    def __init__(
        self,
        bench: Bench,
        chip: Chip,
        seen: Callable[[int], None],
        more: More,
        *,
        at_once: bool = False,
        echo: bool = False,
        mode: SerialMode = DEBUG_MODE,
    ) -> None:
        super().__init__(f"{chip.name}_terminal", bench.clock)
        self.silent = False
        self.typed = 0
        self.mode = mode
        self.listened: SerialMode | None = None
        self.watch = LineWatch(bench.clock, chip.pins.sout, mode)
        self._chip = chip
        self._more = more
        self._host = _line_of(bench, chip.name, echo)
        self._host.baud, self._host.seven_even = mode
        self._host.heard = self._heard
        self._seen = seen
        if not self._host.sends:
            self.silent = True
        self._soon = self.timer(self._type)
        if not at_once:
            self._host.may_send = self.wanted
            chip.on_wait = self._chip_waits
        bench.add_part(self)

    def wanted(self) -> bool:
        """Whether the chip waits for a byte on its programming port."""
        waiting = self._chip.waiting
        return waiting is not None and waiting.pin == SIN and waiting.met_ns is None

    def look(self) -> None:
        """Send what has been typed meanwhile."""
        if not self.silent and not self._host.waiting:
            self._send(self._more(False))

    def _heard(self, byte: int) -> None:
        """Show a byte; nobody keeps it, for a program may talk for days."""
        self._host.take()
        self._seen(byte)

    def _chip_waits(self) -> None:
        if self._host.waiting or not self.silent:
            self._soon.after(0)

    def _type(self) -> None:
        """The chip wants a byte: the next one, or ask for one."""
        if not self.wanted():
            return
        if self._host.sending:  # the chip looks no longer than to the middle of a stop bit
            self._soon.at(self._host.idle_ns)
        elif self._host.waiting:
            self._host.poke()
        elif not self.silent:
            self._send(self._more(self._chip.waits_for_ever))

    def _send(self, text: bytes | None) -> None:
        self.silent = text is None
        if text:
            self.typed += len(text)
            listens = listening_mode(self._chip)
            if listens is not None and not self.mode.is_heard_as(listens):
                self.listened = listens
            self._host.send(text)


def listening_mode(chip: Chip) -> SerialMode | None:
    """Return the mode of the SERIN under way on the programming port; None for none."""
    waiting = chip.waiting
    if waiting is None or waiting.pin != SIN:
        return None
    baud = chip.step_at(chip.pc).instruction.operand("baud")
    if baud is None or any(token.kind is Kind.READ and depends_on_pins(token) for token in baud):
        return None
    line = line_of(chip.machine.timing, chip.machine.evaluator.value(baud), SIN)
    return SerialMode(usual(1_000_000_000 / line.bit_ns), line.seven_even)


def _line_of(bench: Bench, chip: str, echo: bool) -> Uart:
    """Return a computer's end of the programming port, beside what the bench has on it."""
    sin, sout = f"{chip}.SIN", f"{chip}.SOUT"
    if f"{chip}_host" in bench.parts or not (bench.wire_of(sin) or bench.wire_of(sout)):
        return bench.host(chip, echo=echo)
    transmit = None if bench.wire_of(sin) else bench.end(sin)
    line = Uart(f"{chip}_line", bench.clock, transmit, bench.end(sout), mark=0, echo=echo)
    return bench.add_part(line)
