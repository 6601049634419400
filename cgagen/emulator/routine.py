"""A routine of a program called like a function, from a snapshot, with the clock left alone.

What a chip does between two instructions that touch pins is the same however it is called; so
thousands of calls of one routine need no bench around them. Instructions and compiled blocks
are the chip's own kind: nothing here knows what an instruction means.
"""

from collections.abc import Sequence

from cgagen.emulator.blocks import COUNT_BITS, Function, block_at
from cgagen.emulator.chip import Chip
from cgagen.emulator.steps import Step, step_of
from cgagen.errors import ExecutionError

MOST_INSTRUCTIONS = 10_000
"""In one call. Ref: choice; a decision takes about 100."""


class Routine:
    """A routine that touches no pin but the output latch and takes no time of its own.

    Args:
        chip: stands where the routine begins; it is changed by every call, and `restore`d by
            whoever wants it back.
        stop: the address at which a call ends.

    Attributes:
        words: the register file; set it before a call, read it after. Words 0 to 2 are pins.
        instructions: how many the last call carried out.
    """

    def __init__(self, chip: Chip, stop: int) -> None:
        self._machine = chip.machine
        self._name = chip.name
        self._stop = stop
        self._start = chip.pc
        self._latch = chip.machine.pins.latch
        self._gosubs = tuple(self._machine.gosubs)
        self._steps: dict[int, Step] = {}
        self._blocks: dict[int, Function | None] = {}
        self.words = self._machine.registers.words
        self._before = tuple(self.words)
        self.instructions = 0

    @property
    def before(self) -> tuple[int, ...]:
        """The register file as it was at the beginning."""
        return self._before

    @property
    def latch(self) -> int:
        """The output latch."""
        return self._machine.pins.latch

    def call(self, words: Sequence[int]) -> int:
        """Run from the beginning to `stop`.

        Args:
            words: the register file at the beginning, 16 words.

        Returns:
            How long the chip takes, in nanoseconds.

        Raises:
            ExecutionError: it does not come to the end, or does what takes a bench.
        """
        machine, stop = self._machine, self._stop
        self.words[:] = words
        machine.gosubs[:] = self._gosubs
        machine.last_return = 0
        machine.pins.latch = self._latch
        blocks = self._blocks
        address, took = self._start, 0
        while address != stop:
            block = blocks.get(address)
            if block is None:
                if address not in blocks:
                    made = block_at(address, self.step_at, machine.unknowns)
                    blocks[address] = made.function if made else None
                    continue
                address, spent = self._single(address)
            else:
                address, spent = block(self.words, machine)
                if address < 0:
                    address, more = self._single(~address)
                    spent += more
            took += spent
            if took & (1 << COUNT_BITS) - 1 > MOST_INSTRUCTIONS:
                raise ExecutionError(
                    f"{self._name}: a routine that began at {self._start} has not come to "
                    f"{stop} after {MOST_INSTRUCTIONS} instructions; it hangs there"
                )
        self.instructions = took & (1 << COUNT_BITS) - 1
        return took >> COUNT_BITS

    def _single(self, address: int) -> tuple[int, int]:
        """Carry one instruction out; returns where the program is then, and what it took."""
        step = self.step_at(address)
        if step.action is None:
            raise ExecutionError(
                f"{self._name}: {step.instruction.name} at {address} takes a bench; "
                "a routine that is called must not have it"
            )
        target = step.action(self._machine, step.instruction)
        took = step.ns << COUNT_BITS | 1
        if target is None:
            return step.instruction.end, took
        return target, took + (step.jump_ns << COUNT_BITS)

    def step_at(self, address: int) -> Step:
        """Return an instruction of the slot that runs."""
        step = self._steps.get(address)
        if step is None:
            machine = self._machine
            instruction = machine.memory.slots[machine.slot].at(address)
            step = self._steps[address] = step_of(instruction, machine.timing)
        return step
