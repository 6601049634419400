"""A chip: the machine, its time and its place on the bench. `cgagen.emulator` has an example."""

from collections.abc import Callable

from cgagen.emulator.chip_state import ChipState, Coverage, End, Waiting
from cgagen.emulator.clock import NEVER_NS, Booking
from cgagen.emulator.named import Named
from cgagen.emulator.pins import Pins
from cgagen.emulator.registers import Registers
from cgagen.emulator.runner import RUN_AHEAD_NS
from cgagen.emulator.underway import before_of, put_back, repeated
from cgagen.errors import BenchError

__all__ = ["Chip", "ChipState", "Coverage", "End", "Hook", "Waiting"]

Hook = Callable[["Chip"], None]


class Chip(Named):
    """One BASIC Stamp on a bench.

    Args:
        name: what the bench calls it; its pins are NAME.P0 and so on.
        images: one for each program slot that is not erased, all for one model; where it is a
            compiled source, its names are known.
        clock: the bench's. The chip starts at its present time.
        timing: durations in place of those of the model.
        unknowns: what no document says.
        floated: told a pin that is read while nobody drives it, once for each.
        compile_after: how often a piece of the program is carried out instruction by
            instruction before it is compiled; None never compiles. Nothing but speed depends
            on it.

    Attributes:
        clock: see above.
        programs: the sources that are known, by slot; see `cgagen.emulator.named`.
        machine: registers, pins, EEPROM and all that is not time.
        local_ns: how far the chip has come. It is ahead of the clock while it touches no pin,
            by `RUN_AHEAD_NS` at most, and never ahead of where `run` stops by more than what
            it was doing then.
        ended: why nothing happens any more, or None. Only a reset gets a chip out of that.
        ended_ns: since when, by the bench's clock.
        instructions: carried out since the chip was made.
        coverage: see `cover`; None while nobody wants it.
        on_wait: called when an instruction begins to wait for a pin (see `waiting`), or None. It
            may book something, and must not touch a wire itself.

    Raises:
        BenchError: no image, several for one slot, or for different models.
        ImageError: an image for a slot that the model does not have.
    """

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
        """Return the bytes of a slot as they are now.

        Raises:
            ValueError: the model has no such slot.
        """
        slots = self.machine.memory.slots
        if not 0 <= slot < len(slots):
            model = self.machine.model.name
            raise ValueError(
                f"{self.name}: a {model} has no slot {slot}; give 0 to {len(slots) - 1}"
            )
        return bytes(slots[slot].data)

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

    def on_line(self, line: int, hook: Hook, slot: int = 0) -> Callable[[], None]:
        """Call `hook` whenever a line of the source is about to begin; returns how to end that.

        Args:
            line: from 1; of several statements on it, the first.
            hook: called; see `on_address`.
            slot: whose source it is.

        Raises:
            SymbolError: the source of that slot is not known.
            BenchError: no statement begins on that line; the nearest lines.
        """
        compiled = self.source(slot)
        lines = {one.line: one.bit for one in reversed(compiled.source_map.statements)}
        if line not in lines:
            near = " and ".join(map(str, sorted(sorted(lines, key=lambda n: abs(n - line))[:2])))
            raise BenchError(
                f"{self.name}: no statement begins on line {line} of {compiled.name}; "
                f"name another, the nearest are {near or 'none'}"
            )
        return self.on_address(lines[line], hook, slot)

    def on_label(self, label: str, hook: Hook, slot: int = 0) -> Callable[[], None]:
        """Call `hook` whenever what is behind a label is about to begin; returns how to end that.

        Raises:
            SymbolError: the program in that slot has no such label, or no known source.
        """
        return self.on_address(self.symbols(slot).label(label), hook, slot)

    def on_instruction(self, hook: Hook) -> Callable[[], None]:
        """Call `hook` before every instruction; returns how to end that. Slower."""
        self._each.append(hook)
        return lambda: self._each.remove(hook)

    def on_pin(self, pin: int | str, hook: Callable[[int | None], None]) -> Callable[[], None]:
        """Call `hook` with the level of a pin's wire whenever it changes; None floats.

        Args:
            pin: its number, or its name: a PIN of the program, or P3.
            hook: called; see above.

        Raises:
            SymbolError: the program has no such pin.
        """
        return self.pins.wires[self.pin_number(pin)].listen(hook)

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
        self.hold()
        self._begin(hold_ns)

    def hold(self) -> None:
        """Keep the reset button pressed: pins are inputs and nothing runs until `reset`."""
        self._stop()
        self.machine.clear()
        self.pins.send(0)
        self.ended = self.ended_ns = self._step = None

    def snapshot(self) -> ChipState:
        """Return everything about the chip, in the middle of an instruction too.

        Raises:
            ExecutionError: that instruction has gone on for too long; see
                `cgagen.emulator.underway`.
        """
        machine = self.machine
        polling = machine.polling
        return ChipState(
            now=before_of(machine),
            on_aux=machine.pins is machine.aux_pins,
            sout=int(self.pins.sout.name in self.pins.sout.drivers),
            images=machine.memory.images(),
            place=(machine.pc, machine.slot, machine.store_slot, machine.last_return),
            gosubs=tuple(machine.gosubs),
            polling=polling.copy(),
            local_ns=self.local_ns,
            ended=self.ended,
            ended_ns=self.ended_ns,
            instructions=self.instructions,
            settled=self._settled,
            fetched=self._step is not None,
            recorded=self._recorded(),
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
        main, aux = state.now.groups
        machine.main_pins.restore(*main)
        if (machine.aux_pins.latch, machine.aux_pins.directions) != aux:
            machine.aux_pins.restore(*aux)  # nobody else is on these wires
        self.pins.send(state.sout)
        put_back(machine, state.now)
        machine.pc, machine.slot, machine.store_slot, machine.last_return = state.place
        machine.gosubs[:] = state.gosubs
        machine.polling = state.polling.copy()
        self.local_ns = state.local_ns
        self._slice_ns = self._limit_ns = 0
        self.ended, self.ended_ns = state.ended, state.ended_ns
        self.instructions = state.instructions
        self._settled = state.settled
        self._answer = state.answer
        step = self.step_at(machine.pc) if state.fetched or state.recorded else None
        self._step = step if state.fetched else None
        if step is not None and state.recorded is not None:
            self._under_way = repeated(machine, step, state.recorded)
        if state.waiting is not None:
            self._listen(state.waiting)
        self._timer.restore(state.booking)
