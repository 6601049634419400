"""From distance to the integer that the chip measures: the one place where that happens.

Thresholds of a robot file and the geometry of the simulator go through the same two functions,
so a threshold in inches and a reading at that distance are the same count. They use only
comparisons, `+ - *` and rounding down, which are exact in the same way on every CPU, and they are
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
    """Counts over distance as up to eight straight pieces; unused ones begin beyond the last.

    Attributes:
        nearest: the curve is flat below this distance, in the scale's unit,
        farthest: and beyond this one.
        start: where each piece but the first begins.
        at_zero: what each piece would count at distance 0.
        slope: counts per distance of each piece.
    """

    nearest: float
    farthest: float
    start: tuple[float, float, float, float, float, float, float]
    at_zero: tuple[float, float, float, float, float, float, float, float]
    slope: tuple[float, float, float, float, float, float, float, float]


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
    return int(min(max(distance * counts_per_distance, fewest), most))


def light_count(distance: float, curve: LightCurve) -> int:
    """Return the RCTIME count of a lit photoresistor at a distance from the lamp.

    >>> curve = light_curve([(2.0, 14), (12.0, 170)], 1.0)
    >>> [light_count(d, curve) for d in (0.0, 2.0, 7.0, 12.0, 50.0)]
    [14, 14, 92, 170, 170]
    """
    distance = min(max(distance, curve.nearest), curve.farthest)
    count, slope = curve.at_zero[0], curve.slope[0]
    count, slope = (
        (curve.at_zero[1], curve.slope[1]) if distance >= curve.start[0] else (count, slope)
    )
    count, slope = (
        (curve.at_zero[2], curve.slope[2]) if distance >= curve.start[1] else (count, slope)
    )
    count, slope = (
        (curve.at_zero[3], curve.slope[3]) if distance >= curve.start[2] else (count, slope)
    )
    count, slope = (
        (curve.at_zero[4], curve.slope[4]) if distance >= curve.start[3] else (count, slope)
    )
    count, slope = (
        (curve.at_zero[5], curve.slope[5]) if distance >= curve.start[4] else (count, slope)
    )
    count, slope = (
        (curve.at_zero[6], curve.slope[6]) if distance >= curve.start[5] else (count, slope)
    )
    count, slope = (
        (curve.at_zero[7], curve.slope[7]) if distance >= curve.start[6] else (count, slope)
    )
    return int(count + slope * distance + GUARD_COUNTS)


def light_curve(points: list[tuple[float, int]], distance_scale: float) -> LightCurve:
    """Return the curve through points (inches, count), with distances in another unit.

    Args:
        points: 2 to 9 of them, both columns rising.
        distance_scale: that unit per inch; 1.0 for inches.
    """
    counts, slopes = [], []
    for (near_in, less), (far_in, more) in itertools.pairwise(points):
        slope = (more - less) / (far_in - near_in)
        counts.append(less - slope * near_in)
        slopes.append(slope / distance_scale)
    starts = [inches * distance_scale for inches, _ in points[1:-1]]
    spare = CURVE_SEGMENTS - len(counts)
    return LightCurve(
        points[0][0] * distance_scale,
        points[-1][0] * distance_scale,
        tuple(starts + [math.inf] * spare),  # type: ignore[arg-type]
        tuple(counts + [0.0] * spare),  # type: ignore[arg-type]
        tuple(slopes + [0.0] * spare),  # type: ignore[arg-type]
    )
