"""Where episodes begin: poses of both robots, drawn or given."""

import math

import numpy as np
from numpy.typing import NDArray

from cgagen.errors import RobotError
from sim.trig import cos_sin_deg

START_COLUMNS = 8
"""px, py, pc, ps, qx, qy, qc, qs: positions in arena units, headings as unit vectors."""


def draw_starts(
    rng: np.random.Generator,
    count: int,
    side_units: float,
    radii_units: tuple[float, float],
    gap_units: float,
) -> NDArray[np.float64]:
    """Draw random starts, predator and prey at least a gap apart.

    Positions are uniform over the arena less the body's radius at each wall, headings uniform
    and real-valued: whole degrees would put walls exactly on the edges of cones, where the last
    bit of a number decides (DECISIONS.md 3).

    Returns:
        Shape (count, 8).

    Ref: S1 III.A for random starts; ranges and gap are a choice.
    """
    starts = np.empty((count, START_COLUMNS))
    for row in range(count):
        while True:
            draws = rng.random(6).tolist()
            predator = _pose(draws[:3], side_units, radii_units[0])
            prey = _pose(draws[3:], side_units, radii_units[1])
            dx, dy = prey[0] - predator[0], prey[1] - predator[1]
            if math.sqrt(dx * dx + dy * dy) >= gap_units:
                break
        starts[row] = (*predator, *prey)
    return starts


def _pose(draws: list[float], side: float, radius: float) -> tuple[float, float, float, float]:
    room = side - 2.0 * radius
    return (radius + room * draws[0], radius + room * draws[1], *cos_sin_deg(360.0 * draws[2]))


def start_of(
    predator: tuple[float, float, float],
    prey: tuple[float, float, float],
    side_units: float,
    radii_units: tuple[float, float],
) -> NDArray[np.float64]:
    """Return one start from two poses (x_units, y_units, heading_deg), shape (1, 8).

    Raises:
        RobotError: a pose is within a wall or has no direction, or both stand on one point.
    """
    columns: list[float] = []
    for name, (x, y, heading_deg), radius in zip(
        ("predator", "prey"), (predator, prey), radii_units, strict=True
    ):
        if not all(radius <= value <= side_units - radius for value in (x, y)):
            raise RobotError(
                f"{name}: ({x:g}, {y:g}) is not inside the arena; "
                f"both coordinates from {radius:g} to {side_units - radius:g} units are allowed"
            )
        if not math.isfinite(heading_deg):
            raise RobotError(f"{name}: a heading of {heading_deg} points nowhere; give degrees")
        columns += [x, y, *cos_sin_deg(heading_deg)]
    if predator[:2] == prey[:2]:
        raise RobotError("predator and prey: both stand on one point; move one of them")
    return np.array([columns])
