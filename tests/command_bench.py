"""A bench without a chip: instructions as tasks on the clock and the wires, nothing else."""

from bisect import bisect_right
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

from cgagen.emulator.clock import NEVER_NS, Clock, Timer
from cgagen.emulator.pins import Pins
from cgagen.emulator.port import Result
from cgagen.emulator.requests import Command, Delay, Request
from cgagen.emulator.timing import timing_of
from cgagen.emulator.wires import Wire
from cgagen.stamp.chips import chip

US, MS = 1_000, 1_000_000


class Bytes:
    """32 register bytes."""

    def __init__(self) -> None:
        self.data = bytearray(32)

    def read_byte(self, element: int) -> int:
        return self.data[element % 32]

    def write_byte(self, element: int, value: int) -> None:
        self.data[element % 32] = value & 0xFF


class ToyPort:
    """What an instruction sees of a chip that does nothing else."""

    def __init__(self, model: str = "BS2", name: str = "chip") -> None:
        self.model = chip(model)
        self.pins = Pins(name)
        self.timing = timing_of(self.model)
        self.registers = Bytes()
        self.scratch = bytearray(self.model.scratch_bytes)


class Sent:
    """An output item."""

    def __init__(self, *values: int, fetch_ns: int = 0) -> None:
        self._values = values
        self.fetch_ns = fetch_ns

    def values(self) -> tuple[int, ...]:
        return self._values


class Got:
    """An input item; what it was given is in `taken`."""

    def __init__(self, *values: int, stores: bool = True, fetch_ns: int = 0) -> None:
        self._values = values
        self.stores = stores
        self.fetch_ns = fetch_ns
        self.taken: list[int] = []

    def values(self) -> tuple[int, ...]:
        return self._values

    def store(self, value: int) -> None:
        self.taken.append(value)


def text(data: bytes, fetch_ns: int = 0) -> list[Sent]:
    return [Sent(byte, fetch_ns=fetch_ns) for byte in data]


class Task:
    """One instruction under way.

    Attributes:
        done_ns: when it ended; None before.
        result: what it returned.
        requests: all that it asked for.
    """

    def __init__(self, clock: Clock, pins: Pins, command: Command[Result]) -> None:
        self._clock, self._pins, self._command = clock, pins, command
        self.done_ns: int | None = None
        self.result: Result = None
        self.requests: list[Request] = []
        clock.after(0, lambda: self._go(None))

    def _go(self, answer: int | None) -> None:
        while True:
            try:
                request = self._command.send(answer)
            except StopIteration as end:
                self.done_ns, self.result = self._clock.now_ns, end.value
                return
            self.requests.append(request)
            if isinstance(request, Delay):
                assert request.ns >= 0
                ns = request.ns
                self._clock.after(ns, lambda ns=ns: self._go(ns))  # type: ignore[misc]
                return
            assert request.timeout_ns >= 0
            if self._pins.peek(request.pin) == request.level:
                answer = 0
            elif request.timeout_ns == 0:
                answer = None
            else:
                self._wait(request.pin, request.level, request.timeout_ns)
                return

    def _wait(self, pin: int, level: int, timeout_ns: int) -> None:
        begun_ns = self._clock.now_ns
        timer: Timer | None = None

        def changed(new: int | None) -> None:
            if (new or 0) == level:
                stop()
                if timer is not None:
                    timer.cancel()
                self._clock.after(0, lambda: self._go(self._clock.now_ns - begun_ns))

        def over() -> None:
            stop()
            self._go(None)

        stop = self._pins.wires[pin].listen(changed)
        if timeout_ns < NEVER_NS:
            timer = self._clock.after(timeout_ns, over)


class Trace:
    """Every level that a wire had, and since when."""

    def __init__(self, clock: Clock, wire: Wire) -> None:
        self._clock = clock
        self.times_ns = [0]
        self.levels = [wire.level]
        wire.listen(self._heard)

    def _heard(self, level: int | None) -> None:
        self.times_ns.append(self._clock.now_ns)
        self.levels.append(level)

    def at(self, time_ns: int) -> int | None:
        return self.levels[bisect_right(self.times_ns, time_ns) - 1]

    @property
    def changes(self) -> list[tuple[int, int | None]]:
        """Without what lasted no time."""
        pairs = list(zip(self.times_ns, self.levels, strict=True))
        kept = [pair for pair, after in pairwise(pairs) if pair[0] < after[0]]
        kept.append(pairs[-1])
        return [
            pair for index, pair in enumerate(kept) if not index or pair[1] != kept[index - 1][1]
        ]


class Bench:
    """A clock, and tasks on it."""

    def __init__(self) -> None:
        self.clock = Clock()

    def start(self, port: ToyPort, command: Command[Result]) -> Task:
        return Task(self.clock, port.pins, command)

    def at(self, time_ns: int, action: Callable[[], Any]) -> None:
        self.clock.at(time_ns, action)

    def play(self, wire: Wire, changes: Sequence[tuple[int, int | None]]) -> None:
        """Drive a wire with these levels from these times on."""
        for time_ns, level in changes:
            self.at(time_ns, lambda level=level: wire.drive("played", level))  # type: ignore[misc]

    def trace(self, wire: Wire) -> Trace:
        return Trace(self.clock, wire)

    def run(self, until_ns: int = 10**12) -> None:
        while self.clock.next_ns() <= until_ns:
            self.clock.run_next()


def finished(command: Command[Result], port: ToyPort, until_ns: int = 10**12) -> Task:
    """Run one instruction alone to its end."""
    bench = Bench()
    task = bench.start(port, command)
    bench.run(until_ns)
    assert task.done_ns is not None, "the instruction did not end"
    return task
