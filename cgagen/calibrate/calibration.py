"""Measurements and a robot file -> the robot file that says what was measured."""

from collections.abc import Iterator
from dataclasses import dataclass

from cgagen.calibrate.displacements import Displacement, displacement_of, odd_pairs, odd_walks
from cgagen.calibrate.edit import with_value
from cgagen.calibrate.measurements import Mark, Measurements
from cgagen.calibrate.samples import Sample
from cgagen.calibrate.sensors import (
    Curve,
    curve_of,
    odd_lights,
    odd_sonars,
    us_per_in_of,
    usable_marks,
)
from cgagen.errors import MeasurementError
from cgagen.robot import Robot
from cgagen.robot.reader import parse_robot
from cgagen.robot.seal import seal_fits, sealed
from cgagen.words import Movement

DECIMALS = 3
"""Of what is written: a thousandth of an arena unit is 8 um. Choice."""


@dataclass(frozen=True)
class Calibration:
    """A robot file with measured numbers.

    Attributes:
        text: the file.
        robot: what it says.
        movements: of each that was measured, one gait cycle.
        us_per_in: speed of sound; None where no sonar was measured.
        curves: of the lamp, by light sensor; those that were measured.
        warnings: what does not fit together.
    """

    text: str
    robot: Robot
    movements: dict[Movement, Displacement]
    us_per_in: Sample | None
    curves: dict[str, Curve]
    warnings: tuple[str, ...]


def calibrate(
    robot: Robot, file: str, measured: Measurements, units_per_in: float, date: str = ""
) -> Calibration:
    """Put measurements into a robot's file.

    Args:
        robot: as it was.
        file: what messages call its file.
        measured: at least one measurement.
        units_per_in: the arena's scale.
        date: what the comments say about when; "" for nothing.

    Raises:
        MeasurementError: nothing usable was measured, or the file cannot be edited.
        RobotError: the measured numbers make a robot that cannot be.
    """
    movements = {one: displacement_of(walks) for one, walks in sorted(measured.walks.items())}
    sonars, warnings = _sonars(robot, measured.sonars)
    every = [mark for marks in sonars.values() for mark in marks]
    us_per_in = us_per_in_of(robot, every) if every else None
    curves = {name: curve_of(name, marks) for name, marks in measured.lights.items()}
    if not movements and us_per_in is None and not curves:
        raise MeasurementError(f"{file}: no usable measurement; {'; '.join(warnings)}")
    text = robot.text
    for table, key, value, mark in _changes(movements, us_per_in, curves, units_per_in, date):
        text = with_value(text, file, table, key, value, mark)
    if seal_fits(robot.text) is False:
        warnings += [
            f"{file}: was edited since it was calibrated; older comments may be of other numbers"
        ]
    text = sealed(text)
    for movement, walks in sorted(measured.walks.items()):
        warnings += odd_walks(movement, walks)
    warnings += odd_pairs(movements)
    warnings += odd_sonars(robot, sonars, us_per_in.mean) if us_per_in else ()
    warnings += odd_lights(measured.lights) if measured.lights else ()
    return Calibration(text, parse_robot(text, file), movements, us_per_in, curves, tuple(warnings))


def _sonars(robot: Robot, marks: dict[str, list[Mark]]) -> tuple[dict[str, list[Mark]], list[str]]:
    kept: dict[str, list[Mark]] = {}
    warnings: list[str] = []
    for name, ones in marks.items():
        usable, reasons = usable_marks(robot, name, ones)
        warnings += reasons
        if usable:
            kept[name] = usable
    return kept, warnings


def _changes(
    movements: dict[Movement, Displacement],
    us_per_in: Sample | None,
    curves: dict[str, Curve],
    units_per_in: float,
    date: str,
) -> Iterator[tuple[str, str, str, str]]:
    """Return table, key, value and comment of each number that was measured."""
    for movement, one in movements.items():
        table = f"movement.{movement}"
        for key, value in (
            ("along_units", _scaled(one.along_in, units_per_in)),
            ("right_units", _scaled(one.right_in, units_per_in)),
            ("turn_deg", one.turn_deg),
        ):
            yield table, key, _number(value.mean), value.mark(date)
    if us_per_in is not None:
        yield "echo", "us_per_in", _number(us_per_in.mean), us_per_in.mark(date)
    for name, curve in curves.items():
        points = ", ".join(f"[{distance:.10g}, {count}]" for distance, count in curve.points)
        said = f"measured: {curve.readings} readings, spread up to {curve.widest_spread:.2g} counts"
        yield f"light.sensor.{name}", "curve", f"[{points}]", f"{said}, {date}" if date else said


def _scaled(one: Sample, scale: float) -> Sample:
    spread = None if one.spread is None else one.spread * scale
    return Sample(one.mean * scale, spread, one.repeats)


def _number(value: float) -> str:
    """Return a number as a robot file has it.

    >>> _number(-6.45049), _number(-0.0001)
    ('-6.45', '0')
    """
    return f"{round(value, DECIMALS) + 0.0:.10g}"
