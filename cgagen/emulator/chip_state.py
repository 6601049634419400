"""What is known of a chip besides the machine itself, as values."""

from collections import Counter
from enum import StrEnum
from typing import NamedTuple

from cgagen.emulator.blocks import Block
from cgagen.emulator.clock import Booking
from cgagen.emulator.polling import Polling
from cgagen.emulator.steps import Step
from cgagen.emulator.underway import Before, Recorded


class End(StrEnum):
    """Why a program does nothing any more."""

    END = "END"
    STOP = "STOP"
    LOOP = "LOOP"
    """A GOTO to itself: DO and LOOP with nothing between them."""


class Coverage:
    """What was executed, by slot and stream address.

    Attributes:
        counts: how often each instruction was carried out.
        branches: for instructions that may jump (IF, NEXT, BRANCH, BUTTON, SERIN with a
            label ...): how often each went on behind itself, and how often it jumped.
    """

    def __init__(self) -> None:
        self.counts: Counter[tuple[int, int]] = Counter()
        self.branches: dict[tuple[int, int], list[int]] = {}

    def branch(self, place: tuple[int, int], jumped: bool) -> None:
        """Count one decision."""
        self.branches.setdefault(place, [0, 0])[jumped] += 1


class Waiting(NamedTuple):
    """A pin that an instruction waits for.

    Attributes:
        pin: its number; 16 is SIN.
        level: that it waits for.
        since_ns: when that began.
        met_ns: when the pin had the level; None while it has not.
    """

    pin: int
    level: int
    since_ns: int
    met_ns: int | None = None


class ChipState(NamedTuple):
    """A chip at one moment, as a value: give it to `Chip.restore`. Its fields are nobody's."""

    now: Before
    on_aux: bool
    sout: int
    images: tuple[bytes, ...]
    place: tuple[int, int, int, int]
    gosubs: tuple[int, ...]
    polling: Polling
    local_ns: int
    ended: End | None
    ended_ns: int | None
    instructions: int
    settled: bool
    fetched: bool
    recorded: Recorded | None
    answer: int | None
    waiting: Waiting | None
    booking: Booking | None


class Program:
    """What is known of the program in one slot, until it is written over.

    Attributes:
        steps: instructions by address.
        blocks: what is compiled, by the address where it begins; None where nothing can be.
    """

    __slots__ = ("_visits", "blocks", "steps")

    def __init__(self) -> None:
        self.steps: dict[int, Step] = {}
        self.blocks: dict[int, Block | None] = {}
        self._visits: Counter[int] = Counter()

    def worn(self, address: int, visits: int) -> bool:
        """Count a visit; returns whether there have been more than so many."""
        self._visits[address] += 1
        return self._visits[address] > visits
