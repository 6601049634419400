"""From distance to the integer that the chip measures: the one place where that happens.

Thresholds of a robot file and the geometry of the simulator go through the same two functions,
so a threshold in inches and a reading at that distance are the same count. They use only
comparisons, `+ - *` and `floor`, which are exact in the same way on every CPU, and they are
written so that Numba can compile them. The scale is an argument: inches for thresholds, arena
units for the simulator.
"""

import itertools
import math
from typing import NamedTuple

NO_ECHO_COUNT = 0
"""What PULSIN leaves when no pulse came. Ref: S2 p. 343."""

FARTHEST_COUNT = 65_535
"""Stands for "no echo" in comparisons: farther than everything. Choice (DECISIONS.md 8)."""

UNLIT_COUNT = 0
"""What RCTIME leaves when its time overflowed: dark. Ref: S2 p. 363."""

CURVE_SEGMENTS = 8
"""Straight pieces of a light curve at most. Choice."""

GUARD_COUNTS = 1e-9
"""Added before a light count is rounded down, so that a marked distance gives its own count."""


class LightCurve(NamedTuple):
    """Counts over distance as straight pieces; unused pieces rise by nothing.

    Attributes:
        first: count at and below the first distance.
        start: where each piece begins, in the scale's distance.
        per_distance: 1 / length of each piece.
        rise: counts that each piece adds.
    """

    first: float
    start: tuple[float, float, float, float, float, float, float, float]
    per_distance: tuple[float, float, float, float, float, float, float, float]
    rise: tuple[float, float, float, float, float, float, float, float]


def echo_count(distance: float, counts_per_distance: float, fewest: float, most: float) -> int:
    """Return the PULSIN count of an echo.

    Args:
        distance: from the sonar to what it sees.
        counts_per_distance: there and back, in counts of the chip's PULSIN unit.
        fewest: count, not rounded, of the shortest echo that the sonar gives.
        most: count, not rounded, of the longest; a sonar that sees nothing gives it, too.

    >>> echo_count(10.0, 2 * 73.746 / 0.8, 115 / 0.8, 18_500 / 0.8)
    1843
    """
    count = distance * counts_per_distance
    count = count if count > fewest else fewest
    count = count if count < most else most
    return math.floor(count)


def light_count(distance: float, curve: LightCurve) -> int:
    """Return the RCTIME count of a lit photoresistor at a distance from the lamp.

    >>> curve = light_curve([(2.0, 14), (12.0, 170)], 1.0)
    >>> [light_count(d, curve) for d in (0.0, 2.0, 7.0, 12.0, 50.0)]
    [14, 14, 92, 170, 170]
    """
    start, scale, rise = curve.start, curve.per_distance, curve.rise
    count = curve.first
    count += risen(distance, start[0], scale[0], rise[0])
    count += risen(distance, start[1], scale[1], rise[1])
    count += risen(distance, start[2], scale[2], rise[2])
    count += risen(distance, start[3], scale[3], rise[3])
    count += risen(distance, start[4], scale[4], rise[4])
    count += risen(distance, start[5], scale[5], rise[5])
    count += risen(distance, start[6], scale[6], rise[6])
    count += risen(distance, start[7], scale[7], rise[7])
    return math.floor(count + GUARD_COUNTS)


def risen(distance: float, start: float, per_distance: float, rise: float) -> float:
    """Return what one piece of a light curve has added by `distance`."""
    part = (distance - start) * per_distance
    part = part if part > 0.0 else 0.0
    part = part if part < 1.0 else 1.0
    return part * rise


def light_curve(points: list[tuple[float, int]], distance_scale: float) -> LightCurve:
    """Return the curve through points (inches, count), with distances in another unit.

    Args:
        points: 2 to 9 of them, both columns rising.
        distance_scale: that unit per inch; 1.0 for inches.
    """
    starts, scales, rises = [], [], []
    for (near, less), (far, more) in itertools.pairwise(points):
        starts.append(near * distance_scale)
        scales.append(1.0 / ((far - near) * distance_scale))
        rises.append(float(more - less))
    spare = [0.0] * (CURVE_SEGMENTS - len(starts))
    return LightCurve(
        float(points[0][1]),
        tuple(starts + spare),  # type: ignore[arg-type]
        tuple(scales + spare),  # type: ignore[arg-type]
        tuple(rises + spare),  # type: ignore[arg-type]
    )
