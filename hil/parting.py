"""Without a referee: each robot walks in its own time, and both part from the simulator's episode.

The simulator lets both robots step at once. Robots do not: a turn takes longer than a step
ahead, and a decision takes as long as its echoes. So the prey of a real hunt has moved a little
less, or a little more, when the predator looks. On three lines, without a step line, a robot also
looks while its legs move, and what its lines say when a gait cycle ends is the next movement:
decided from where it stood before. How much that matters is measured here.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cgagen.genome import Genome
from hil.colony import Colony
from hil.hunt import episode_of
from hil.subject import Subject
from sim.numbers import WorldNumbers


@dataclass(frozen=True, slots=True)
class Parting:
    """How far a hunt without referee is from the simulator's.

    Attributes:
        simulated_at: the simulator's step of capture; None for none.
        captured_at: how many movements the predator had made at the capture; None for none.
        predator_steps: how many it had made at the end.
        prey_steps: how many the prey had made at the end.
        decided_alike: the predator's decisions before the first that is another one.
        farthest_units: between the predators after the same number of movements, at most.
        trouble: what went wrong; empty where nothing did.
    """

    simulated_at: int | None
    captured_at: int | None
    predator_steps: int
    prey_steps: int
    decided_alike: int
    farthest_units: float
    trouble: str


def part(
    predator: Subject,
    prey: Subject,
    numbers: WorldNumbers,
    start: NDArray[np.float64],
    steps: int,
    genome: Genome | None = None,
) -> Parting:
    """Let both robots hunt in their own time, up to a capture or so many movements of the predator.

    Args:
        predator: its programs.
        prey: likewise.
        numbers: of the world.
        start: shape (1, 8).
        steps: at most.
        genome: what the simulator's predator has; the build's own where it is not given.

    Raises:
        RigError: the predator's build has no genome.
    """
    episode = episode_of(genome or predator.genome_for_hunt(), numbers, start, steps)
    colony = Colony(predator, prey, numbers, start, referee=False)
    made: list[int] = []
    apart_units, seen = [0.0], 0
    while len(made) < steps and not colony.captured and colony.step() is not None:
        for last in colony.steps[seen:]:
            seen += 1
            if last.predator.command is None or len(made) == steps:
                continue
            made.append(last.predator.command)
            if len(made) <= len(episode.poses):
                x, y = episode.poses[len(made) - 1, :2].tolist()
                apart_units.append(math.hypot(last.pair.px - x, last.pair.py - y))
        if colony.trouble:
            break
    wanted = episode.looks[:, 8].tolist()
    alike = next((n for n, (a, b) in enumerate(zip(made, wanted, strict=False)) if a != b), None)
    return Parting(
        simulated_at=episode.captured_at,
        captured_at=len(made) if colony.captured else None,
        predator_steps=len(made),
        prey_steps=sum(one.prey.command is not None for one in colony.steps),
        decided_alike=min(len(made), len(wanted)) if alike is None else alike,
        farthest_units=max(apart_units),
        trouble=colony.trouble,
    )
