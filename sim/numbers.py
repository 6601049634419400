"""The numbers of one world, flat, as the compiled step reads them.

Everything comes from the robots' and the arena's files through `world_numbers`; the step knows
no number of its own. Distances are in arena units, directions are unit vectors in the frame of
the robot that looks (x ahead, y to the left), counts are the chip's.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import NamedTuple

from cgagen.counts import LightCurve
from cgagen.errors import RobotError
from cgagen.robot import Antenna, Arena, Robot, SituationCounts, Sonar
from cgagen.words import COMMANDS, Movement, Role
from sim.trig import cos_sin_deg

Eight = tuple[float, float, float, float, float, float, float, float]


@dataclass(frozen=True, slots=True)
class Options:
    """What the paper leaves open; None leaves it to the robots' and the arena's files.

    Attributes:
        after_capture: "hold" (both stay and go on scoring) or "go_on".
        masking: whether a sonar that faces the lit target is ignored.
        light: "dark" or "ambient".
        prey_policy: a policy of the prey's file.
        walls: "slide" or "stop".
    """

    after_capture: str | None = None
    masking: bool | None = None
    light: str | None = None
    prey_policy: str | None = None
    walls: str | None = None


class Cone(NamedTuple):
    """Bearings within half a width of an axis, in the looking robot's frame."""

    axis_x: float
    axis_y: float
    cos_half: float


class SonarNumbers(NamedTuple):
    """One sonar."""

    cone: Cone
    sin_half: float
    range_units: float
    fewest: float
    most: float


class AntennaNumbers(NamedTuple):
    """One antenna: the tip of its wire, and where the other robot's body bends it."""

    tip_x: float
    tip_y: float
    length_units: float
    robot: Cone


class StepTable(NamedTuple):
    """Displacement and turn of each command, 000 to 111."""

    along: Eight
    right: Eight
    cos: Eight
    sin: Eight


class PredatorSensors(NamedTuple):
    """The predator's sonars, antennas and light sensors."""

    front: SonarNumbers
    right: SonarNumbers
    left: SonarNumbers
    touch_left: AntennaNumbers
    touch_right: AntennaNumbers
    lit_left: Cone
    lit_right: Cone
    counts_per_unit: float
    curve_left: LightCurve
    curve_right: LightCurve


class PredatorNumbers(NamedTuple):
    """The predator: sensors, Table II in counts, movement table."""

    sensors: PredatorSensors
    limits: SituationCounts
    masking: bool
    steps: StepTable
    radius: float


class PreySensors(NamedTuple):
    """The prey's sonars and antennas."""

    front_left: SonarNumbers
    front_right: SonarNumbers
    left: SonarNumbers
    right: SonarNumbers
    rear_left: SonarNumbers
    rear_right: SonarNumbers
    touch_left: AntennaNumbers
    touch_right: AntennaNumbers
    counts_per_unit: float


class ReflexNumbers(NamedTuple):
    """The prey's rule: the alarm in counts, and its answers as commands."""

    alarm: int
    answers: tuple[int, int, int, int, int, int]
    wait: int
    antenna_left: int
    antenna_right: int
    both_left_open: int
    both_right_open: int


class PreyNumbers(NamedTuple):
    """The prey: sensors, reflex, movement table."""

    sensors: PreySensors
    reflex: ReflexNumbers
    steps: StepTable
    radius: float


class Scoring(NamedTuple):
    """The longest distance, and the score beyond which the prey is caught."""

    longest: float
    capture_score: float


class WorldNumbers(NamedTuple):
    """Both robots and the arena."""

    predator: PredatorNumbers
    prey: PreyNumbers
    side: float
    scoring: Scoring
    hold: bool
    stop_at_walls: bool


def world_numbers(
    predator: Robot, prey: Robot, arena: Arena, options: Options | None = None
) -> WorldNumbers:
    """Turn two robots, an arena and the options of a run into the step's numbers.

    Raises:
        RobotError: the robots and the arena do not fit together, or the prey has no such policy.
    """
    options = options or Options()
    _check_options(options)
    for robot in (predator, prey):
        _check_fits(robot, arena)
    _check_capture(predator, prey, arena)
    return WorldNumbers(
        predator=_predator(_with_light(predator, options), prey, arena, options),
        prey=_prey(_with_policy(prey, options), predator, arena),
        side=arena.side_units,
        scoring=Scoring(arena.longest_units, arena.capture_score_units),
        hold=(options.after_capture or arena.after_capture) == "hold",
        stop_at_walls=(options.walls or arena.walls) == "stop",
    )


_CHOICES = {
    "after_capture": ("hold", "go_on"),
    "masking": (True, False),
    "light": ("dark", "ambient"),
    "walls": ("slide", "stop"),
}


def _check_options(options: Options) -> None:
    for name, allowed in _CHOICES.items():
        value = getattr(options, name)
        if value is not None and value not in allowed:
            words = " or ".join(map(str, allowed))
            raise RobotError(f"option {name}: {value!r} is not {words}")


def _check_fits(robot: Robot, arena: Arena) -> None:
    if 4 * robot.body_radius_units > arena.side_units:
        raise RobotError(
            f"{robot.name}: [body] radius_units: {robot.body_radius_units:g} is too wide for "
            f"{arena.name}, whose side is {arena.side_units:g}; at most a quarter of that"
        )


def _check_capture(predator: Robot, prey: Robot, arena: Arena) -> None:
    capture_units = arena.longest_units - arena.capture_score_units
    if arena.start_gap_units < capture_units:
        raise RobotError(
            f"{arena.name}: start_gap_units: {arena.start_gap_units:g} lets robots start "
            f"captured; more than {capture_units:g} is needed"
        )
    touching = predator.body_radius_units + prey.body_radius_units
    if touching > capture_units:
        raise RobotError(
            f"{arena.name}: capture_score_units: the bodies touch at {touching:g} units, before "
            f"the capture at {capture_units:g}; make the bodies smaller or the score less"
        )


def _with_light(predator: Robot, options: Options) -> Robot:
    if options.light is None or predator.light is None:
        return predator
    return replace(predator, light=replace(predator.light, condition=options.light))


def _with_policy(prey: Robot, options: Options) -> Robot:
    if options.prey_policy is None or prey.reflex is None:
        return prey
    if options.prey_policy not in prey.reflex.policies:
        known = ", ".join(prey.reflex.policies)
        raise RobotError(
            f"{prey.name}: [reflex] policy: {options.prey_policy!r} is not one of {known}"
        )
    return replace(prey, reflex=replace(prey.reflex, policy_name=options.prey_policy))


def _predator(robot: Robot, prey: Robot, arena: Arena, options: Options) -> PredatorNumbers:
    if robot.light is None or robot.limits is None:
        raise RobotError(f"{robot.name}: role: a {robot.role} where the predator is wanted")
    scale = arena.units_per_in
    front, right, left = (_sonar(robot, sonar, scale) for sonar in robot.sonars)
    touch_left, touch_right = (_antenna(antenna, scale) for antenna in robot.antennas)
    lit_left, lit_right = (
        _cone(sensor.bearing_deg, sensor.cone_deg) for sensor in robot.light.sensors
    )
    masking = robot.limits.masking if options.masking is None else options.masking
    sensors = PredatorSensors(
        front=front,
        right=right,
        left=left,
        touch_left=touch_left,
        touch_right=touch_right,
        lit_left=lit_left,
        lit_right=lit_right,
        counts_per_unit=robot.echo_counts_per_in / scale,
        curve_left=robot.light_curve(0, scale),
        curve_right=robot.light_curve(1, scale),
    )
    return PredatorNumbers(
        sensors=sensors,
        limits=robot.situation_counts,
        masking=masking,
        steps=_steps(robot),
        radius=robot.body_radius_units,
    )


def _prey(robot: Robot, predator: Robot, arena: Arena) -> PreyNumbers:
    if robot.reflex is None:
        raise RobotError(f"{robot.name}: role: a {robot.role} where the prey is wanted")
    scale = arena.units_per_in
    front_left, front_right, left, right, rear_left, rear_right = (
        _sonar(robot, sonar, scale) for sonar in robot.sonars
    )
    touch_left, touch_right = (_antenna(antenna, scale) for antenna in robot.antennas)
    reflex = robot.reflex
    a, b, c, d, e, f = (_command(answer) for answer in reflex.policy.answers)
    sensors = PreySensors(
        front_left=front_left,
        front_right=front_right,
        left=left,
        right=right,
        rear_left=rear_left,
        rear_right=rear_right,
        touch_left=touch_left,
        touch_right=touch_right,
        counts_per_unit=robot.echo_counts_per_in / scale,
    )
    numbers = ReflexNumbers(
        alarm=robot.alarm_count,
        answers=(a, b, c, d, e, f),
        wait=_command(Movement.WAIT),
        antenna_left=_command(reflex.antenna_left),
        antenna_right=_command(reflex.antenna_right),
        both_left_open=_command(reflex.both_left_open),
        both_right_open=_command(reflex.both_right_open),
    )
    return PreyNumbers(
        sensors=sensors,
        reflex=numbers,
        steps=_steps(robot),
        radius=robot.body_radius_units,
    )


def _command(movement: Movement) -> int:
    return COMMANDS[Role.PREY].index(movement)


def _cone(bearing_deg: float, width_deg: float) -> Cone:
    axis_x, axis_y = cos_sin_deg(bearing_deg)
    return Cone(axis_x, axis_y, cos_sin_deg(width_deg / 2)[0])


def _sonar(robot: Robot, sonar: Sonar, units_per_in: float) -> SonarNumbers:
    fewest, most = robot.echo_limits_counts(sonar)
    return SonarNumbers(
        cone=_cone(sonar.bearing_deg, sonar.cone_deg),
        sin_half=cos_sin_deg(sonar.cone_deg / 2)[1],
        range_units=sonar.range_in * units_per_in,
        fewest=fewest,
        most=most,
    )


def _antenna(antenna: Antenna, units_per_in: float) -> AntennaNumbers:
    length = antenna.length_in * units_per_in
    x, y = cos_sin_deg(antenna.bearing_deg)
    first_deg, last_deg = antenna.robot_deg
    return AntennaNumbers(
        tip_x=length * x,
        tip_y=length * y,
        length_units=length,
        robot=_cone((first_deg + last_deg) / 2, last_deg - first_deg),
    )


def _steps(robot: Robot) -> StepTable:
    turns = [cos_sin_deg(step.turn_deg) for step in robot.steps]
    return StepTable(
        _eight(step.along_units for step in robot.steps),
        _eight(step.right_units for step in robot.steps),
        _eight(cosine for cosine, _ in turns),
        _eight(sine for _, sine in turns),
    )


def _eight(values: Iterable[float]) -> Eight:
    a, b, c, d, e, f, g, h = values
    return (a, b, c, d, e, f, g, h)
