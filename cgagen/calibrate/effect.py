"""What other numbers in a robot file do to a genome that was evolved with the old ones."""

import os
from typing import NamedTuple

import numpy as np

from cgagen.genome import Genome
from cgagen.robot import Arena, Robot
from cgagen.run.streams import Purpose, stream
from cgagen.words import Role
from sim.model import World

STARTS = 100
"""The fixed starts of every run. Ref: DECISIONS.md 18."""


class Effect(NamedTuple):
    """How a genome does: mean step score in arena units, and share of starts with a capture."""

    fitness: float
    captured: float


def effect_of(genome: Genome, robot: Robot, opponent: Robot, arena: Arena) -> Effect:
    """Let a genome hunt from the fixed starts.

    Args:
        genome: the predator's.
        robot: the one of the two that was measured.
        opponent: the other one.
        arena: where.
    """
    predator, prey = (robot, opponent) if robot.role is Role.PREDATOR else (opponent, robot)
    world = World(predator, prey, arena, threads=os.cpu_count() or 1)
    try:
        starts = world.draw_starts(stream(0, 0, 0, Purpose.FIXED_STARTS), STARTS)
        scores = world.evaluate(np.asarray(genome.array(), np.uint8)[None, :], starts)
    finally:
        world.close()
    return Effect(float(scores.fitness[0]), float(scores.captured[0]))
