"""Readings that are too near to a threshold for a rig whose timers are not exact.

What such a rig presents is some counts longer or shorter than it was told. A reading is clear of
doubt where no comparison that may decide comes out otherwise within that.
"""

import itertools

from cgagen.robot import Robot
from hil.emulated import MOST_SONAR_COUNTS
from hil.stimuli import light_limits, neutral, sonar_limits, with_values
from hil.target import Stimulus


def is_clear(robot: Robot, stimulus: Stimulus, guard_counts: int) -> bool:
    """Say whether a rig that is off by so many counts at most presents what decides alike.

    Args:
        robot: its thresholds.
        stimulus: what is wanted. Counts of 0, no echo and dark, are always exact.
        guard_counts: 0 for a rig that is exact.
    """
    lights = light_limits(robot)
    rows = list(zip(stimulus.sonars, sonar_limits(robot), strict=True))
    lit = list(zip(stimulus.lights, lights, strict=True))
    if any(count > MOST_SONAR_COUNTS - guard_counts for count, _ in (*rows, *lit)):
        return False
    if guard_counts == 0:
        return True
    if any(0 < count <= guard_counts for count in stimulus.sonars):
        return False  # so short an echo may be none, which is the farthest of all
    far_too = robot.limits is None and all(stimulus.touched)  # a prey then asks which is opener
    return all(_alone(row, guard_counts) for row in (*rows, *lit)) and all(
        _apart(one, other, guard_counts, far_too)
        for group in (rows, lit)
        for one, other in itertools.combinations(group, 2)
    )


def beside(robot: Robot, guard_counts: int) -> list[Stimulus]:
    """Return the readings nearest to each threshold that are clear of doubt, the rest neutral.

    A light's come with the other light dark, and with it lit from afar: that is how all of its
    thresholds decide something.
    """
    plain, lights = neutral(robot), light_limits(robot)
    first = len(plain.sonars)
    backgrounds = {index: [plain] for index in range(first)}
    for index in range(first, first + len(plain.lights)):
        other = 2 * first + 1 - index
        far = lights[other - first][-1] - guard_counts - 1
        backgrounds[index] = [plain, *([with_values(plain, {other: far})] if far > 0 else [])]
    limits = [*sonar_limits(robot), *lights]
    found = [
        with_values(background, {index: value})
        for index, row in enumerate(limits)
        for background in backgrounds[index]
        for limit in row
        for value in (limit - guard_counts - 1, limit + guard_counts)
        if value > 0
    ]
    return [one for one in found if is_clear(robot, one, guard_counts)]


_Row = tuple[int, tuple[int, ...]]
"""A count and its thresholds, rising."""


def _alone(row: _Row, guard: int) -> bool:
    """Say whether a count is clear of all its thresholds."""
    count, limits = row
    return count == 0 or not any(count - guard < limit <= count + guard for limit in limits)


def _apart(one: _Row, other: _Row, guard: int, far_too: bool) -> bool:
    """Say whether two counts cannot change places, or none of both can decide by its place."""
    decides = all(
        count and (far_too or count < limits[-1] + guard) for count, limits in (one, other)
    )
    return not decides or abs(one[0] - other[0]) > 2 * guard
