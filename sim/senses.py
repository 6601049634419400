"""What a robot senses, in the counts of its chip.

A robot is (x, y, c, s): position in arena units, heading as a unit vector. `Seen` is what all
of its sensors need to know of one instant. There is no trigonometry and no branch in here that
could stop LLVM from running the step in lanes.

Ref: S1 II.A and II.B for the sensors; the geometry is a choice (DECISIONS.md 4): a sonar reads
the nearest point of any wall within its cone, or the surface of the other robot if that one's
centre is within the cone; an antenna is bent by a wall across it, or by the other robot's body.
"""

from typing import NamedTuple

from cgagen import counts
from sim.jit import device
from sim.numbers import AntennaNumbers, Cone, SonarNumbers

echo_count = device(counts.echo_count)
light_count = device(counts.light_count)

NOTHING_UNITS = 1.0e9
"""Farther than any range: the distance to nothing."""


class Seen(NamedTuple):
    """One robot's view of walls and of the other robot.

    Attributes:
        x, y, c, s: the robot.
        east, west, north, south: 1 / distance to each wall.
        ahead, left: the direction to the other robot's centre, a unit vector in this robot's
            frame.
        distance: to that centre.
        surface: to that robot's body.
        side: of the arena.
    """

    x: float
    y: float
    c: float
    s: float
    east: float
    west: float
    north: float
    south: float
    ahead: float
    left: float
    distance: float
    surface: float
    side: float


@device
def see(
    x: float,
    y: float,
    c: float,
    s: float,
    other_x: float,
    other_y: float,
    distance: float,
    per_distance: float,
    other_radius: float,
    side: float,
) -> Seen:
    """Gather what the sensors of one robot have in common."""
    dx = (other_x - x) * per_distance
    dy = (other_y - y) * per_distance
    to_east = side - x
    to_north = side - y
    across = 1.0 / (to_east * x)
    along = 1.0 / (to_north * y)
    return Seen(
        x,
        y,
        c,
        s,
        across * x,
        across * to_east,
        along * y,
        along * to_north,
        dx * c + dy * s,
        dy * c - dx * s,
        distance,
        distance - other_radius,
        side,
    )


@device
def faces(seen: Seen, cone: Cone) -> bool:
    """Say whether the other robot's centre is within a cone."""
    return seen.ahead * cone.axis_x + seen.left * cone.axis_y >= cone.cos_half


@device
def wall_nearness(seen: Seen, cone: Cone, sin_half: float) -> float:
    """Return 1 / distance to the nearest point of a wall within a cone.

    A wall's normal is within the cone, and then its foot is the nearest point; or it is not, and
    then the nearer edge of the cone hits first. In both cases nearness is the wall's own 1 /
    distance times the largest cosine between its normal and a direction of the cone.
    """
    ux = seen.c * cone.axis_x - seen.s * cone.axis_y
    uy = seen.s * cone.axis_x + seen.c * cone.axis_y
    across_x = abs(uy) * sin_half
    across_y = abs(ux) * sin_half
    along_x = ux * cone.cos_half
    along_y = uy * cone.cos_half
    east = 1.0 if ux >= cone.cos_half else across_x + along_x
    west = 1.0 if ux <= -cone.cos_half else across_x - along_x
    north = 1.0 if uy >= cone.cos_half else across_y + along_y
    south = 1.0 if uy <= -cone.cos_half else across_y - along_y
    east = east * seen.east
    west = west * seen.west
    north = north * seen.north
    south = south * seen.south
    x = east if east > west else west
    y = north if north > south else south
    return x if x > y else y


@device
def sonar(seen: Seen, numbers: SonarNumbers, counts_per_unit: float) -> int:
    """Return the echo count of one sonar."""
    distance = 1.0 / wall_nearness(seen, numbers.cone, numbers.sin_half)
    nearer = min(seen.surface, distance)
    distance = nearer if faces(seen, numbers.cone) else distance
    distance = distance if distance <= numbers.range_units else NOTHING_UNITS
    return echo_count(distance, counts_per_unit, numbers.fewest, numbers.most)


@device
def touch(seen: Seen, numbers: AntennaNumbers) -> bool:
    """Say whether an antenna is bent."""
    x = seen.x + (seen.c * numbers.tip_x - seen.s * numbers.tip_y)
    y = seen.y + (seen.s * numbers.tip_x + seen.c * numbers.tip_y)
    wall = (x >= seen.side) | (x <= 0.0) | (y >= seen.side) | (y <= 0.0)
    robot = faces(seen, numbers.robot) & (seen.distance <= numbers.length_units)
    return wall | robot


@device
def light(seen: Seen, cone: Cone, lamp_count: int) -> int:
    """Return the RC count of one light sensor: the lamp's, or 0 where the tube keeps it dark."""
    return lamp_count if faces(seen, cone) else 0
