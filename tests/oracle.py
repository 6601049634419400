"""A second world, to test the first: angles, distances and rays in plain Python.

It shares no code with `sim` and takes its numbers from the robots' files directly. Angles are in
degrees, counter-clockwise; `math.atan2` finds bearings; sonars are rays and feet of
perpendiculars. `readings`, `state_of` and `answer_of` work on the chip's integers alone.
"""

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from cgagen.robot import SONAR_KINDS, Arena, Robot
from cgagen.robot.values import Antenna, LightSensor, Sonar, Step
from cgagen.words import COMMANDS, Movement, Role

FARTHEST = 65_535
"""What no echo, or a masked sonar, counts as: more than any threshold."""

NO, NEAR_RIGHT, FAR_RIGHT, NEAR_LEFT, FAR_LEFT, NEAR_FRONT, MIDDLE_FRONT, FAR_FRONT = range(8)


class Pose(NamedTuple):
    """Where a robot stands and looks."""

    x: float
    y: float
    heading_deg: float


class Look(NamedTuple):
    """What both robots measure and decide at one instant.

    Attributes:
        reading: sonars front, right, left; antennas left, right; lights left, right.
        state: 0 to 63.
        command: the gene, 0 to 7.
        prey_reading: the six sonars in the order of the file's table; antennas left, right.
        answer: the prey's command.
    """

    reading: tuple[int, ...]
    state: int
    command: int
    prey_reading: tuple[int, ...]
    answer: int


class After(NamedTuple):
    """One step: what was seen before it (None while both are held), and what it led to."""

    look: Look | None
    predator: Pose
    prey: Pose
    distance: float
    score: float
    captured: bool


# -- from inches to counts ------------------------------------------------------------------------


def echo_counts(distance_in: float, robot: Robot, shortest_us: float, longest_us: float) -> int:
    """Return what PULSIN measures of an echo from a distance."""
    echo_us = min(max(distance_in * 2 * robot.echo.us_per_in, shortest_us), longest_us)
    return math.floor(echo_us * 1000 / robot.main.pulsin_unit_ns)


def threshold_counts(distance_in: float, robot: Robot) -> int:
    """Return the count of a threshold: the same conversion, but no sonar's limits."""
    return min(echo_counts(distance_in, robot, 0.0, math.inf), FARTHEST)


def light_counts(distance_in: float, curve: tuple[tuple[float, int], ...]) -> int:
    """Return what RCTIME measures of a lamp at a distance: straight lines between the rows."""
    if distance_in < curve[0][0]:
        return curve[0][1]
    for (near_in, near), (far_in, far) in itertools.pairwise(curve):
        if near_in <= distance_in < far_in:
            return math.floor(near + (far - near) * (distance_in - near_in) / (far_in - near_in))
    return curve[-1][1]


# -- geometry -------------------------------------------------------------------------------------


def turn_between(from_deg: float, to_deg: float) -> float:
    """Return the shortest turn from one direction to another, -180 to 180."""
    return (to_deg - from_deg + 180.0) % 360.0 - 180.0


def bearing_of(at: Pose, other: Pose) -> float:
    """Return where another robot's centre stands, relative to a robot's heading."""
    direction_deg = math.degrees(math.atan2(other.y - at.y, other.x - at.x))
    return turn_between(at.heading_deg, direction_deg)


def wall_along_ray(x: float, y: float, direction_deg: float, side: float) -> float:
    """Return how far a ray goes before it meets a wall."""
    ahead, up = math.cos(math.radians(direction_deg)), math.sin(math.radians(direction_deg))
    to_east_or_west = ((side if ahead > 0 else 0.0) - x) / ahead if ahead else math.inf
    to_north_or_south = ((side if up > 0 else 0.0) - y) / up if up else math.inf
    return min(to_east_or_west, to_north_or_south)


def wall_in_cone(x: float, y: float, axis_deg: float, cone_deg: float, side: float) -> float:
    """Return the distance of the nearest point of any wall within a cone.

    In a convex room that is where one of the cone's edges ends, or the foot of a perpendicular.
    """
    half = cone_deg / 2
    nearest = min(
        wall_along_ray(x, y, axis_deg - half, side), wall_along_ray(x, y, axis_deg + half, side)
    )
    for normal_deg, distance in ((0, side - x), (90, side - y), (180, x), (270, y)):
        if distance < nearest and abs(turn_between(axis_deg, normal_deg)) <= half:
            nearest = distance
    return nearest


# -- decisions ------------------------------------------------------------------------------------


class Limits(NamedTuple):
    """Table II in counts, by the names of the robot's file."""

    front_near: int
    front_middle: int
    front_far: int
    side_near: int
    side_far: int
    target_front_near: tuple[int, int]
    target_front_middle: tuple[int, int]
    target_side_near: tuple[int, int]
    target_range: tuple[int, int]
    """Of the left light sensor and of the right one, likewise the three above."""


def limits_of(predator: Robot, light_range_in: float) -> Limits:
    """Return the thresholds of a predator's file in the counts of its chip."""
    assert predator.limits is not None
    assert predator.light is not None
    inches, sensors = predator.limits, predator.light.sensors

    def by_both(distance_in: float) -> tuple[int, int]:
        left, right = (light_counts(distance_in, sensor.curve) for sensor in sensors)
        return left, right

    return Limits(
        front_near=threshold_counts(inches.front_near_in, predator),
        front_middle=threshold_counts(inches.front_middle_in, predator),
        front_far=threshold_counts(inches.front_far_in, predator),
        side_near=threshold_counts(inches.side_near_in, predator),
        side_far=threshold_counts(inches.side_far_in, predator),
        target_front_near=by_both(inches.target_front_near_in),
        target_front_middle=by_both(inches.target_front_middle_in),
        target_side_near=by_both(inches.target_side_near_in),
        target_range=by_both(light_range_in),
    )


def target_of(light_left: int, light_right: int, limits: Limits) -> int:
    """Return the target situation of two light counts."""
    counts = light_left, light_right

    def nearer(bounds: tuple[int, int]) -> list[bool]:
        return [count < bound for count, bound in zip(counts, bounds, strict=True)]

    left, right = (
        count >= 1 and near for count, near in zip(counts, nearer(limits.target_range), strict=True)
    )
    if left and right:
        if any(nearer(limits.target_front_near)):
            return NEAR_FRONT
        return MIDDLE_FRONT if any(nearer(limits.target_front_middle)) else FAR_FRONT
    aside = nearer(limits.target_side_near)
    if left:
        return NEAR_LEFT if aside[0] else FAR_LEFT
    if right:
        return NEAR_RIGHT if aside[1] else FAR_RIGHT
    return NO


MASKED: dict[int, tuple[str, ...]] = {
    NO: (),
    NEAR_RIGHT: ("front", "right"),
    FAR_RIGHT: ("front", "right"),
    NEAR_LEFT: ("front", "left"),
    FAR_LEFT: ("front", "left"),
    NEAR_FRONT: ("front", "right", "left"),
    MIDDLE_FRONT: ("front", "right", "left"),
    FAR_FRONT: ("front", "right", "left"),
}
"""The sonars that face a target, and so see it and no obstacle."""


def heard(count: int) -> int:
    """Return a sonar's count for comparison: 0 is no echo at all."""
    return count if count else FARTHEST


def obstacle_of(reading: tuple[int, ...], masked: tuple[str, ...], limits: Limits) -> int:
    """Return the obstacle situation of a predator's reading."""
    touch_left, touch_right = reading[3], reading[4]
    if touch_left and touch_right:
        return NEAR_FRONT
    if touch_left:
        return NEAR_LEFT
    if touch_right:
        return NEAR_RIGHT
    nearest, count = "", FARTHEST
    for name, measured in zip(("front", "right", "left"), reading[:3], strict=True):
        if name not in masked and heard(measured) < count:
            nearest, count = name, heard(measured)
    if nearest == "front":
        if count < limits.front_near:
            return NEAR_FRONT
        if count < limits.front_middle:
            return MIDDLE_FRONT
        return FAR_FRONT if count < limits.front_far else NO
    if nearest == "right":
        if count < limits.side_near:
            return NEAR_RIGHT
        return FAR_RIGHT if count < limits.side_far else NO
    if nearest == "left":
        if count < limits.side_near:
            return NEAR_LEFT
        return FAR_LEFT if count < limits.side_far else NO
    return NO


def state_of(reading: tuple[int, ...], masking: bool, limits: Limits) -> int:
    """Return the state of a predator's reading (columns as of `Look.reading`)."""
    target = target_of(reading[5], reading[6], limits)
    obstacle = obstacle_of(reading, MASKED[target] if masking else (), limits)
    return 8 * obstacle + target


def answer_of(reading: tuple[int, ...], prey: Robot, policy_name: str) -> Movement:
    """Return what the prey does about a reading (columns as of `Look.prey_reading`)."""
    assert prey.reflex is not None
    reflex, policy = prey.reflex, prey.reflex.policies[policy_name]
    sonars = [heard(count) for count in reading[:6]]
    touch_left, touch_right = reading[6], reading[7]
    if touch_left and touch_right:
        names = [sonar.name for sonar in prey.sonars]
        left, right = sonars[names.index("left")], sonars[names.index("right")]
        return reflex.both_left_open if left > right else reflex.both_right_open
    if touch_left:
        return reflex.antenna_left
    if touch_right:
        return reflex.antenna_right
    nearest = min(sonars)
    if nearest < threshold_counts(policy.alarm_in, prey):
        return policy.answers[sonars.index(nearest)]
    return Movement.WAIT


# -- the world ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Oracle:
    """Two robots in an arena, and what the paper leaves open."""

    predator: Robot
    prey: Robot
    arena: Arena
    hold: bool
    masking: bool
    light_range_in: float
    policy: str
    stop_at_walls: bool

    @cached_property
    def limits(self) -> Limits:
        """The predator's thresholds in counts."""
        return limits_of(self.predator, self.light_range_in)

    def sonar(self, robot: Robot, other: Robot, sonar: Sonar, at: Pose, seen: Pose) -> int:
        """Return one sonar's count."""
        units = self.arena.units_per_in
        axis_deg = at.heading_deg + sonar.bearing_deg
        nearest = wall_in_cone(at.x, at.y, axis_deg, sonar.cone_deg, self.arena.side_units)
        if abs(turn_between(sonar.bearing_deg, bearing_of(at, seen))) <= sonar.cone_deg / 2:
            surface = math.dist(at[:2], seen[:2]) - other.body_radius_units
            nearest = min(nearest, surface)
        kind = SONAR_KINDS[sonar.kind]
        distance_in = nearest / units if nearest / units <= sonar.range_in else math.inf
        return echo_counts(distance_in, robot, kind.shortest_us, kind.longest_us)

    def touched(self, antenna: Antenna, at: Pose, seen: Pose) -> int:
        """Return 1 if a wall or the other robot bends an antenna."""
        length = antenna.length_in * self.arena.units_per_in
        along = at.heading_deg + antenna.bearing_deg
        if wall_along_ray(at.x, at.y, along, self.arena.side_units) <= length:
            return 1
        low_deg, high_deg = antenna.robot_deg
        near = math.dist(at[:2], seen[:2]) <= length
        return int(near and low_deg <= bearing_of(at, seen) <= high_deg)

    def lit(self, sensor: LightSensor, at: Pose, seen: Pose) -> int:
        """Return one light sensor's count of the lamp on the other robot."""
        assert self.predator.light is not None
        if abs(turn_between(sensor.bearing_deg, bearing_of(at, seen))) > sensor.cone_deg / 2:
            return 0
        distance_in = math.dist(at[:2], seen[:2]) / self.arena.units_per_in
        return light_counts(distance_in, sensor.curve)

    def readings(self, predator: Pose, prey: Pose) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """Return what both chips measure at one instant."""
        assert self.predator.light is not None
        hunter = (
            *(
                self.sonar(self.predator, self.prey, s, predator, prey)
                for s in self.predator.sonars
            ),
            *(self.touched(antenna, predator, prey) for antenna in self.predator.antennas),
            *(self.lit(sensor, predator, prey) for sensor in self.predator.light.sensors),
        )
        hunted = (
            *(self.sonar(self.prey, self.predator, s, prey, predator) for s in self.prey.sonars),
            *(self.touched(antenna, prey, predator) for antenna in self.prey.antennas),
        )
        return hunter, hunted

    def look(self, predator: Pose, prey: Pose, genes: list[int]) -> Look:
        """Return what both robots measure and decide."""
        hunter, hunted = self.readings(predator, prey)
        state = state_of(hunter, self.masking, self.limits)
        answer = answer_of(hunted, self.prey, self.policy)
        return Look(hunter, state, genes[state], hunted, COMMANDS[Role.PREY].index(answer))

    def moved(self, robot: Robot, at: Pose, step: Step) -> Pose:
        """Return the pose after a gait cycle: it shifts along the old heading, then turns."""
        heading, right = math.radians(at.heading_deg), math.radians(at.heading_deg - 90)
        x = at.x + step.along_units * math.cos(heading) + step.right_units * math.cos(right)
        y = at.y + step.along_units * math.sin(heading) + step.right_units * math.sin(right)
        low, high = robot.body_radius_units, self.arena.side_units - robot.body_radius_units
        free_x, free_y = min(max(x, low), high), min(max(y, low), high)
        if self.stop_at_walls and (free_x, free_y) != (x, y):
            free_x, free_y = at.x, at.y
        return Pose(free_x, free_y, (at.heading_deg + step.turn_deg) % 360.0)

    def caught(self, distance: float) -> bool:
        """Say whether robots so far apart are one catcher and one catch."""
        return self.arena.longest_units - distance > self.arena.capture_score_units

    def score(self, distance: float, number: int) -> float:
        """Return the score of a step, doubled by a capture, with the bonus for speed."""
        score = self.arena.longest_units - distance
        if self.caught(distance):
            score *= 2
        return score + score / number**2

    def play(self, genes: list[int], predator: Pose, prey: Pose, steps: int) -> Iterator[After]:
        """Play one episode, step by step."""
        captured = False
        for number in range(1, steps + 1):
            look = None
            if not (captured and self.hold):
                look = self.look(predator, prey, genes)
                predator, prey = (
                    self.moved(self.predator, predator, self.predator.steps[look.command]),
                    self.moved(self.prey, prey, self.prey.steps[look.answer]),
                )
            distance = math.dist(predator[:2], prey[:2])
            captured = captured or self.caught(distance)
            yield After(look, predator, prey, distance, self.score(distance, number), captured)
