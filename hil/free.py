"""One emulated robot on three lines that is watched: every look, every movement, and the lines.

Nothing says on three lines when a decision is told or a movement begins: a look begins with the
first sonar's trigger, a decision is told when its lines are driven, and a movement is read from
the servos.
"""

from collections.abc import Callable
from dataclasses import dataclass

from cgagen.emulator.bench import Bench
from cgagen.emulator.chip import Chip
from hil.colony_bench import colony_bench
from hil.gait_reader import GaitReader, Reading
from hil.player import Player
from hil.stride import LEADING_FRAMES as BETWEEN_FRAMES
from hil.stride import Stride
from hil.subject import Subject
from hil.target import Stimulus

WORD = "robot"
MS = 1_000_000
STEP_NS = 20 * MS


@dataclass(frozen=True, slots=True)
class Made:
    """One movement.

    Attributes:
        reading: which, by its pulses.
        said: what the lines said from the end of the movement before to the beginning of this
            one; undriven lines say 0.
        starts_ns: when the first servo's pulses began, of the frames before it, too.
    """

    reading: Reading
    said: frozenset[int]
    starts_ns: tuple[int, ...]

    @property
    def time_ns(self) -> int:
        """From its first frame to its last."""
        return self.starts_ns[-1] - self.starts_ns[-self.reading.frames]


class Free:
    """A robot on three lines, on a bench of its own, from power-up.

    Args:
        subject: its programs.

    Attributes:
        bench: the robot.
        made: its movements, the newest last.
        looks_ns: when its main controller began to look.
        told_ns: when it first drove its lines, since power-up and since each reset of it.
        bytes_said: by its main controller, at each look.
    """

    def __init__(self, subject: Subject) -> None:
        self.subject = subject
        self.bench: Bench = colony_bench({WORD: subject})
        self.made: list[Made] = []
        self.looks_ns: list[int] = []
        self.told_ns: list[int] = []
        self.bytes_said: list[int] = []
        self._said: list[tuple[int, int]] = [(0, 0)]
        self._starts: list[int] = []
        self._bytes = 0
        self._player = player = Player(subject, self.bench, WORD)
        self._main = self.bench.chip(f"{WORD}_main")
        self.bench.host(f"{WORD}_main").heard = self._heard
        first = subject.robot.sonars[0].pins[0]
        self.bench.end(f"{WORD}_main.P{first}").listen(lambda level: self._look(level, first))
        servo = player.gait.servos[0]
        self.bench.end(f"{WORD}_servo_{servo}.signal").listen(self._pulse)
        for bit in range(3):
            self.bench.wire(f"{WORD}_command_{bit}").listen(lambda _level: self._changed())
        self._follow(player.gait)
        self._unwatch: Callable[[], None] = _nothing
        self._watch()

    @property
    def now_ns(self) -> int:
        """The time."""
        return self.bench.clock.now_ns

    def show(self, stimulus: Stimulus) -> None:
        """Put a reading before the sensors, from now on."""
        self._player.show(stimulus)

    def run(self, ms: float) -> None:
        """Let time go by."""
        self.bench.run(self.now_ns + round(ms * MS))

    def walk(self, walks: int, limit_ms: int = 8_000) -> bool:
        """Go on until so many more movements are made; returns whether they were in time."""
        wanted, end_ns = len(self.made) + walks, self.now_ns + limit_ms * MS
        while len(self.made) < wanted and self.now_ns < end_ns:
            self.bench.run(min(self.now_ns + STEP_NS, end_ns))
        return len(self.made) >= wanted

    def reset_main(self) -> None:
        """Reset the main controller: its lines float, and say 0."""
        self.bench.reset(self._main.name)
        self._watch()

    def _follow(self, gait: GaitReader) -> None:
        def made(reading: Reading) -> None:
            starts = self._starts
            began_ns = starts[-reading.frames :][:BETWEEN_FRAMES][-1] if starts else self.now_ns
            said = frozenset(value for time_ns, value in self._said if time_ns <= began_ns)
            self.made.append(Made(reading, said, tuple(starts)))
            self._said, self._starts = [(0, self._lines())], []

        Stride(gait, self.bench, f"{WORD}_locomotion", made)

    def _watch(self) -> None:
        """Note when all lines are driven, once; to look at each instruction takes its time."""
        bits = sum(1 << pin for pin in self.subject.robot.link.main_pins)
        self._unwatch()

        def look(chip: Chip) -> None:
            if chip.pins.directions & bits == bits:
                self.told_ns.append(self.now_ns)
                self._unwatch()
                self._unwatch = _nothing

        self._unwatch = self._main.on_instruction(look)

    def _look(self, level: int | None, pin: int) -> None:
        if level == 1 and self._main.pins.directions >> pin & 1:
            self.looks_ns.append(self.now_ns)
            self.bytes_said.append(self._bytes)

    def _pulse(self, level: int | None) -> None:
        if level == 1:
            self._starts.append(self.now_ns)

    def _changed(self) -> None:
        self._said.append((self.now_ns, self._lines()))

    def _lines(self) -> int:
        wires = [self.bench.wire(f"{WORD}_command_{bit}").level or 0 for bit in range(3)]
        return sum(level << bit for bit, level in enumerate(wires))

    def _heard(self, _byte: int) -> None:
        self._bytes += 1


def _nothing() -> None:
    """Stop a watch that is over."""
