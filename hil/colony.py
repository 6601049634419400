"""The emulated colony: predator and prey, four Stamps with their real images, in one arena.

What the sensors answer is reckoned by the simulator's own functions from the poses at the instant
at which a robot begins to sense; which movement a robot made is read from its servos' pulses. All
between the two, the decision, is the chips' own.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from hil.colony_bench import colony_bench
from hil.gait_reader import Reading
from hil.player import Player, step_wire
from hil.pursuit_step import pair_of, sensed, walked
from hil.referee import Referee
from hil.stride import Stride
from hil.subject import Subject
from hil.telemetry import Told
from sim.numbers import WorldNumbers
from sim.world import Pair

WORDS = ("predator", "prey")

STEP_LIMIT_NS = 10_000_000_000
"""How long both robots may take for one step, power-up included. Choice: four times the longest."""


@dataclass(frozen=True, slots=True)
class Act:
    """What one robot did in a step.

    Attributes:
        said: its telemetry; None where it says nothing.
        command: the movement that its servos made; None for none at all.
        trouble: what was wrong with it; empty where nothing was.
    """

    said: Told | None
    command: int | None
    trouble: str = ""


@dataclass(frozen=True, slots=True)
class ColonyStep:
    """One step of both robots.

    Attributes:
        number: from 1.
        predator: what it did.
        prey: likewise.
        pair: both poses after it.
        time_ns: when it ended.
        captured: whether the prey is caught.
    """

    number: int
    predator: Act
    prey: Act
    pair: Pair
    time_ns: int
    captured: bool


@dataclass
class _Log:
    steps: list[ColonyStep] = field(default_factory=list)
    trouble: str = ""


class Colony:
    """Both robots, from power-up.

    Args:
        predator: its programs.
        prey: likewise.
        numbers: of the world.
        start: where they stand, shape (1, 8).
        texts: other benches than the robots' own, by "predator" and "prey".
        referee: whether both robots' steps are one; without it each robot's pose changes when
            its own legs stand, and a robot may have three lines alone, without a step line.

    Attributes:
        bench: all of it, for faults and probes.
        players: by "predator" and "prey".
        pair: where they are.

    Raises:
        RigError: a robot without a step line, and a referee.
    """

    def __init__(
        self,
        predator: Subject,
        prey: Subject,
        numbers: WorldNumbers,
        start: NDArray[np.float64],
        texts: dict[str, str] | None = None,
        referee: bool = True,
    ) -> None:
        subjects = dict(zip(WORDS, (predator, prey), strict=True))
        self.bench = colony_bench(subjects, texts)
        self.numbers = numbers
        self.pair = pair_of(start)
        self.players = {
            word: Player(subject, self.bench, word) for word, subject in subjects.items()
        }
        self._log = _Log()
        self._referee = referee
        for index, (word, player) in enumerate(self.players.items()):
            self._watch_sensing(index, word, player)
        has_line = [word for word, one in subjects.items() if one.robot.link.step_line]
        self._wires = {
            word: step_wire(one, self.bench, word)
            for word, one in subjects.items()
            if referee or word in has_line
        }
        self.referee = self._seat(referee)
        for word in WORDS:
            if word not in self._wires:
                self._let_run(word)

    @property
    def steps(self) -> list[ColonyStep]:
        """What has happened so far."""
        return self._log.steps

    @property
    def trouble(self) -> str:
        """Why the colony does not go on; empty while it does."""
        return self._log.trouble

    @property
    def captured(self) -> bool:
        """Whether the prey is caught where they stand now."""
        scoring = self.numbers.scoring
        return scoring.longest - self.pair.distance > scoring.capture_score

    def play(self, steps: int, past_capture: bool = False) -> list[ColonyStep]:
        """Let both robots make steps, up to the capture or to the first trouble.

        Args:
            steps: at most so many, counted from power-up.
            past_capture: go on after the capture; the firmware knows no hold.
        """
        while len(self.steps) < steps and not self.trouble:
            if self.steps and self.steps[-1].captured and not past_capture:
                break
            self.step()
        return self.steps

    def step(self) -> ColonyStep | None:
        """Let both robots make one step; None where they do not get to its end."""
        before, clock = len(self.steps), self.bench.clock
        self.bench.run(clock.now_ns + STEP_LIMIT_NS)
        if len(self.steps) > before:
            return self.steps[-1]
        waiting = [word for word, one in self.players.items() if one.made is None]
        self._log.trouble = self._log.trouble or (
            f"{' and '.join(waiting)}: no finished step in {STEP_LIMIT_NS // 1_000_000_000} s of "
            "the robots' time"
        )
        return None

    # -- What happens ---------------------------------------------------------------------------

    def _seat(self, holds: bool) -> Referee:
        lines = {word: wire.line for word, wire in self._wires.items()}
        drivers = {word: wire.walk_driver for word, wire in self._wires.items()}
        referee = Referee("referee", self.bench.clock, lines, drivers, holds)
        referee.accepted, referee.finished = self._accepted, self._finished
        referee.released = self._released
        return self.bench.add_part(referee)

    def _let_run(self, word: str) -> None:
        """Read the servos of a robot that walks whatever its lines say."""
        player = self.players[word]

        def made(reading: Reading) -> None:
            player.made = reading
            self._moved([word])

        Stride(player.gait, self.bench, f"{word}_locomotion", made)

    def _watch_sensing(self, index: int, word: str, player: Player) -> None:
        """Set the sensors when the first sonar is triggered: then sensing has begun."""
        pin, chip = player.subject.robot.sonars[0].pins[0], self.bench.chip(f"{word}_main")
        wire, driver = chip.pins.wires[pin], f"{word}_main.P{pin}"

        def trigger(level: int | None) -> None:
            if level == 1 and driver in wire.drivers:
                player.show(sensed(self.pair, self.numbers)[index])

        chip.on_pin(pin, trigger)

    def _accepted(self, word: str) -> None:
        """A locomotion controller pulls its step line low."""
        player, wire = self.players[word], self._wires[word]
        self._rested(word, player)
        player.told = wire.go_driver in wire.line.drivers

    def _finished(self, word: str) -> None:
        """It lets go: the legs stand."""
        player = self.players[word]
        if not player.told:
            self._rested(word, player)
            return
        player.made = player.gait.read(player.gait.take())
        if not self._referee:
            self._moved([word])

    def _rested(self, word: str, player: Player) -> None:
        trouble = player.gait.rested(player.gait.take())
        if trouble and not self._log.trouble:
            self._log.trouble = f"{word}: {trouble}"

    def _released(self) -> None:
        if self._referee and any(player.made for player in self.players.values()):
            self._moved(list(WORDS))

    def _moved(self, words: list[str]) -> None:
        """Change the poses by what the servos made of them, and note the step."""
        predator, prey = (
            _act(self.players[word]) if word in words else Act(None, None) for word in WORDS
        )
        self.pair = walked(self.pair, predator.command, prey.command, self.numbers)
        for word, act in zip(WORDS, (predator, prey), strict=True):
            if act.trouble and not self._log.trouble:
                self._log.trouble = f"{word}: {act.trouble}"
        number, now_ns = len(self.steps) + 1, self.bench.clock.now_ns
        step = ColonyStep(number, predator, prey, self.pair, now_ns, self.captured)
        self.steps.append(step)
        for word in words:
            self.players[word].made = self.players[word].said = None
        self.bench.clock.stop()


def _act(player: Player) -> Act:
    made = player.made
    if made is None:
        return Act(player.said, None)
    return Act(player.said, made.command, made.reason)
