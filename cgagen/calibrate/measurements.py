"""Measurements as text: a line for each, under a header that names the units.

Movements, as often as each was repeated, with how many gait cycles were walked in one go and
what they came to: distance along the heading before, distance to the right of that heading, and
turn, counter-clockwise positive, with full turns counted::

    movement,cycles,along_in,right_in,turn_deg
    FORWARD,5,12.1,0.1,-7

Sensors, with the distance that was marked on the floor and the count that the chip measured::

    sensor,distance_in,count
    front,24,4425

Columns may stand in any order; `_cm` or `_mm` may stand for `_in`, and `cycles` may be missing,
which means 1. Lines that begin with `#` say something to people.
"""

import csv
import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

from cgagen.errors import MeasurementError
from cgagen.robot import Robot
from cgagen.words import COMMANDS, Movement

PER_INCH = {"in": 1.0, "cm": 2.54, "mm": 25.4}
"""The units of length that a header may name."""

LIGHT_PREFIX = "light_"
"""Before the name of a light sensor, which may be that of a sonar, too."""

HEADERS = ("movement,cycles,along_in,right_in,turn_deg", "sensor,distance_in,count")
"""The two kinds of tables."""

FARTHEST_IN = 10_000.0
MOST_CYCLES = 1_000
LONGEST_TURN_DEG = 360_000.0
MOST_COUNTS = 65_535


class Walk(NamedTuple):
    """Some gait cycles walked in one go, and where they led.

    Attributes:
        where: file and line.
        cycles: 1 or more.
        along_in: along the heading before.
        right_in: to the right of it.
        turn_deg: counter-clockwise positive; not reduced to a circle.
    """

    where: str
    cycles: int
    along_in: float
    right_in: float
    turn_deg: float


class Mark(NamedTuple):
    """A sensor's count at a marked distance."""

    where: str
    distance_in: float
    counts: int


@dataclass
class Measurements:
    """All that was measured, each list in the order of its lines.

    Attributes:
        walks: by movement.
        sonars: by name.
        lights: by name, without the prefix.
    """

    walks: dict[Movement, list[Walk]] = field(default_factory=dict)
    sonars: dict[str, list[Mark]] = field(default_factory=dict)
    lights: dict[str, list[Mark]] = field(default_factory=dict)


def read_measurements(robot: Robot, texts: dict[str, str]) -> Measurements:
    r"""Read tables of measurements.

    Args:
        robot: whose movements and sensors they are of.
        texts: by the name that messages call them.

    Raises:
        MeasurementError: file, line, and what is allowed there.

    >>> from cgagen.robot import load_robot
    >>> text = "movement,along_cm,right_cm,turn_deg\nFORWARD,6.35,0,-1.5\n"
    >>> read_measurements(load_robot("servobot-predator"), {"typed": text}).walks["FORWARD"]
    [Walk(where='typed: line 2', cycles=1, along_in=2.5, right_in=0.0, turn_deg=-1.5)]
    """
    found = Measurements()
    for name, text in texts.items():
        rows = list(_rows(name, text))
        if not rows:
            raise MeasurementError(f"{name}: no measurements; begin with a line {HEADERS[0]}")
        kinds = {kind for row in rows for kind in ("movement", "sensor") if kind in row.cells}
        for row in rows:
            if kinds == {"movement"}:
                _walk(found, robot, row)
            else:
                _mark(found, robot, row)
    return found


class _Row:
    """One line under its header. Take its cells; `done` refuses what nobody took."""

    def __init__(self, where: str, cells: dict[str, str]) -> None:
        self.where = where
        self.cells = cells
        self._taken: set[str] = set()

    def error(self, column: str, sentence: str) -> MeasurementError:
        whole = f"{self.where}: {column}: {sentence}"
        return MeasurementError("".join(one if one.isprintable() else "?" for one in whole))

    def word(self, column: str, allowed: tuple[str, ...]) -> str:
        self._taken.add(column)
        word = self.cells.get(column, "")
        if word not in allowed:
            raise self.error(column, f"{word!r} is not one of {', '.join(allowed)}")
        return word

    def number(self, column: str, low: float, high: float) -> float:
        self._taken.add(column)
        if column not in self.cells:
            raise self.error(column, f"no such column; a header is like {' or '.join(HEADERS)}")
        try:
            number = float(self.cells[column])
        except ValueError:
            number = math.nan
        if not low <= number <= high:
            raise self.error(
                column, f"{self.cells[column]!r} is not a number from {low:g} to {high:g}"
            )
        return number

    def whole(self, column: str, low: int, high: int) -> int:
        number = self.number(column, low, high)
        if number != int(number):
            raise self.error(column, f"{self.cells[column]!r} is not a whole number")
        return int(number)

    def inches(self, quantity: str, low_in: float) -> float:
        units = [unit for unit in PER_INCH if f"{quantity}_{unit}" in self.cells]
        if len(units) > 1:
            raise self.error(quantity, f"in {' and '.join(units)} at once; keep one column")
        unit = units[0] if units else "in"
        return (
            self.number(f"{quantity}_{unit}", low_in * PER_INCH[unit], FARTHEST_IN * PER_INCH[unit])
            / PER_INCH[unit]
        )

    def done(self) -> None:
        for column in self.cells:
            if column not in self._taken:
                raise self.error(column, f"no such column; a header is like {' or '.join(HEADERS)}")


def _rows(name: str, text: str) -> Iterator[_Row]:
    lines = [
        (number, line)
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    header: list[str] | None = None
    for number, line in lines:
        where = f"{name}: line {number}"
        try:
            cells = [cell.strip() for cell in next(csv.reader([line], strict=True))]
        except csv.Error as error:
            raise MeasurementError(f"{where}: no line of a table ({error})") from error
        if header is None:
            header = cells
            if not {"movement", "sensor"} & set(header) or len(set(header)) < len(header):
                raise MeasurementError(f"{where}: no header; one is like {' or '.join(HEADERS)}")
        elif len(cells) != len(header):
            raise MeasurementError(
                f"{where}: {len(cells)} cells under {len(header)} columns; separate them by commas"
            )
        else:
            yield _Row(where, dict(zip(header, cells, strict=True)))


def _walk(found: Measurements, robot: Robot, row: _Row) -> None:
    movement = Movement(row.word("movement", tuple(COMMANDS[robot.role])))
    walk = Walk(
        row.where,
        row.whole("cycles", 1, MOST_CYCLES) if "cycles" in row.cells else 1,
        row.inches("along", -FARTHEST_IN),
        row.inches("right", -FARTHEST_IN),
        row.number("turn_deg", -LONGEST_TURN_DEG, LONGEST_TURN_DEG),
    )
    row.done()
    found.walks.setdefault(movement, []).append(walk)


def _mark(found: Measurements, robot: Robot, row: _Row) -> None:
    lights = robot.light.sensors if robot.light else ()
    names = [sonar.name for sonar in robot.sonars]
    name = row.word("sensor", (*names, *(LIGHT_PREFIX + sensor.name for sensor in lights)))
    mark = Mark(row.where, row.inches("distance", 0.0), row.whole("count", 0, MOST_COUNTS))
    row.done()
    if name.startswith(LIGHT_PREFIX):
        found.lights.setdefault(name.removeprefix(LIGHT_PREFIX), []).append(mark)
    else:
        found.sonars.setdefault(name, []).append(mark)
