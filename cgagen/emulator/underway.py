"""An instruction under way, and how to get into the middle of it again.

A generator cannot be copied. But it is a function of the chip's state when it started, of the
levels that it read and of the answers to its requests; all of that is kept while it runs. To
restore it, it is started again from that state, on pins that drive no wire, and is given the
same levels and answers.
"""

from collections import deque
from typing import NamedTuple

from cgagen.emulator.machine import Machine
from cgagen.emulator.port import Result
from cgagen.emulator.requests import Command
from cgagen.emulator.steps import Step
from cgagen.errors import ExecutionError

MOST_ANSWERS = 100_000
"""What is kept of one instruction. Ref: choice; bounds the memory of a COUNT of a minute."""


class Before(NamedTuple):
    """What an instruction may change before it ends, as it was when it started.

    Attributes:
        words: the register file.
        groups: latch and directions of main and auxiliary pins.
        scratch: the scratch pad.
    """

    words: tuple[int, ...]
    groups: tuple[tuple[int, int], ...]
    scratch: bytes


class Recorded(NamedTuple):
    """An instruction under way as a value.

    Attributes:
        before: the chip when it started.
        levels: that it read from pins.
        answers: to its requests.
    """

    before: Before
    levels: tuple[int, ...]
    answers: tuple[int | None, ...]


class UnderWay:
    """One instruction that is being carried out.

    Args:
        machine: the chip without its time.
        step: an instruction that is a generator.

    Attributes:
        step: see above.
        generator: what is sent answers and yields requests; the first answer is None.
        answers: all that were sent so far; whoever sends one appends it.
    """

    __slots__ = ("_before", "_levels", "_machine", "answers", "generator", "step")

    def __init__(self, machine: Machine, step: Step) -> None:
        self.step = step
        self._machine = machine
        self._before = before_of(machine)
        self._levels: deque[int] = deque(maxlen=MOST_ANSWERS)
        self.answers: deque[int | None] = deque(maxlen=MOST_ANSWERS)
        for pins in machine.groups:
            pins.tape = self._levels
        self.generator = self._started()

    def close(self) -> None:
        """Give the instruction up where it is; harmless when it is done."""
        for pins in self._machine.groups:
            pins.tape = None
        self.generator.close()

    def recorded(self) -> Recorded:
        """Return all that is needed to get here again.

        Raises:
            ExecutionError: it has gone on for too long for that.
        """
        if MOST_ANSWERS in (len(self.answers), len(self._levels)):
            raise ExecutionError(
                f"{self.step.instruction.name} has asked {MOST_ANSWERS} times what its pins do, "
                "and no more is kept; take the snapshot before or after it"
            )
        return Recorded(self._before, tuple(self._levels), tuple(self.answers))

    def repeat(self, recorded: Recorded) -> None:
        """Give an instruction that has just been made the answers of one that was recorded."""
        for answer in recorded.answers:
            self.answers.append(answer)
            self.generator.send(answer)
        self._levels.extend(recorded.levels)

    def _started(self) -> Command[Result]:
        function = self.step.function
        if function is None:
            raise AssertionError(f"{self.step.instruction.name} is no generator")
        return function(self._machine, **self.step.arguments.of(self._machine))


def before_of(machine: Machine) -> Before:
    """Return what an instruction may change."""
    return Before(
        tuple(machine.registers.words),
        tuple((pins.latch, pins.directions) for pins in machine.groups),
        bytes(machine.scratch),
    )


def put_back(machine: Machine, before: Before) -> None:
    """Make a chip what it was, without a word to its wires."""
    machine.registers.words[:] = before.words
    for pins, state in zip(machine.groups, before.groups, strict=True):
        pins.latch, pins.directions = state
    machine.scratch[:] = before.scratch


def repeated(machine: Machine, step: Step, recorded: Recorded) -> UnderWay:
    """Return an instruction in the middle, as `recorded` was taken of it."""
    now = before_of(machine)
    put_back(machine, recorded.before)
    levels = iter(recorded.levels)
    for pins in machine.groups:
        pins.ghost = levels
    try:
        again = UnderWay(machine, step)
        again.repeat(recorded)
    finally:
        for pins in machine.groups:
            pins.ghost = None
    put_back(machine, now)
    return again
