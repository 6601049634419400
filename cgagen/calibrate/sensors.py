"""Counts at marked distances -> speed of sound, and the curve of the lamp."""

import itertools
import math
from collections.abc import Iterator
from typing import NamedTuple

from cgagen.calibrate.measurements import LIGHT_PREFIX, Mark
from cgagen.calibrate.samples import Sample, sample
from cgagen.counts import CURVE_SEGMENTS, NO_ECHO_COUNT, UNLIT_COUNT
from cgagen.errors import MeasurementError
from cgagen.robot import Robot

OFFSET_IN = 0.5
"""A sonar whose counts fit distances so much longer or shorter was measured from elsewhere than
its face. Choice."""

SONARS_APART = 0.03
"""Share by which one sonar's counts may differ from the others'. Choice."""

LIGHTS_APART = 0.15
"""Share by which the light sensors may differ from each other. Choice."""


class Curve(NamedTuple):
    """One light sensor's curve, as measured.

    Attributes:
        points: distance in inches and RCTIME count, nearest first.
        readings: how many there were.
        widest_spread: the largest standard deviation of repeats, in counts.
    """

    points: tuple[tuple[float, int], ...]
    readings: int
    widest_spread: float


def us_per_in_of(robot: Robot, marks: list[Mark]) -> Sample:
    """Return the time that sound takes for an inch, from usable marks of all sonars.

    The mean is that of the line through the origin that fits the counts best.
    """
    unit_us = robot.main.pulsin_unit_ns / 1_000
    single = [mark.counts * unit_us / 2 / mark.distance_in for mark in marks]
    weight = math.fsum(mark.distance_in**2 for mark in marks)
    product = math.fsum(mark.distance_in * mark.counts for mark in marks)
    return sample(single)._replace(mean=product / weight * unit_us / 2)


def usable_marks(robot: Robot, name: str, marks: list[Mark]) -> tuple[list[Mark], list[str]]:
    """Return the marks of one sonar that say something of sound, and why the others do not."""
    sonar = next(one for one in robot.sonars if one.name == name)
    shortest, longest = robot.echo_limits_counts(sonar)
    kept, reasons = [], []
    for mark in marks:
        if mark.counts == NO_ECHO_COUNT:
            reasons.append(f"{mark.where}: {name} gave no echo; left out, look at its wires")
        elif not math.ceil(shortest) < mark.counts < math.floor(longest) or not mark.distance_in:
            reasons.append(
                f"{mark.where}: {name} was at the end of its range ({mark.counts}); left out"
            )
        else:
            kept.append(mark)
    return kept, reasons


def odd_sonars(robot: Robot, marks: dict[str, list[Mark]], mean: float) -> Iterator[str]:
    """Say which sonars do not fit the others, or their marks."""
    unit_us = robot.main.pulsin_unit_ns / 1_000
    for name, one in marks.items():
        offset_in = _offset_in(one, unit_us)
        own = us_per_in_of(robot, one).mean if one else mean
        if offset_in is not None and abs(offset_in) > OFFSET_IN:
            longer = "longer" if offset_in > 0 else "shorter"
            yield (
                f"{name}: its counts fit distances {abs(offset_in):.1f} in {longer} than marked; "
                "measure from the face of the sonar"
            )
        elif abs(own / mean - 1) > SONARS_APART:
            yield (
                f"{name}: {own:.1f} us per inch where all together have {mean:.1f}; "
                "measure it again"
            )


def _offset_in(marks: list[Mark], unit_us: float) -> float | None:
    """Return by how much a straight line through the marks misses the origin, in inches."""
    middle = math.fsum(mark.distance_in for mark in marks) / max(len(marks), 1)
    width = math.fsum((mark.distance_in - middle) ** 2 for mark in marks)
    if len({mark.distance_in for mark in marks}) < 3:
        return None
    slope = math.fsum((mark.distance_in - middle) * mark.counts for mark in marks) / width
    mean = math.fsum(mark.counts for mark in marks) / len(marks)
    return mean / slope - middle if slope > 0 else None


def curve_of(name: str, marks: list[Mark]) -> Curve:
    """Return the curve of a light sensor.

    Raises:
        MeasurementError: a dark reading, too few or too many distances, or counts that do not rise.
    """
    by_distance: dict[float, list[int]] = {}
    for mark in marks:
        if mark.counts == UNLIT_COUNT:
            raise MeasurementError(
                f"{mark.where}: {LIGHT_PREFIX}{name} was dark (count 0), so its distance is "
                "none of the curve; leave that line out, and note it as the range"
            )
        by_distance.setdefault(mark.distance_in, []).append(mark.counts)
    samples = {distance: sample(counts) for distance, counts in sorted(by_distance.items())}
    if not 2 <= len(samples) <= CURVE_SEGMENTS + 1:
        raise MeasurementError(
            f"{LIGHT_PREFIX}{name}: {len(samples)} distances of the lamp, and its curve takes 2 to "
            f"{CURVE_SEGMENTS + 1}; measure it at more, or leave some out"
        )
    points = tuple((distance, round(one.mean)) for distance, one in samples.items())
    for (near, less), (far, more) in itertools.pairwise(points):
        if not less < more:
            raise MeasurementError(
                f"{LIGHT_PREFIX}{name}: the lamp at {far:g} in counts {more}, no more than {less} "
                f"at {near:g} in; measure both again"
            )
    readings = sum(one.repeats for one in samples.values())
    return Curve(points, readings, max(one.spread or 0.0 for one in samples.values()))


def odd_lights(lights: dict[str, list[Mark]]) -> Iterator[str]:
    """Say at which distances the two sensors differ."""
    if len(lights) < 2:
        yield "one light sensor only was measured; the other keeps its curve"
        return
    one, other = (_means(marks) for marks in lights.values())
    names = [LIGHT_PREFIX + name for name in lights]
    for distance in sorted(one.keys() & other.keys()):
        low, high = sorted((one[distance], other[distance]))
        if high > low * (1 + LIGHTS_APART):
            yield (
                f"{names[0]} counts {one[distance]:.0f} and {names[1]} {other[distance]:.0f} with "
                f"the lamp at {distance:g} in; each has its own curve, but look at tubes and parts"
            )


def _means(marks: list[Mark]) -> dict[float, float]:
    by_distance: dict[float, list[float]] = {}
    for mark in marks:
        by_distance.setdefault(mark.distance_in, []).append(mark.counts)
    return {distance: sample(counts).mean for distance, counts in by_distance.items()}
