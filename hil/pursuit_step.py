"""The simulator's own step in two halves: what both robots sense, and where a movement leads.

The same functions as `sim.world.step` calls, on the same numbers: equal means bit for bit.
"""

import math

import numpy as np
from numpy.typing import NDArray

from hil.target import Stimulus
from sim.episode import LOOK_COLUMNS, row_of
from sim.jit import kernel
from sim.model import with_distance
from sim.numbers import WorldNumbers
from sim.world import Pair, Words, bits_of, look, move


@kernel
def _sense(pair: Pair, numbers: WorldNumbers, row: NDArray[np.int64]) -> None:
    for column, value in enumerate(row_of(look(pair, Words(0, 0, 0), numbers))):
        row[column] = value


@kernel
def _walk(pair: Pair, command: int, answer: int, numbers: WorldNumbers) -> Pair:
    predator, prey, side, stop = (
        numbers.predator,
        numbers.prey,
        numbers.side,
        numbers.stop_at_walls,
    )
    px, py, pc, ps = pair.px, pair.py, pair.pc, pair.ps
    qx, qy, qc, qs = pair.qx, pair.qy, pair.qc, pair.qs
    if command >= 0:
        px, py, pc, ps = move(
            px, py, pc, ps, bits_of(command), predator.steps, predator.radius, side, stop
        )
    if answer >= 0:
        qx, qy, qc, qs = move(qx, qy, qc, qs, bits_of(answer), prey.steps, prey.radius, side, stop)
    dx, dy = qx - px, qy - py
    return Pair(px, py, pc, ps, qx, qy, qc, qs, math.sqrt(dx * dx + dy * dy))


def pair_of(start: NDArray[np.float64]) -> Pair:
    """Return a start, shape (1, 8), as the step takes it."""
    return Pair(*with_distance(start)[:, 0].tolist())


def sensed(pair: Pair, numbers: WorldNumbers) -> tuple[Stimulus, Stimulus]:
    """Return what the chips of predator and prey measure at these poses."""
    row = np.empty(LOOK_COLUMNS, np.int64)
    _sense(pair, numbers, row)
    return stimuli_of(row.tolist())


def stimuli_of(row: list[int]) -> tuple[Stimulus, Stimulus]:
    """Return both readings in a row of `sim.episode.play_recorded`'s looks."""
    return (
        Stimulus((row[0], row[1], row[2]), (bool(row[3]), bool(row[4])), (row[5], row[6])),
        Stimulus(tuple(row[9:15]), (bool(row[15]), bool(row[16]))),
    )


def walked(pair: Pair, predator: int | None, prey: int | None, numbers: WorldNumbers) -> Pair:
    """Return the poses after movements by their commands; None for a robot that stood still."""
    command, answer = (-1 if one is None else one for one in (predator, prey))
    return Pair(*_walk(pair, command, answer, numbers))
