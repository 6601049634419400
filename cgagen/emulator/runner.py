"""How a chip goes on: fetch, wait until the bench has caught up, act.

A chip runs ahead of the clock while it touches no pin. Before an instruction with pins acts, and
at the end of every delay, the clock has come to where the chip is; where nobody else on the
bench has anything to do before that, the chip moves the clock itself.
"""

from collections.abc import Callable, Sequence
from typing import Any

from cgagen.emulator.blocks import COUNT_BITS, block_at
from cgagen.emulator.chip_state import Coverage, End, Program
from cgagen.emulator.clock import NEVER_NS, Clock
from cgagen.emulator.engaged import Engaged
from cgagen.emulator.machine import Machine
from cgagen.emulator.memory import Memory
from cgagen.emulator.pins import Pins
from cgagen.emulator.steps import Step, step_of
from cgagen.emulator.timing import Timing, timing_of
from cgagen.emulator.unknowns import CHOICES, Unknowns
from cgagen.errors import BenchError, ExecutionError, ImageError
from cgagen.stamp.compiled import Compiled
from cgagen.stamp.image import Image
from cgagen.stamp.symbols import Symbols

RUN_AHEAD_NS = 5_000_000
"""How far a chip may be ahead of the bench while it touches no pin. Ref: choice; nothing that can
be seen from outside depends on it."""

_UNTRIED = object()


class Runner(Engaged):
    """The part of `cgagen.emulator.chip.Chip` that carries a program out; see there."""

    def __init__(
        self,
        name: str,
        images: Sequence[Image | Compiled],
        clock: Clock,
        *,
        timing: Timing | None = None,
        unknowns: Unknowns = CHOICES,
        floated: Callable[[int], None] = lambda pin: None,
        compile_after: int | None = 2,
    ) -> None:
        bare = [one.image if isinstance(one, Compiled) else one for one in images]
        models = {image.model.name: image.model for image in bare}
        slots = {image.slot: image.eeprom for image in bare}
        if len(models) != 1 or len(slots) != len(bare):
            raise BenchError(
                f"{name}: give one image for each program slot, all for one model, not "
                f"{len(bare)} for {', '.join(models) or 'none'}"
            )
        (model,) = models.values()
        self.name = name
        self.clock = clock
        self.programs = {one.image.slot: one for one in images if isinstance(one, Compiled)}
        memory = Memory(model, slots, self._forget)
        self.machine = Machine(
            model, memory, Pins(name, floated), timing or timing_of(model), unknowns
        )
        self.instructions = 0
        self.coverage: Coverage | None = None
        self.on_wait: Callable[[], None] | None = None
        self._programs = [Program() for _ in memory.slots]
        self._compile_after = compile_after
        self._hooks: dict[tuple[int, int], list[Callable[[Any], None]]] = {}
        self._each: list[Callable[[Any], None]] = []
        self._watch: Callable[[], bool] | None = None
        self._symbols: dict[int, tuple[Compiled, Symbols]] = {}
        self._step: Step | None = None
        self.ended: End | None = None
        self.ended_ns: int | None = None
        super().__init__(self._proceed)
        self._begin(0)

    def _begin(self, hold_ns: int) -> None:
        self.ended = self.ended_ns = None
        self.local_ns = self.clock.now_ns + hold_ns
        self._slice_ns = self._limit_ns = 0
        self._settled = False
        self._answer = self._step = self._waiting = None
        self._timer.at(self.local_ns)

    def _forget(self, slot: int) -> None:
        """A slot's program was written over."""
        self._programs[slot] = Program()

    def step_at(self, address: int) -> Step:
        """Return an instruction of the slot that runs.

        Raises:
            ExecutionError: there is none.
        """
        slot = self.machine.slot
        steps = self._programs[slot].steps
        step = steps.get(address)
        if step is None:
            try:
                instruction = self.machine.memory.slots[slot].at(address)
            except ImageError as error:
                raise ExecutionError(f"{self.name}: slot {slot}, {error}") from error
            timing, after = self.machine.timing, self._compile_after
            step = steps[address] = step_of(instruction, timing, after)
        return step

    def _proceed(self) -> None:
        """The clock has come to where something goes on."""
        waiting = self._waiting
        if waiting is not None:
            self._waited(waiting)
        while self._go_on():
            pass

    def _go_on(self) -> bool:
        """Do the next thing; False when the chip has to wait for others, or for ever."""
        if self._under_way is not None:
            return self._carry_on(self._under_way)
        if self._pulsing is not None:
            if not self._reach():
                return False
            self._end_pulse(*self._pulsing)
            return True
        if self._step is not None:
            if not self._reach():
                return False
            step, self._step = self._step, None
            self._act(step)
            return True
        return self.ended is None and self._fetch()

    def _reach(self) -> bool:
        """Make the clock stand where the chip is; False where others come first."""
        if self.clock.now_ns == self.local_ns or self.clock.advance(self.local_ns):
            return True
        self._timer.at(self.local_ns)
        return False

    def _fetch(self) -> bool:
        machine = self.machine
        if self.local_ns >= self._slice_ns:
            if not self._reach():
                return False
            self._set_limits()
        if machine.polling.active or self._hooks or self._each or self._watch is not None:
            if not self._settled and not self._settle():
                return False
            self._settled = False
        elif self._compile_after is not None and self.coverage is None:
            return self._dash(self._compile_after)
        return self._single(self.step_at(machine.pc))

    def _single(self, step: Step) -> bool:
        """Carry out one instruction; False where others come first."""
        self.local_ns += step.ns
        if step.on_pins and not self._reach():
            self._step = step
            return False
        self._act(step)
        return True

    def _dash(self, compile_after: int) -> bool:
        """Go on by the quick ways: what is compiled, and pulses whose edges nobody looks at.

        Nobody else has a say meanwhile; ends with an instruction of another kind.
        """
        machine, clock = self.machine, self.clock
        program = self._programs[machine.slot]
        while True:
            if self.local_ns >= self._slice_ns:
                if clock.now_ns != self.local_ns:
                    break
                self._set_limits()
                if self.local_ns >= self._slice_ns:
                    break
            if program.blocks.get(machine.pc, _UNTRIED) is not None:
                self._sprint(compile_after)
                if self.local_ns >= self._slice_ns:
                    continue
            step = program.steps.get(machine.pc) or self.step_at(machine.pc)
            if not step.pulse:
                return self._single(step)
            self.local_ns += step.ns
            if not clock.advance(self.local_ns) and not self._reach():
                self._step = step
                return False
            if not self._pulse_unseen(step):
                self._act(step)
                break
            self.instructions += 1
        return True

    def _set_limits(self) -> None:
        """Note how far to go before the bench must have caught up.

        An instruction begins before `_slice_ns`, and a block ends before `_limit_ns`: so a run
        ends between the same two instructions whether they are compiled or not.
        """
        clock = self.clock
        in_run = clock.limit_ns >= clock.now_ns
        self._limit_ns = clock.limit_ns + 1 if in_run else NEVER_NS
        self._slice_ns = min(self.local_ns + RUN_AHEAD_NS, self._limit_ns)

    def _sprint(self, compile_after: int) -> None:
        """Carry out what is compiled, as far as it goes."""
        machine = self.machine
        program = self._programs[machine.slot]
        blocks, words, address = program.blocks, machine.registers.words, machine.pc
        local_ns, took = self.local_ns, 0
        room, limit = self._slice_ns - local_ns << COUNT_BITS, self._limit_ns - local_ns
        while took < room:
            block = blocks.get(address)
            if block is None:
                if address in blocks or not program.worn(address, compile_after):
                    break
                blocks[address] = block_at(address, self.step_at, machine.unknowns)
                continue
            if (took >> COUNT_BITS) + block.most_ns > limit:
                break
            address, spent = block.function(words, machine)
            took += spent
            if address < 0:
                address = ~address
                break
        machine.pc = address
        self.local_ns += took >> COUNT_BITS
        self.instructions += took & (1 << COUNT_BITS) - 1

    def _settle(self) -> bool:
        """Poll, call hooks and look whether to stop, all of it between two instructions."""
        self._settled = False
        if not self._reach():
            return False
        self._settled = True
        machine = self.machine
        if machine.polling.active:
            slot = machine.polling.poll(machine.groups)
            if slot is not None:
                machine.pc = machine.run_slot(slot)
                self.local_ns += machine.timing.jump_ns
                return self._settle()  # a mode that runs a slot does so once, so not for ever
        try:
            for hook in (*self._hooks.get((machine.slot, machine.pc), ()), *self._each):
                hook(self)
            if self._watch is not None and self._watch():
                self.clock.stop()
        except BaseException:
            self._timer.at(self.local_ns)  # a fault of theirs is not the end of the program
            raise
        if self.clock.stopped:
            self._timer.at(self.local_ns)
            return False
        return True

    def _act(self, step: Step) -> None:
        """Carry out an instruction whose time has come."""
        machine, instruction = self.machine, step.instruction
        self.instructions += 1
        if self.coverage is not None:
            self.coverage.counts[machine.slot, instruction.address] += 1
        if step.action is None:
            if instruction.name in ("END", "STOP"):
                self.ended, self.ended_ns = End(instruction.name), self.local_ns
            if step.function is not None:
                quick = step.pulse and self._compile_after is not None and self._pulse(step)
                if not quick:
                    self._engage(step)
            return
        place = (machine.slot, instruction.address)
        target = step.action(machine, instruction)
        if self.coverage is not None and step.jump_ns:
            self.coverage.branch(place, target is not None)
        if target is None:
            machine.pc = instruction.end
            return
        machine.pc = target
        self.local_ns += step.jump_ns
        if target == instruction.address and instruction.name == "GOTO":
            if not machine.polling.active:
                self.ended, self.ended_ns = End.LOOP, self.local_ns
