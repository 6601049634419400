"""Whether a reading is one of a robot: its sensors by number and kind, its counts by range.

Readings come from tests, traces, command lines and programs. Each target asks here before it
looks at one, so that none decides about sensors that the robot does not have, and all say the
same of it.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from cgagen.counts import FARTHEST_COUNT
from cgagen.errors import ReadingError
from cgagen.robot import Robot
from cgagen.shown import shown
from hil.target import Stimulus


def shape_of(robot: Robot) -> tuple[int, int, int]:
    """Return how many sonars, antennas and light sensors a robot has."""
    return len(robot.sonars), 2, len(robot.light.sensors) if robot.light else 0


def trouble_of(stimulus: Stimulus, robot: Robot) -> str:
    """Return why a reading is not of a robot, as the end of a sentence; "" where it is.

    >>> from cgagen.robot import load_robot
    >>> trouble_of(Stimulus((7,)), load_robot("servobot-prey"))[:51]
    'has 1 sonars and 0 light sensors, and servobot-prey'
    """
    try:
        counts = [*stimulus.sonars, *stimulus.lights]
        found = (len(stimulus.sonars), len(stimulus.touched), len(stimulus.lights))
    except (TypeError, AttributeError):
        return f"is {shown(stimulus)}, no Stimulus of counts and antennas"
    wanted = shape_of(robot)
    if (found[0], found[2]) != (wanted[0], wanted[2]):
        return (
            f"has {found[0]} sonars and {found[2]} light sensors, and {robot.name} has "
            f"{wanted[0]} and {wanted[2]}: {_roster(robot)}"
        )
    if found[1] != 2 or not all(isinstance(one, bool | np.bool_) for one in stimulus.touched):
        return f"has the antennas {shown(stimulus.touched)}: left and right, each True or False"
    for one in counts:
        if isinstance(one, bool) or not isinstance(one, int | np.integer):
            return f"has the count {shown(one)}: counts are whole numbers"
        if not 0 <= one <= FARTHEST_COUNT:
            return f"has the count {one}: a chip counts from 0 to {FARTHEST_COUNT:,}"
    return ""


def check_reading(stimulus: Stimulus, robot: Robot) -> None:
    """Refuse a reading that is not of a robot.

    Raises:
        ReadingError: it has other sensors, or counts that no chip has.
    """
    trouble = trouble_of(stimulus, robot)
    if trouble:
        raise ReadingError(f"the reading {_text(stimulus)} {trouble}; give one of {robot.name}")


def check_senses(counts: tuple[int, int, int], robot: Robot) -> None:
    """Refuse another number of echoes, antennas or RC times than a robot has sensors for.

    Raises:
        ReadingError: it is another.
    """
    if counts != shape_of(robot):
        raise ReadingError(
            f"{counts[0]} echoes, {counts[1]} antennas, {counts[2]} RC times: {robot.name} has "
            f"{_roster(robot)}; give one of each"
        )


def rows_of(stimuli: Sequence[Stimulus], robot: Robot) -> np.ndarray[Any, np.dtype[np.int64]]:
    """Return readings as rows of numbers: sonars, antennas, lights.

    Raises:
        ReadingError: see `check_reading`; the first one that is none is named.
    """
    columns = sum(shape_of(robot))
    if not len(stimuli):
        return np.zeros((0, columns), np.int64)
    shapes, rows, flags, counts = set(), None, False, False
    try:
        shapes = {(len(s.sonars), len(s.touched), len(s.lights)) for s in stimuli}
        flags = {type(one) for s in stimuli for one in s.touched} <= {bool, np.bool_}
        counts = bool not in {type(one) for s in stimuli for one in (*s.sonars, *s.lights)}
        rows = np.array([(*s.sonars, *s.touched, *s.lights) for s in stimuli])
    except (TypeError, ValueError, AttributeError, OverflowError):
        flags = False
    whole = rows is not None and rows.dtype.kind in "iu" and shapes == {shape_of(robot)}
    if (
        rows is None
        or not (whole and flags and counts)
        or rows.min() < 0
        or rows.max() > FARTHEST_COUNT
    ):
        for stimulus in stimuli:
            check_reading(stimulus, robot)
        raise ReadingError(f"{shown(stimuli)}: is no list of readings of {robot.name}; give one")
    return rows.astype(np.int64)


def _roster(robot: Robot) -> str:
    words = f"sonars {', '.join(one.name for one in robot.sonars)}; antennas left, right"
    if robot.light:
        words += f"; light {', '.join(one.name for one in robot.light.sensors)}"
    return words


def _text(stimulus: Stimulus) -> str:
    try:
        return stimulus.text()
    except (TypeError, ValueError, AttributeError):
        return shown(stimulus)
