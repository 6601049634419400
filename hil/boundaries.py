"""The limits of a robot, sensor by sensor, with the names that its file gives them."""

from typing import NamedTuple

from cgagen.robot import Robot
from hil.target import Stimulus

STEPS = (-1, 0, 1)
"""A limit is tried with one count less, itself, and one more."""


class Boundary(NamedTuple):
    """One limit of one sensor.

    Attributes:
        place: of the sensor among the counts of a stimulus, sonars first.
        sensor: "front sonar", "left light".
        limit: "near", "middle", "far", "range", "alarm".
        distance_in: as the robot's file has it.
        counts: the same in chip counts; a smaller count is nearer.
    """

    place: int
    sensor: str
    limit: str
    distance_in: float
    counts: int


def boundaries(robot: Robot) -> list[Boundary]:
    """Return all limits of a robot, in the order of its sensors."""
    if robot.limits is None or robot.light is None:
        alarm_in = robot.reflex.policy.alarm_in if robot.reflex else 0.0
        return [
            Boundary(index, f"{_words(sonar.name)} sonar", "alarm", alarm_in, robot.alarm_count)
            for index, sonar in enumerate(robot.sonars)
        ]
    limits, counts = robot.limits, robot.situation_counts
    front = (
        ("near", limits.front_near_in, counts.front_near),
        ("middle", limits.front_middle_in, counts.front_middle),
        ("far", limits.front_far_in, counts.front_far),
    )
    side = (
        ("near", limits.side_near_in, counts.side_near),
        ("far", limits.side_far_in, counts.side_far),
    )
    rows = [
        Boundary(index, f"{_words(sonar.name)} sonar", *row)
        for index, sonar in enumerate(robot.sonars)
        for row in (front if sonar.name == "front" else side)
    ]
    first = len(robot.sonars)
    lamps = (counts.lamp_left, counts.lamp_right)
    for index, (sensor, lamp) in enumerate(zip(robot.light.sensors, lamps, strict=True)):
        light = (
            ("near ahead", limits.target_front_near_in, lamp.front_near),
            ("middle ahead", limits.target_front_middle_in, lamp.front_middle),
            ("near aside", limits.target_side_near_in, lamp.side_near),
            ("range", robot.light.range_in, lamp.range),
        )
        rows += [Boundary(first + index, f"{_words(sensor.name)} light", *row) for row in light]
    return rows


def steps_of(stimulus: Stimulus, limits: list[Boundary]) -> list[tuple[int, int]]:
    """Return the limits that a stimulus is at, as number in the list and step.

    >>> limit = Boundary(1, "left sonar", "near", 10.0, 1843)
    >>> steps_of(Stimulus((0, 1842)), [limit])
    [(0, -1)]
    """
    counts = (*stimulus.sonars, *stimulus.lights)
    steps = ((number, counts[one.place] - one.counts) for number, one in enumerate(limits))
    return [(number, step) for number, step in steps if step in STEPS]


def _words(name: str) -> str:
    return name.replace("_", " ")
