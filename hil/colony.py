"""The emulated colony: predator and prey, four Stamps with their real images, in one arena.

What the sensors answer is reckoned by the simulator's own functions from the poses at the instant
at which a robot begins to sense; which movement a robot made is read from its servos' pulses. All
between the two, the decision, is the chips' own.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from cgagen.emulator.bench import Bench
from cgagen.emulator.parts.photocell import Photocell
from cgagen.emulator.parts.sonar import Sonar, middle_ns
from cgagen.emulator.parts.whisker import Whisker
from cgagen.errors import RigError
from hil.colony_bench import colony_bench
from hil.forced import Forced
from hil.gait_reader import GaitReader, Reading
from hil.pursuit_step import pair_of, sensed, walked
from hil.referee import Referee
from hil.subject import Subject
from hil.target import Stimulus
from hil.telemetry import Told, parse_telemetry
from sim.numbers import WorldNumbers
from sim.world import Pair

WORDS = ("predator", "prey")

STEP_LIMIT_NS = 10_000_000_000
"""How long both robots may take for one step, power-up included. Choice: four times the longest."""


class Player:
    """One robot of the colony: its parts, and what it has done in this step.

    Attributes:
        subject: its programs.
        word: before the names of its parts.
        gait: reads its servos.
        said: the last line of its telemetry; None before it.
        made: the movement of this step; None where it has made none.
        starts: how often its locomotion controller began without being told: its resets.
        heard: all that its main controller has said.
    """

    def __init__(self, subject: Subject, bench: Bench, word: str) -> None:
        link = subject.robot.link
        if link.step_line is None:
            raise RigError(
                f"{subject.robot.name}: has no step line, so nobody can say when a step is "
                "finished; give it one ([link.step_line]) or let it run free"
            )
        self.subject = subject
        self.word = word
        self.line = bench.wire(f"{word}_step")
        self.go_driver = f"{word}_main.P{link.step_line.main_pin}"
        self.walk_driver = f"{word}_locomotion.P{link.step_line.locomotion_pin}"
        self.gait = GaitReader(subject.robot, bench, f"{word}_")
        self.said: Told | None = None
        self.made: Reading | None = None
        self.starts = 0
        self.told = False
        self.heard = ""
        self._bytes = bytearray()
        self._forced: list[Forced] = []
        sonars = bench.parts_of(Sonar)
        for sonar in subject.robot.sonars:
            self._forced.append(Forced())
            sonars[f"{word}_sonar_{sonar.name}"].spoilers.insert(0, self._forced[-1])
        antennas, light = subject.robot.antennas, subject.robot.light
        self._whiskers = [bench.part(f"{word}_antenna_{one.name}", Whisker) for one in antennas]
        lamps = light.sensors if light else ()
        self._cells = [bench.part(f"{word}_light_{one.name}", Photocell) for one in lamps]
        bench.host(f"{word}_main").heard = self._heard

    def show(self, stimulus: Stimulus) -> None:
        """Put all that there is to be measured before the sensors."""
        main = self.subject.robot.main
        for forced, one in zip(self._forced, stimulus.sonars, strict=True):
            forced.width_ns = middle_ns(one, main.pulsin_unit_ns) if one else None
        for whisker, bent in zip(self._whiskers, stimulus.touched, strict=True):
            whisker.touch(bent)
        for cell, one in zip(self._cells, stimulus.lights, strict=True):
            cell.drain(middle_ns(one, main.rctime_unit_ns) if one else None)

    def _heard(self, byte: int) -> None:
        self._bytes.append(byte)
        if byte == 0x0D:
            line = self._bytes.decode("ascii", "replace")
            self._bytes.clear()
            self.heard += line
            self.said = parse_telemetry(line, self.subject.role) or self.said


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
            its own legs stand.

    Attributes:
        bench: all of it, for faults and probes.
        players: by "predator" and "prey".
        pair: where they are.

    Raises:
        RigError: a robot without a step line.
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
        self.referee = self._seat(referee)

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
        lines = {word: player.line for word, player in self.players.items()}
        drivers = {word: player.walk_driver for word, player in self.players.items()}
        referee = Referee("referee", self.bench.clock, lines, drivers, holds)
        referee.accepted, referee.finished = self._accepted, self._finished
        referee.released = self._released
        return self.bench.add_part(referee)

    def _watch_sensing(self, index: int, word: str, player: Player) -> None:
        """Set the sensors when the first sonar is triggered: then sensing has begun."""
        pin, chip = player.subject.robot.sonars[0].pins[0], self.bench.chip(f"{word}_main")
        wire, driver = chip.pins.wires[pin], f"{word}_main.P{pin}"

        def trigger(level: int | None) -> None:
            if level == 1 and driver in wire.drivers:
                player.show(sensed(self.pair, self.numbers)[index])

        chip.on_pin(pin, trigger)

    def _accepted(self, word: str) -> None:
        """A locomotion controller pulls its step line low: told to, or since it was reset."""
        player = self.players[word]
        self._rested(word, player)
        player.told = player.go_driver in player.line.drivers
        player.starts += not player.told

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
