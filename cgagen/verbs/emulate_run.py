"""One call of `cgagen emulate`: what is printed while a bench runs, and what is said at its end."""

import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from cgagen.emulator.bench import Bench
from cgagen.emulator.chip import Chip
from cgagen.emulator.clock import NEVER_NS
from cgagen.emulator.conversation import Conversation
from cgagen.emulator.durations import Durations, durations_text
from cgagen.emulator.pins import SIN
from cgagen.emulator.screen import CR, Screen
from cgagen.emulator.session import Outcome, Why, run_session
from cgagen.emulator.trace import line_at
from cgagen.errors import BenchError, CgagenError, ExecutionError
from cgagen.verbs.console import Console
from cgagen.verbs.keyboard import from_stdin, from_text

DEFAULT_LIMIT_NS = 10_000_000_000
"""How long a program runs that does not end. Ref: choice."""

NOT_ENDED = 9
INTERRUPTED = 130


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
    """

    console: Console
    bench: Bench
    chip: Chip
    as_json: bool

    def __post_init__(self) -> None:
        self.sent = bytearray()
        self.last = CR
        self.durations: Durations | None = None

    def go(self, given: dict[str, Any]) -> Outcome | None:
        """Run the bench; None where the user stopped it."""
        at_once, text = given["realtime"], given["text"]
        stdin = text is None or text == "-"
        conversation = Conversation(
            self.bench,
            self.chip,
            self._seen(),
            from_stdin(at_once, self._ask) if stdin else from_text(text),
            at_once=at_once,
            echo=given["echo"],
        )
        between: Callable[[], None] = _pace(self.bench, conversation.look) if at_once else _nothing
        limit_ns = NEVER_NS if given["until_end"] else given["limit_ns"] or DEFAULT_LIMIT_NS
        try:
            return run_session(self.bench, self.chip, conversation, limit_ns, between)
        except KeyboardInterrupt:
            return None
        except (ExecutionError, BenchError) as error:
            raise self._located(error) from error

    def report(self, file: Path, outcome: Outcome | None, expect_end: bool) -> int:
        """Say how it ended; returns the exit code."""
        now_ns = self.bench.clock.now_ns
        waits = self._waits() if outcome is None or not outcome.ended else None
        if self.as_json:
            data = {
                "file": str(file),
                "chip": self.chip.name,
                "model": self.chip.machine.model.name,
                "ended": "INTERRUPTED" if outcome is None else str(outcome.why),
                "time_ns": now_ns,
                "instructions": self.chip.instructions,
                "output": self.sent.decode("latin-1"),
                "floating": self.bench.floated,
                "waits": waits,
            }
            if self.durations is not None:
                data["durations"] = [row._asdict() for row in self.durations.rows()]
            Console(as_json=True).result(data, "")
        elif sys.stdout.isatty() and self.last != CR:
            click.echo()
        if self.durations is not None and not self.as_json:
            click.echo(durations_text(self.durations.rows()), err=True)
        if waits:
            self.console.note(f"note: {waits}")
        if outcome is None:
            click.echo(f"cgagen: stopped by Ctrl-C at {now_ns / 1e9:.3f} s", err=True)
            return INTERRUPTED
        if expect_end and not outcome.ended:
            click.echo(
                f"cgagen: {file}: no END or STOP in {now_ns / 1e9:g} s of the chip's time: "
                f"{self._unended(outcome)}",
                err=True,
            )
            return NOT_ENDED
        return 0

    def note_floating(self, end: str) -> None:
        """Say that a pin was read that nothing drives."""
        owner, _, pin = end.partition(".")
        where = self._where(self.bench.chips[owner])
        option = f"{pin[1:]}=1" if owner == self.chip.name else f"{end}=1"
        self.console.note(
            f"note: {where}: {pin} is read, and nothing is wired to it: it reads 0 "
            f"(--pin {option} holds it high, a bench file wires it)"
        )

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

    def _where(self, chip: Chip) -> str:
        """Return file and line of the instruction under way, or the chip's name."""
        programs = self.bench.programs.get(chip.name, {})
        line = line_at(programs, chip.slot, chip.pc)
        return chip.name if line is None else f"{programs[chip.slot].name}:{line}"

    def _unended(self, outcome: Outcome) -> str:
        """Return why there was no end, and what to do."""
        if outcome.why is Why.LOOP:
            return f"it goes round in an empty loop at {self._where(self.chip)}; mend the program"
        if outcome.why is Why.WAITS:
            return "it waits for what does not come; wire it in a bench file, or give --input"
        return "give it more with --for, or mend the program"

    def _waits(self) -> str | None:
        """Return what the chip waits for without end, as a sentence."""
        waiting = self.chip.waiting
        if waiting is None or not self.chip.waits_for_ever:
            return None
        if waiting.pin == SIN:
            return f"{self._where(self.chip)}: the program waits for input that does not come"
        return (
            f"{self._where(self.chip)}: the program waits for P{waiting.pin} to become "
            f"{waiting.level}"
        )

    def _located(self, error: CgagenError) -> CgagenError:
        """Return an error with the line of the chip that it speaks of."""
        text = str(error)
        for chip in self.bench.chips.values():
            if text.startswith(f"{chip.name}:") or f"{chip.name}.P" in text:
                return type(error)(f"{self._where(chip)}: {text}")
        return error


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
