"""One call of `cgagen emulate`: what is printed while a bench runs."""

import re
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import click

from cgagen.emulator.bench import Bench
from cgagen.emulator.chip import Chip
from cgagen.emulator.clock import NEVER_NS
from cgagen.emulator.conversation import Conversation, More
from cgagen.emulator.durations import Durations
from cgagen.emulator.parts.fault import Fault, fault_notes
from cgagen.emulator.screen import CR, Screen
from cgagen.emulator.session import Outcome, run_session
from cgagen.emulator.trace import line_at
from cgagen.errors import BenchError, CgagenError, ExecutionError
from cgagen.stamp.serial_mode import DEBUG_MODE, SerialMode
from cgagen.verbs.console import Console
from cgagen.verbs.keyboard import from_nobody, from_stdin, from_text, is_given

DEFAULT_LIMIT_NS = 10_000_000_000
"""How long a program runs that does not end. Ref: choice."""


@dataclass
class EmulateRun:
    """One call of the verb.

    Attributes:
        console: where notes go.
        bench: what runs.
        chip: whose text and end it is.
        as_json: text is kept for one result at the end.
        sent: every byte that the chip sent, where one result is wanted.
        last: the last of them in any case.
        durations: of its routines, where they are wanted.
        parts: names of those that the bench file has.
        single: it is a program alone, and no bench file.
        terminal: of the chip, once the run has begun.
        fits: the mode in which the chip sends, where that is not the terminal's.
    """

    console: Console
    bench: Bench
    chip: Chip
    as_json: bool
    single: bool

    def __post_init__(self) -> None:
        self.sent = bytearray()
        self.last = CR
        self.durations: Durations | None = None
        self.terminal: Conversation | None = None
        self.fits: SerialMode | None = None
        self.parts = tuple(self.bench.parts)

    def go(self, given: dict[str, Any]) -> Outcome | None:
        """Run the bench; None where the user stopped it."""
        at_once = given["realtime"]
        conversation = Conversation(
            self.bench,
            self.chip,
            self._seen(),
            self._typed(given["text"], at_once),
            at_once=at_once,
            echo=given["echo"],
            mode=given["baud"] or DEBUG_MODE,
        )
        self.terminal = conversation
        pace: Callable[[], None] = _pace(self.bench, conversation.look) if at_once else _nothing

        def between() -> None:
            pace()
            self.tell_mode(over=False)

        limit_ns = NEVER_NS if given["until_end"] else given["limit_ns"] or DEFAULT_LIMIT_NS
        try:
            return run_session(self.bench, self.chip, conversation, limit_ns, between)
        except KeyboardInterrupt:
            return None
        except (ExecutionError, BenchError) as error:
            for note in fault_notes(self.bench.parts_of(Fault)):
                self.console.note(f"note: {note}")
            raise self._located(error) from error

    def _typed(self, text: str | None, at_once: bool) -> More:
        """Return where what a user types comes from: what they said, or what they gave."""
        if text == "-" or (text is None and self.single and is_given(at_once)):
            return from_stdin(at_once, self._ask)
        return from_nobody() if text is None else from_text(text)

    def tell_mode(self, over: bool = True) -> None:
        """Say once that chip and terminal have different rates, and which would fit."""
        terminal = self.terminal
        if terminal is None or self.fits is not None:
            return
        self.fits = terminal.watch.fitting(over)
        if self.fits is not None:
            terminal.watch.close()
            self.end_line()
            self.console.note(
                f"note: {self.chip.name} sends at {self.fits}, and the terminal listens at "
                f"{terminal.mode}: --baud {self.fits} shows what it says"
            )

    def note_floating(self, end: str) -> None:
        """Say that a pin was read that nothing drives."""
        owner, _, pin = end.partition(".")
        option = f"{pin[1:]}=1" if owner == self.chip.name else f"{end}=1"
        wire = self.bench.wire_of(end)
        if wire is None:
            why = "is read, and nothing is wired to it"
            cure = f"--pin {option} holds it high, a bench file wires it"
        else:
            why = f"on the wire {wire} is read, and nothing drives it"
            cure = f"--pin {option} holds it high, pull in the bench file gives it a resistor"
        self.end_line()
        where = self.where(self.bench.chips[owner])
        self.console.note(f"note: {where}: {pin} {why}: it reads 0 ({cure})")

    def end_line(self) -> None:
        """Begin a new line on a terminal that is in the middle of one."""
        if not self.as_json and self.last != CR and sys.stdout.isatty():
            self.last = CR
            click.echo()

    def where(self, chip: Chip) -> str:
        """Return file and line of the instruction under way, or the chip's name."""
        return self._line(chip) or chip.name

    def _seen(self) -> Callable[[int], None]:
        """Return what takes a byte that the chip sent."""
        if self.as_json:
            return self.sent.append
        if not sys.stdout.isatty():
            stream = sys.stdout.buffer

            def write_raw(byte: int) -> None:
                stream.write(bytes([byte]))
                stream.flush()

            return write_raw
        screen = Screen()

        def write_shown(byte: int) -> None:
            self.last = byte
            sys.stdout.write(screen.shown(bytes([byte])))
            sys.stdout.flush()

        return write_shown

    def _ask(self) -> None:
        self.console.note("\n(the program waits: type, then Enter; Ctrl-D for no more)")

    def _line(self, chip: Chip) -> str | None:
        """Return file and line of the instruction under way, where its source is known."""
        programs = self.bench.programs.get(chip.name, {})
        line = line_at(programs, chip.slot, chip.pc)
        return None if line is None else f"{programs[chip.slot].name}:{line}"

    def _located(self, error: CgagenError) -> CgagenError:
        """Return an error with the line of the chip that it speaks of first."""
        text = str(error)
        spoken = {name: re.search(rf"\b{name}(:|\.P)", text) for name in self.bench.chips}
        places = {found.start(): name for name, found in spoken.items() if found}
        line = self._line(self.bench.chips[places[min(places)]]) if places else None
        return error if line is None else type(error)(f"{line}: {text}")


def _pace(bench: Bench, look: Callable[[], None]) -> Callable[[], None]:
    """Return what holds the bench back to the speed of the real thing."""
    began_s, began_ns = time.monotonic(), bench.clock.now_ns

    def pace() -> None:
        look()
        ahead_s = (bench.clock.now_ns - began_ns) / 1e9 - (time.monotonic() - began_s)
        if ahead_s > 0:
            time.sleep(ahead_s)

    return pace


def _nothing() -> None:
    pass
