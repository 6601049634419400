"""Walks -> displacement of one gait cycle, and what does not fit together about them.

A displacement is a rigid motion of the plane: along and to the right of the heading before, then
a turn. As a complex number it is `along - right * i`, and a turn is a multiplication.
"""

import cmath
import math
from collections.abc import Iterator
from typing import NamedTuple

from cgagen.calibrate.measurements import Walk
from cgagen.calibrate.samples import Sample, outliers, sample
from cgagen.errors import MeasurementError
from cgagen.words import Movement

GRAIN_IN, GRAIN_DEG = 0.1, 1.0
"""How well a tape measure and a protractor are read on a floor. Choice."""

APART_IN, APART_DEG = 0.25, 5.0
"""Differences of two movements that a robot with twelve hobby servos has anyway. Choice."""

APART_SHARE = 0.2
"""Likewise, as a share of the movement. Choice."""

SPREADS = 3.0
"""And in spreads of the repeats. Choice."""

LEAST_CLOSING = 0.05
"""Cycles whose turns add up to a full circle come back to where they began, however long they
are; so near to it nothing can be said of one cycle. Choice."""


class Displacement(NamedTuple):
    """One gait cycle, as the repeats have it; lengths in inches."""

    along_in: Sample
    right_in: Sample
    turn_deg: Sample


MIRRORS = (
    (Movement.RIGHT_FORWARD, Movement.LEFT_FORWARD),
    (Movement.ROTATE_RIGHT, Movement.ROTATE_LEFT),
    (Movement.BACKUP_RIGHT, Movement.BACKUP_LEFT),
    (Movement.FORWARD, Movement.FORWARD),
    (Movement.BACKWARD, Movement.BACKWARD),
)
"""Movements of which one is the other in a mirror; some are their own. Ref: S1 table I."""

INVERSES = (
    (Movement.RIGHT_FORWARD, Movement.BACKUP_RIGHT),
    (Movement.LEFT_FORWARD, Movement.BACKUP_LEFT),
    (Movement.ROTATE_RIGHT, Movement.ROTATE_LEFT),
)
"""Movements of which one walks the other backwards. Ref: S1 IV; DECISIONS.md 6."""

_Motion = tuple[complex, float]


def cycle_of(walk: Walk) -> tuple[float, float, float]:
    """Return along, right (inches) and turn (degrees) of one of the cycles of a walk.

    Every cycle is taken to be like the others, so they lie on an arc.

    Raises:
        MeasurementError: the cycles close a circle.

    >>> cycle_of(Walk("", 4, 12.0, -0.4, 0.0))
    (3.0, -0.1, 0.0)
    >>> [round(value, 9) for value in cycle_of(Walk("", 2, 1.0, -1.0, 180.0))]
    [1.0, 0.0, 90.0]
    """
    turn_deg = walk.turn_deg / walk.cycles
    turn = cmath.exp(1j * math.radians(turn_deg))
    closing = sum(turn**cycle for cycle in range(walk.cycles))
    if abs(closing) < LEAST_CLOSING * walk.cycles:
        raise MeasurementError(
            f"{walk.where}: {walk.cycles} cycles that turn by {walk.turn_deg:g} degrees end where "
            "they began, so nothing can be said of one; walk fewer cycles"
        )
    one = complex(walk.along_in, -walk.right_in) / closing
    return one.real, 0.0 - one.imag, turn_deg


def displacement_of(walks: list[Walk]) -> Displacement:
    """Return mean and spread of one movement's cycle over its repeats."""
    along, right, turn = zip(*(cycle_of(walk) for walk in walks), strict=True)
    return Displacement(sample(along), sample(right), sample(turn))


def odd_walks(movement: Movement, walks: list[Walk]) -> Iterator[str]:
    """Say which repeats are far from the others."""
    cycles = [cycle_of(walk) for walk in walks]
    rows = (("along", GRAIN_IN, "in"), ("right", GRAIN_IN, "in"), ("turn", GRAIN_DEG, "degrees"))
    for column, (name, grain, unit) in enumerate(rows):
        values = [cycle[column] for cycle in cycles]
        for index in outliers(values, grain):
            yield (
                f"{walks[index].where}: {movement} {name} of {values[index]:.3g} {unit} a cycle is "
                "far from its other repeats; measure it again"
            )


def odd_pairs(found: dict[Movement, Displacement]) -> Iterator[str]:
    """Say which movements do not fit their mirror image or their inverse."""
    for one, other in MIRRORS:
        if one in found and other in found:
            here, there = found[one], found[other]
            reason = _apart(here, there, _mirror(_motion(here)))
            if reason:
                said = "goes" if one is other else f"and {other} go"
                yield f"{one} {said} differently in a mirror: {reason}; look at trims and floor"
    for one, other in INVERSES:
        if one in found and other in found:
            reason = _apart(found[one], found[other], _inverse(_motion(found[one])))
            if reason:
                yield f"{other} does not undo {one}: {reason}; look at trims and floor"


def _motion(one: Displacement) -> _Motion:
    return complex(one.along_in.mean, -one.right_in.mean), one.turn_deg.mean


def _mirror(motion: _Motion) -> _Motion:
    return motion[0].conjugate(), -motion[1]


def _inverse(motion: _Motion) -> _Motion:
    """Return what leads back.

    >>> step, turn = _inverse((complex(2.9, -1.2), -37.0))
    >>> round(step.real, 2), round(-step.imag, 2), turn
    (-3.04, 0.79, 37.0)
    """
    return -motion[0] * cmath.exp(-1j * math.radians(motion[1])), -motion[1]


def _apart(one: Displacement, other: Displacement, wanted: _Motion) -> str:
    """Return in what a displacement differs from the wanted one; "" for not enough to matter."""
    step, turn_deg = wanted
    long_in = APART_SHARE * abs(step)
    rows = (
        ("along", "in", step.real, "along_in", APART_IN, long_in),
        ("right", "in", -step.imag, "right_in", APART_IN, long_in),
        ("turn", "degrees", turn_deg, "turn_deg", APART_DEG, APART_SHARE * abs(turn_deg)),
    )
    reasons = []
    for name, unit, expected, column, apart, share in rows:
        here, there = getattr(one, column), getattr(other, column)
        allowed = max(apart, share, SPREADS * math.hypot(here.spread or 0.0, there.spread or 0.0))
        if abs(there.mean - expected) > allowed:
            reasons.append(f"{name} {there.mean:.3g} {unit}, not about {expected:.3g}")
    return ", ".join(reasons)
