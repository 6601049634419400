"""How a chip carries on an instruction that takes time: its requests, and what comes of it."""

from collections.abc import Callable

from cgagen.emulator.chip_state import Coverage, End, Waiting
from cgagen.emulator.clock import NEVER_NS, Clock, Timer
from cgagen.emulator.commands.levels import LAST_PIN
from cgagen.emulator.machine import Machine
from cgagen.emulator.port import Jump, Result
from cgagen.emulator.requests import Delay
from cgagen.emulator.steps import Step
from cgagen.emulator.underway import Recorded, UnderWay, before_of


class Engaged:
    """The part of `cgagen.emulator.chip.Chip` that is busy with one instruction; see there."""

    clock: Clock
    machine: Machine
    local_ns: int
    ended: End | None
    coverage: Coverage | None
    on_wait: Callable[[], None] | None

    def __init__(self, proceed: Callable[[], None]) -> None:
        self._timer = Timer(self.clock, proceed)
        self._stop_listening: Callable[[], None] = _nothing
        self._under_way: UnderWay | None = None
        self._pulsing: tuple[int, int] | None = None
        """A PULSOUT without a generator: the pin that it has inverted, and its end's address."""
        self._waiting: Waiting | None = None
        self._answer: int | None = None

    def _stop(self) -> None:
        """Give up what is under way."""
        self._stop_listening()
        self._stop_listening = _nothing
        self._waiting = None
        self._timer.cancel()
        if self._under_way is not None:
            self._under_way.close()
            self._under_way = None
        self._pulsing = None

    def _recorded(self) -> Recorded | None:
        """Return the instruction under way as a value."""
        if self._pulsing is not None:
            pins, bit = self.machine.pins, 1 << self._pulsing[0]
            pins.latch ^= bit  # as it was before the pulse
            before = before_of(self.machine)
            pins.latch ^= bit
            return Recorded(before, (), (None,))
        return self._under_way.recorded() if self._under_way is not None else None

    def _waited(self, waiting: Waiting) -> None:
        """The pin has the level that was waited for, or the time is over."""
        self._stop_listening()
        self._stop_listening = _nothing
        self._waiting = None
        self.local_ns = self.clock.now_ns
        met = waiting.met_ns
        self._answer = None if met is None else met - waiting.since_ns

    def _engage(self, step: Step) -> None:
        """Begin with an instruction."""
        self._under_way = UnderWay(self.machine, step)
        self._answer = None

    def _carry_on(self, under_way: UnderWay) -> bool:
        """Meet the requests of an instruction as long as nobody else has to come first."""
        clock, send, answers = self.clock, under_way.generator.send, under_way.answers
        while clock.now_ns == self.local_ns or clock.advance(self.local_ns):
            answer = self._answer
            answers.append(answer)
            try:
                request = send(answer)
            except StopIteration as stop:
                self._finish(under_way, stop.value)
                return True
            if type(request) is Delay:
                self._answer = ns = request.ns
                self.local_ns += ns
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

    def _pulse_unseen(self, step: Step) -> bool:
        """Carry out a plain PULSOUT whose edges nobody sees; False, and nothing happens, else.

        A robot's legs take 600 pulses a second. Where nothing else happens during one and those
        who listen need no edges, they are told when it is over.
        """
        machine = self.machine
        made, pins = step.arguments.of(machine), machine.pins
        takers = pins.takers(made["pin"] & LAST_PIN)
        if takers is None or not made["duration"]:
            return False
        began_ns = self.local_ns
        width_ns = made["duration"] * machine.timing.pulsout_ns
        if not self.clock.advance(began_ns + width_ns):
            return False
        self.local_ns = began_ns + width_ns
        self._answer = width_ns
        machine.pc = step.instruction.end
        for taker in takers:
            taker(began_ns)
        return True

    def _pulse(self, step: Step) -> bool:
        """Begin a plain PULSOUT without a generator; False, and nothing happens, for others."""
        machine = self.machine
        made, pins = step.arguments.of(machine), machine.pins
        pin = made["pin"] & LAST_PIN
        width_ns = made["duration"] * machine.timing.pulsout_ns
        if not width_ns or not pins.directions >> pin & 1:
            return False
        pins.invert(pin)
        self.local_ns += width_ns
        self._answer = width_ns
        self._pulsing = pin, step.instruction.end
        return True

    def _end_pulse(self, pin: int, end: int) -> None:
        """The clock stands at the end of a pulse."""
        self._pulsing = None
        self.machine.pins.invert(pin)
        self.machine.pc = end


def _nothing() -> None:
    pass
