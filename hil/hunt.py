"""One hunt in the emulated colony next to the simulator's episode from the same start."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cgagen.genome import Genome
from cgagen.run.streams import Purpose, stream
from hil.colony import Act, Colony, ColonyStep
from hil.pursuit_step import stimuli_of
from hil.subject import Subject
from sim.episode import play_recorded
from sim.model import words_of
from sim.numbers import WorldNumbers
from sim.starts import draw_starts

FIXED_STARTS_SEED = 0
"""The seed of the starts that evolution judges its best by: the default of a run."""


@dataclass(frozen=True, slots=True)
class Difference:
    """The first thing in which both are not equal.

    Attributes:
        step: from 1.
        what: for example "prey state".
        expected: by the simulator.
        observed: in the colony.
    """

    step: int
    what: str
    expected: Any
    observed: Any

    def text(self) -> str:
        """Return it as a sentence.

        >>> Difference(7, "prey movement", "WAIT", "FORWARD").text()
        'step 7: prey movement: the simulator has WAIT, the colony FORWARD'
        """
        return (
            f"step {self.step}: {self.what}: the simulator has {self.expected}, "
            f"the colony {self.observed}"
        )


@dataclass(frozen=True, slots=True)
class Episode:
    """The simulator's side, up to the capture.

    Attributes:
        poses: shape (steps, 9).
        looks: shape (steps, 18).
        captured_at: step; None for no capture.
    """

    poses: NDArray[np.float64]
    looks: NDArray[np.int64]
    captured_at: int | None


@dataclass(frozen=True, slots=True)
class Hunt:
    """Both sides of one hunt."""

    episode: Episode
    steps: list[ColonyStep]
    difference: Difference | None

    @property
    def captured_at(self) -> int | None:
        """The step of the colony's capture."""
        return next((one.number for one in self.steps if one.captured), None)


def episode_of(
    genome: Genome, numbers: WorldNumbers, start: NDArray[np.float64], steps: int
) -> Episode:
    """Return the simulator's episode up to the capture."""
    words = words_of(genome.array()[None, :])[:, 0].copy()
    poses, looks = play_recorded(words, start, steps, numbers)
    caught = numbers.scoring.longest - poses[:, 8] > numbers.scoring.capture_score
    captured_at = int(np.argmax(caught)) + 1 if caught.any() else None
    end = captured_at or steps
    return Episode(poses[:end], looks[:end], captured_at)


def hunt(
    predator: Subject,
    prey: Subject,
    numbers: WorldNumbers,
    start: NDArray[np.float64],
    steps: int,
    genome: Genome | None = None,
    texts: dict[str, str] | None = None,
) -> Hunt:
    """Let both sides hunt, up to and including the capture, or to the first difference.

    Args:
        predator: its programs.
        prey: likewise.
        numbers: of the world.
        start: shape (1, 8).
        steps: at most.
        genome: what the simulator's predator has; the build's own where it is not given.
        texts: other benches than the robots' own.

    Raises:
        RigError: no genome, or robots without step line.
    """
    episode = episode_of(genome or predator.genome_for_hunt(), numbers, start, steps)
    colony = Colony(predator, prey, numbers, start, texts)
    for pose, look in zip(episode.poses, episode.looks, strict=True):
        step = colony.step()
        difference = _missing(colony, predator, prey, look.tolist())
        if difference is None and step is not None:
            difference = difference_of(step, pose.tolist(), look.tolist(), predator, prey)
        if difference is not None:
            return Hunt(episode, colony.steps, difference)
    return Hunt(episode, colony.steps, _captures(episode, colony))


def difference_of(
    step: ColonyStep, pose: list[float], look: list[int], predator: Subject, prey: Subject
) -> Difference | None:
    """Return in what a step differs; poses have to be equal bit by bit."""
    here, there = stimuli_of(look)
    sides = (
        ("predator", step.predator, predator, here.text(), look[7], look[8]),
        ("prey", step.prey, prey, there.text(), None, look[17]),
    )
    for word, act, subject, reading, state, command in sides:
        for what, expected, observed in _pairs(act, subject, reading, state, command):
            if expected != observed:
                return Difference(step.number, f"{word} {what}", expected, observed)
    if tuple(pose) != tuple(step.pair):
        return Difference(step.number, "poses", tuple(pose), tuple(step.pair))
    return None


def fixed_starts(
    predator: Subject, prey: Subject, numbers: WorldNumbers, gap_units: float, count: int
) -> NDArray[np.float64]:
    """Return the first of the starts that every run judges its best by, shape (count, 8)."""
    radii = predator.robot.body_radius_units, prey.robot.body_radius_units
    rng = stream(FIXED_STARTS_SEED, 0, 0, Purpose.FIXED_STARTS)
    return draw_starts(rng, count, numbers.side, radii, gap_units)


def _pairs(
    act: Act, subject: Subject, reading: str, state: int | None, command: int
) -> list[tuple[str, Any, Any]]:
    """Return what is expected and observed of one robot, in the order in which it comes about."""
    pairs: list[tuple[str, Any, Any]] = []
    if act.said is not None:
        pairs.append(("reading", reading, act.said.stimulus.text()))
        if state is not None:
            pairs.append(("state", state, act.said.state))
        pairs.append(("command", command, act.said.command))
    elif subject.robot.telemetry:
        pairs.append(("reading", reading, "nothing said"))
    made = act.trouble or (None if act.command is None else subject.movement(act.command))
    return [*pairs, ("movement", subject.movement(command), made)]


def _missing(
    colony: Colony, predator: Subject, prey: Subject, look: list[int]
) -> Difference | None:
    """Return the difference of a colony that is in trouble before its step is over."""
    if not colony.trouble or any(act.trouble for act in _last(colony)):
        return None
    movements = predator.movement(look[8]), prey.movement(look[17])
    return Difference(len(colony.steps) + 1, "step", " and ".join(movements), colony.trouble)


def _last(colony: Colony) -> list[Act]:
    return [act for one in colony.steps[-1:] for act in (one.predator, one.prey)]


def _captures(episode: Episode, colony: Colony) -> Difference | None:
    captured = colony.captured
    if captured == (episode.captured_at is not None):
        return None
    return Difference(len(colony.steps), "capture", episode.captured_at is not None, captured)
