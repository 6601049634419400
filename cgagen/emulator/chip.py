r"""A chip: the machine, its time and its place on the bench.

A program of any kind, run and looked at::

    from cgagen.emulator.chip import Chip
    from cgagen.emulator.clock import Clock
    from cgagen.tokenizer import compile_source

    image = compile_source("' {$STAMP BS2}\nHIGH 3\nPAUSE 10\nLOW 3\n").image
    chip = Chip("demo", [image], Clock())
    chip.run_until(lambda: chip.pins.latch == 0b1000, limit_ns=1_000_000_000)
    start = chip.snapshot()             # in the middle of anything
    chip.run(until_ns=50_000_000)
    print(chip.ended, chip.instructions, chip.registers["W0"])
    chip.restore(start)                 # as if nothing had happened since
"""

from collections import Counter
from collections.abc import Callable, Sequence
from enum import StrEnum
from typing import NamedTuple

from cgagen.emulator.blocks import COUNT_BITS, Block, block_at
from cgagen.emulator.clock import NEVER_NS, Booking, Clock, Timer
from cgagen.emulator.machine import Machine
from cgagen.emulator.memory import Memory
from cgagen.emulator.pins import Pins
from cgagen.emulator.polling import Polling
from cgagen.emulator.port import Jump, Result
from cgagen.emulator.registers import Registers
from cgagen.emulator.requests import Delay
from cgagen.emulator.steps import Step, step_of
from cgagen.emulator.timing import Timing, timing_of
from cgagen.emulator.underway import Before, Recorded, UnderWay, before_of, put_back, repeated
from cgagen.emulator.unknowns import CHOICES, Unknowns
from cgagen.errors import BenchError, ExecutionError, ImageError
from cgagen.stamp.compiled import SourceMap
from cgagen.stamp.image import Image

RUN_AHEAD_NS = 5_000_000
"""How far a chip may be ahead of the bench while it touches no pin. Ref: choice; nothing that can
be seen from outside depends on it."""


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
    other_pins: tuple[int, int]
    on_aux: bool
    sout: int
    images: tuple[bytes, ...]
    place: tuple[int, int, int, int]
    gosubs: tuple[int, ...]
    polling: Polling
    local_ns: int
    ended: End | None
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


Hook = Callable[["Chip"], None]


class Chip:
    """One BASIC Stamp on a bench.

    Args:
        name: what the bench calls it; its pins are NAME.P0 and so on.
        images: one for each program slot that is not erased, all for one model.
        clock: the bench's. The chip starts at its present time.
        timing: durations in place of those of the model.
        unknowns: what no document says.
        floated: told a pin that is read while nobody drives it, once for each.
        compile_after: how often a piece of the program is carried out instruction by
            instruction before it is compiled; None never compiles. Nothing but speed depends
            on it.

    Attributes:
        clock: see above.
        machine: registers, pins, EEPROM and all that is not time.
        local_ns: how far the chip has come. It is ahead of the clock while it touches no pin,
            by `RUN_AHEAD_NS` at most, and never ahead of where `run` stops by more than what
            it was doing then.
        ended: why nothing happens any more, or None. Only a reset gets a chip out of that.
        instructions: carried out since the chip was made.
        coverage: see `cover`; None while nobody wants it.
        on_wait: called when an instruction begins to wait for a pin (see `waiting`), or None. It
            may book something, and must not touch a wire itself.

    Raises:
        BenchError: no image, several for one slot, or for different models.
        ImageError: an image for a slot that the model does not have.
    """

    def __init__(
        self,
        name: str,
        images: Sequence[Image],
        clock: Clock,
        *,
        timing: Timing | None = None,
        unknowns: Unknowns = CHOICES,
        floated: Callable[[int], None] = lambda pin: None,
        compile_after: int | None = 2,
    ) -> None:
        models = {image.model.name: image.model for image in images}
        slots = {image.slot: image.eeprom for image in images}
        if len(models) != 1 or len(slots) != len(images):
            raise BenchError(
                f"{name}: give one image for each program slot, all for one model, not "
                f"{len(images)} for {', '.join(models) or 'none'}"
            )
        (model,) = models.values()
        self.name = name
        self.clock = clock
        memory = Memory(model, slots, self._forget)
        self.machine = Machine(
            model, memory, Pins(name, floated), timing or timing_of(model), unknowns
        )
        self.instructions = 0
        self.coverage: Coverage | None = None
        self.on_wait: Callable[[], None] | None = None
        self._programs = [Program() for _ in memory.slots]
        self._compile_after = compile_after
        self._hooks: dict[tuple[int, int], list[Hook]] = {}
        self._each: list[Hook] = []
        self._watch: Callable[[], bool] | None = None
        self._timer = Timer(clock, self._proceed)
        self._stop_listening: Callable[[], None] = _nothing
        self._under_way: UnderWay | None = None
        self._step: Step | None = None
        self._waiting: Waiting | None = None
        self._answer: int | None = None
        self.ended: End | None = None
        self._begin(0)

    # -- What can be looked at --------------------------------------------------------------

    @property
    def pins(self) -> Pins:
        """The sixteen pins that are led out, SIN and SOUT."""
        return self.machine.main_pins

    @property
    def registers(self) -> Registers:
        """The register file: `chip.registers["W0"]`."""
        return self.machine.registers

    @property
    def scratch(self) -> bytearray:
        """The scratch pad RAM."""
        return self.machine.scratch

    @property
    def slot(self) -> int:
        """The program slot that runs."""
        return self.machine.slot

    @property
    def pc(self) -> int:
        """Stream address of the instruction under way, or of the next one."""
        return self.machine.pc

    @property
    def waiting(self) -> Waiting | None:
        """The pin that the instruction under way waits for, if any."""
        return self._waiting

    @property
    def waits_for_ever(self) -> bool:
        """Whether it waits for a pin without a time-out."""
        return self._waiting is not None and self._timer.due_ns is None

    def eeprom(self, slot: int = 0) -> bytes:
        """Return the bytes of a slot as they are now."""
        return bytes(self.machine.memory.slots[slot].data)

    def cover(self) -> Coverage:
        """Begin to count what is executed. Slower; nothing is counted before the first call."""
        if self.coverage is None:
            self.coverage = Coverage()
        return self.coverage

    def on_address(self, address: int, hook: Hook, slot: int = 0) -> Callable[[], None]:
        """Call `hook` whenever an instruction is about to begin; returns how to end that.

        The clock then stands at the beginning of the instruction. `chip.clock.stop()` in a hook
        ends the run there.
        """
        hooks = self._hooks.setdefault((slot, address), [])
        hooks.append(hook)

        def remove() -> None:
            hooks.remove(hook)
            if not hooks:
                self._hooks.pop((slot, address), None)

        return remove

    def on_line(
        self, source_map: SourceMap, line: int, hook: Hook, slot: int = 0
    ) -> Callable[[], None]:
        """Call `hook` whenever a line of the source is about to begin; returns how to end that.

        Raises:
            BenchError: no statement begins on that line.
        """
        bits = [statement.bit for statement in source_map.statements if statement.line == line]
        if not bits:
            raise BenchError(f"{self.name}: no statement begins on line {line}; name another")
        return self.on_address(bits[0], hook, slot)

    def on_instruction(self, hook: Hook) -> Callable[[], None]:
        """Call `hook` before every instruction; returns how to end that. Slower."""
        self._each.append(hook)
        return lambda: self._each.remove(hook)

    def on_pin(self, pin: int, hook: Callable[[int | None], None]) -> Callable[[], None]:
        """Call `hook` with the level of a pin's wire whenever it changes; None floats."""
        return self.pins.wires[pin].listen(hook)

    # -- What can be done -------------------------------------------------------------------

    def run(self, until_ns: int) -> None:
        """Let the clock go to a time, with everybody on it."""
        self.clock.run_until(until_ns)

    def run_until(self, condition: Callable[[], bool], limit_ns: int = NEVER_NS) -> bool:
        """Let the clock go on until a condition holds between two instructions of this chip.

        Args:
            condition: looked at before each instruction, at its exact time.
            limit_ns: the time at which it ends in any case.

        Returns:
            Whether the condition held; False too when nothing more can happen.
        """
        if condition():
            return True
        self._watch, held = condition, False
        try:
            while self.clock.next_ns() <= limit_ns:
                self.clock.run_until(min(limit_ns, self.clock.next_ns() + RUN_AHEAD_NS))
                held = condition()
                if held or self.clock.stopped or self.clock.now_ns >= limit_ns:
                    break
        finally:
            self._watch = None
        return held

    def reset(self, hold_ns: int = 0) -> None:
        """Press the reset button, or drop the supply: EEPROM stays, all else begins anew.

        Args:
            hold_ns: so long the chip does nothing, its pins inputs.
        """
        self._stop()
        self.machine.clear()
        self.pins.send(0)
        self._begin(hold_ns)

    def snapshot(self) -> ChipState:
        """Return everything about the chip, in the middle of an instruction too.

        Raises:
            ExecutionError: that instruction has gone on for too long; see
                `cgagen.emulator.underway`.
        """
        machine = self.machine
        on_aux = machine.pins is machine.aux_pins
        other = machine.main_pins if on_aux else machine.aux_pins
        polling = machine.polling
        return ChipState(
            now=before_of(machine),
            other_pins=(other.latch, other.directions),
            on_aux=on_aux,
            sout=int(self.pins.sout.name in self.pins.sout.drivers),
            images=machine.memory.images(),
            place=(machine.pc, machine.slot, machine.store_slot, machine.last_return),
            gosubs=tuple(machine.gosubs),
            polling=polling.copy(),
            local_ns=self.local_ns,
            ended=self.ended,
            instructions=self.instructions,
            settled=self._settled,
            fetched=self._step is not None,
            recorded=self._under_way.recorded() if self._under_way is not None else None,
            answer=self._answer,
            waiting=self._waiting,
            booking=self._timer.state(),
        )

    def state(self) -> ChipState:
        """Return the same as `snapshot`: what a bench calls."""
        return self.snapshot()

    def bookings(self) -> list[Booking]:
        """Return what this chip has booked now."""
        booking = self._timer.state()
        return [] if booking is None else [booking]

    def restore(self, state: ChipState) -> None:
        """Go back to a snapshot of this chip, or of another with the same model.

        The clock has been restored before (`Clock.restore`), and so have the wires where they
        are to be: a chip that finds its wires as it left them tells nobody.
        """
        machine = self.machine
        self._stop()
        machine.memory.load(state.images)
        machine.choose_port(state.on_aux)
        other = machine.main_pins if state.on_aux else machine.aux_pins
        machine.pins.restore(state.now.latch, state.now.directions)
        other.restore(*state.other_pins)
        self.pins.send(state.sout)
        put_back(machine, state.now)
        machine.pc, machine.slot, machine.store_slot, machine.last_return = state.place
        machine.gosubs[:] = state.gosubs
        machine.polling = state.polling.copy()
        self.local_ns = state.local_ns
        self._slice_ns = self._limit_ns = 0
        self.ended = state.ended
        self.instructions = state.instructions
        self._settled = state.settled
        self._answer = state.answer
        step = self._step_at(machine.pc) if state.fetched or state.recorded else None
        self._step = step if state.fetched else None
        if step is not None and state.recorded is not None:
            self._under_way = repeated(machine, step, state.recorded)
        if state.waiting is not None:
            self._listen(state.waiting)
        self._timer.restore(state.booking)

    # -- How it goes on ---------------------------------------------------------------------

    def _begin(self, hold_ns: int) -> None:
        self.ended = None
        self.local_ns = self.clock.now_ns + hold_ns
        self._slice_ns = self._limit_ns = 0
        self._settled = False
        self._answer = self._step = self._waiting = None
        self._timer.at(self.local_ns)

    def _stop(self) -> None:
        """Give up what is under way."""
        self._stop_listening()
        self._stop_listening = _nothing
        self._waiting = None
        self._timer.cancel()
        if self._under_way is not None:
            self._under_way.close()
            self._under_way = None

    def _forget(self, slot: int) -> None:
        """A slot's program was written over."""
        self._programs[slot] = Program()

    def _step_at(self, address: int) -> Step:
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
            step = steps[address] = step_of(instruction, self.machine.timing)
        return step

    def _proceed(self) -> None:
        """The clock has come to where something goes on."""
        waiting = self._waiting
        if waiting is not None:
            self._stop_listening()
            self._stop_listening = _nothing
            self._waiting = None
            self.local_ns = self.clock.now_ns
            met = waiting.met_ns
            self._answer = None if met is None else met - waiting.since_ns
        while self._go_on():
            pass

    def _go_on(self) -> bool:
        """Do the next thing; False when the chip has to wait for others, or for ever."""
        if self._under_way is not None:
            return self._carry_on(self._under_way)
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
            self._sprint(self._compile_after)
        step = self._step_at(machine.pc)
        self.local_ns += step.ns
        if step.on_pins:
            self._step = step
        else:
            self._act(step)
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
                blocks[address] = block_at(address, self._step_at, machine.unknowns)
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
        if not self._reach():
            return False
        self._settled = True
        machine = self.machine
        if machine.polling.active:
            slot = machine.polling.poll(machine.main_pins)
            if slot is not None:
                machine.pc = machine.run_slot(slot)
                self.local_ns += machine.timing.jump_ns
                self._settled = False
                return True
        for hook in (*self._hooks.get((machine.slot, machine.pc), ()), *self._each):
            hook(self)
        if self._watch is not None and self._watch():
            self.clock.stop()
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
                self.ended = End(instruction.name)
            if step.function is not None:
                self._under_way = UnderWay(machine, step)
                self._answer = None
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
                self.ended = End.LOOP

    def _carry_on(self, under_way: UnderWay) -> bool:
        """Meet the requests of an instruction as long as nobody else has to come first."""
        clock, send, answers = self.clock, under_way.generator.send, under_way.answers
        while clock.now_ns == self.local_ns or clock.advance(self.local_ns):
            answers.append(self._answer)
            try:
                request = send(self._answer)
            except StopIteration as stop:
                self._finish(under_way, stop.value)
                return True
            if type(request) is Delay:
                self._answer = request.ns
                self.local_ns += request.ns
            elif not self._met(*request):
                return False
        self._timer.at(self.local_ns)
        return False

    def _met(self, pin: int, level: int, timeout_ns: int) -> bool:
        """Answer `Until` if it can be answered at once; otherwise wait."""
        if self.machine.pins.peek(pin) == level:
            self._answer = 0
            return True
        if timeout_ns <= 0:
            self._answer = None
            return True
        now_ns = self.clock.now_ns
        self._listen(Waiting(pin, level, now_ns))
        if now_ns + timeout_ns < NEVER_NS:
            self._timer.at(now_ns + timeout_ns)
        if self.on_wait is not None:
            self.on_wait()
        return False

    def _listen(self, waiting: Waiting) -> None:
        self._waiting = waiting
        self._stop_listening = self.machine.pins.wires[waiting.pin].listen(self._heard)

    def _heard(self, level: int | None) -> None:
        """The wire that is waited for has changed."""
        waiting = self._waiting
        if waiting is not None and waiting.met_ns is None and (level or 0) == waiting.level:
            self._waiting = waiting._replace(met_ns=self.clock.now_ns)
            self._timer.after(0)

    def _finish(self, under_way: UnderWay, result: Result) -> None:
        """Store what an instruction found, and go on where it says."""
        machine, instruction = self.machine, under_way.step.instruction
        under_way.close()
        self._under_way = None
        if self.ended is not None:
            return
        if isinstance(result, int) and instruction.write is not None:
            machine.evaluator.store(instruction.write, result)
        jumped = isinstance(result, Jump)
        if self.coverage is not None and instruction.targets:
            self.coverage.branch((machine.slot, instruction.address), jumped)
        machine.pc = result.address if isinstance(result, Jump) else instruction.end
        if jumped:
            self.local_ns += machine.timing.jump_ns


def _nothing() -> None:
    pass
