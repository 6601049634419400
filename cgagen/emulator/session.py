"""A program run from its start to its end, or for a time, with somebody at its terminal."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

from cgagen.emulator.bench import Bench
from cgagen.emulator.chip import Chip, End
from cgagen.emulator.clock import NEVER_NS
from cgagen.emulator.conversation import Conversation

SLICE_NS = 10_000_000
"""How often somebody looks whether the program has ended. Ref: choice."""


class Why(StrEnum):
    """Why a run is over."""

    END = "END"
    STOP = "STOP"
    LOOP = "LOOP"
    """The program goes round in a loop with nothing in it, and nothing else happens."""
    WAITS = "WAITS"
    """The chip waits for something that cannot come any more."""
    TIME = "TIME"
    """The time that was given is over."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """What came of a run.

    Attributes:
        why: why it is over.
        time_ns: of the bench's clock when the program came to its END or STOP, and otherwise when
            the run was over.
        instructions: carried out by the chip.
    """

    why: Why
    time_ns: int
    instructions: int

    @property
    def ended(self) -> bool:
        """Whether the program came to its END or STOP."""
        return self.why in (Why.END, Why.STOP)


def run_session(
    bench: Bench,
    chip: Chip,
    conversation: Conversation,
    limit_ns: int = NEVER_NS,
    between: Callable[[], None] = lambda: None,
) -> Outcome:
    """Run a bench until a chip's program ends, nothing more can happen, or the time is over.

    Args:
        bench: what runs.
        chip: whose end it is.
        conversation: its terminal.
        limit_ns: time of the bench's clock.
        between: called after every slice of 10 ms of the bench's time.

    Raises:
        ExecutionError: the program does what no document describes.
        ContentionError: outputs disagree.
    """
    clock = bench.clock
    while True:
        why = _why(bench, chip, conversation, limit_ns)
        if why in (Why.LOOP, Why.WAITS) and limit_ns < NEVER_NS:
            bench.run(limit_ns)
        if why is not None:
            ended_ns = chip.ended_ns if why in (Why.END, Why.STOP) else None
            return Outcome(why, clock.now_ns if ended_ns is None else ended_ns, chip.instructions)
        bench.run(min(clock.now_ns + SLICE_NS, limit_ns))
        between()


def _why(bench: Bench, chip: Chip, conversation: Conversation, limit_ns: int) -> Why | None:
    if chip.ended in (End.END, End.STOP):
        return Why(chip.ended)
    if bench.clock.now_ns >= limit_ns:
        return Why.TIME if chip.ended is None else Why.LOOP
    alone = len(bench.chips) == 1
    if chip.ended is not None and (alone or limit_ns >= NEVER_NS):
        return Why.LOOP
    listens = conversation.wanted() and not conversation.silent
    if bench.clock.next_ns() == NEVER_NS and not listens:
        return Why.LOOP if chip.ended else Why.WAITS
    return None
