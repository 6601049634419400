"""One episode with everything that was sensed and decided, step by step."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cgagen.words import COMMANDS, Movement, Role, Situation, situations_of
from sim.batch import bonus
from sim.entry import checked_starts, checked_steps, checked_words
from sim.jit import device, kernel
from sim.model import with_distance
from sim.numbers import WorldNumbers
from sim.world import Look, Pair, PreyReading, Reading, Words, captured, look, score_of, step

LOOK_COLUMNS = 18
"""Reading (7), state, command, prey reading (8), the prey's answer."""


@dataclass(frozen=True, slots=True)
class Step:
    """One gait cycle of both robots.

    Attributes:
        number: from 1.
        reading: what the predator's chip measured, before the move.
        obstacle: its situation,
        target: likewise.
        state: index of the gene.
        command: the gene, 0 to 7.
        movement: its name.
        prey_reading: what the prey's chip measured.
        prey_command: what it decided.
        prey_movement: its name.
        predator: pose after the move: x_units, y_units, heading_deg (0 to 360).
        prey: likewise.
        distance_units: between the centres, after the move.
        score: of this step, with the bonus for speed.
        captured: whether the prey is caught after this step.
    """

    number: int
    reading: Reading
    obstacle: Situation
    target: Situation
    state: int
    command: int
    movement: Movement
    prey_reading: PreyReading
    prey_command: int
    prey_movement: Movement
    predator: tuple[float, float, float]
    prey: tuple[float, float, float]
    distance_units: float
    score: float
    captured: bool


@device
def row_of(seen: Look) -> tuple[int, ...]:
    """Return a look as `LOOK_COLUMNS` integers."""
    reading, prey, bits = seen.reading, seen.prey_reading, seen.command
    return (
        reading.front, reading.right, reading.left, int(reading.touch_left),
        int(reading.touch_right), reading.light_left, reading.light_right, seen.state,
        int(bits.bit_0) + 2 * int(bits.bit_1) + 4 * int(bits.bit_2),
        prey.front_left, prey.front_right, prey.left, prey.right, prey.rear_left,
        prey.rear_right, int(prey.touch_left), int(prey.touch_right), seen.answer,
    )  # fmt: skip


@kernel
def record(
    genome: NDArray[np.int64],
    start: NDArray[np.float64],
    numbers: WorldNumbers,
    poses: NDArray[np.float64],
    looks: NDArray[np.int64],
) -> None:
    """Play one episode and keep all of it.

    Args:
        genome: its three words.
        start: both poses and the distance, shape (9,).
        numbers: of this world.
        poses: filled with the same nine numbers after each step, shape (steps, 9).
        looks: filled with what was sensed and decided before it, shape (steps, LOOK_COLUMNS).
    """
    words = Words(genome[0], genome[1], genome[2])
    pair = Pair(
        start[0], start[1], start[2], start[3], start[4], start[5], start[6], start[7], start[8]
    )
    for n in range(poses.shape[0]):
        for column, value in enumerate(row_of(look(pair, words, numbers))):
            looks[n, column] = value
        pair = step(pair, words, numbers)
        for column, number in enumerate(pair):
            poses[n, column] = number


def play_recorded(
    genome: NDArray[np.int64], start: NDArray[np.float64], steps: int, numbers: WorldNumbers
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return the poses (steps, 9) and the looks (steps, 18) of one episode; see `record`.

    Args:
        genome: its three words, shape (3,).
        start: shape (1, 8).
        steps: how many to play.
        numbers: of the world.

    Raises:
        ValueError: another shape, or numbers that cannot be.
    """
    genome, start = checked_words(genome), checked_starts(start)
    if genome.ndim != 1 or len(start) != 1:
        raise ValueError(f"one genome and one start play, not {genome.shape} and {start.shape}")
    poses = np.empty((checked_steps(steps), 9))
    looks = np.empty((steps, LOOK_COLUMNS), np.int64)
    record(genome, with_distance(start)[:, 0].copy(), numbers, poses, looks)
    return poses, looks


def play_episode(
    genome: NDArray[np.int64], start: NDArray[np.float64], steps: int, numbers: WorldNumbers
) -> list[Step]:
    """Return one episode step by step; arguments as of `play_recorded`."""
    poses, looks = play_recorded(genome, start, steps, numbers)
    return [
        _step_of(number, pose.tolist(), row.tolist(), numbers)
        for number, (pose, row) in enumerate(zip(poses, looks, strict=True), start=1)
    ]


def _step_of(number: int, pose: list[float], row: list[int], numbers: WorldNumbers) -> Step:
    reading = Reading(row[0], row[1], row[2], bool(row[3]), bool(row[4]), row[5], row[6])
    prey_reading = PreyReading(
        row[9], row[10], row[11], row[12], row[13], row[14], bool(row[15]), bool(row[16])
    )
    obstacle, target = situations_of(row[7])
    distance = pose[8]
    return Step(
        number=number,
        reading=reading,
        obstacle=obstacle,
        target=target,
        state=row[7],
        command=row[8],
        movement=COMMANDS[Role.PREDATOR][row[8]],
        prey_reading=prey_reading,
        prey_command=row[17],
        prey_movement=COMMANDS[Role.PREY][row[17]],
        predator=(pose[0], pose[1], heading_deg(pose[2], pose[3])),
        prey=(pose[4], pose[5], heading_deg(pose[6], pose[7])),
        distance_units=distance,
        score=score_of(distance, numbers.scoring) * bonus(float(number)),
        captured=bool(captured(distance, numbers.scoring)),
    )


def heading_deg(c: float, s: float) -> float:
    """Return the heading of a unit vector, 0 to 360 degrees, to a millionth.

    >>> heading_deg(0.0, -1.0)
    270.0
    """
    return round(math.degrees(math.atan2(s, c)) % 360.0, 6) % 360.0


def visits_of(
    genome: NDArray[np.int64], starts: NDArray[np.float64], steps: int, numbers: WorldNumbers
) -> NDArray[np.int64]:
    """Count how often each state is met from some starts, up to the capture; shape (64,).

    After a capture that holds both robots the state says nothing any more, so it is not counted.
    """
    visits = np.zeros(64, np.int64)
    for start in starts:
        poses, looks = play_recorded(genome, start[None, :], steps, numbers)
        caught = numbers.scoring.longest - poses[:, 8] > numbers.scoring.capture_score
        end = int(np.argmax(caught)) + 1 if caught.any() and numbers.hold else steps
        visits += np.bincount(looks[:end, 7], minlength=64)
    return visits
