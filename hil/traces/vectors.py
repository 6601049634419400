"""A trace as a table: CSV with the unit of every column in its name, written by hand or converted.

One reading a line. `front_counts` is what the chip measures (0: no echo, dark), `front_in` a
distance in inches, which becomes a count as in the simulator (`none`: no echo, `dark`: no lamp).
`antenna_left` is 1 where it is touched. `state` and `command`, where there are such columns, are
what is expected; an empty cell expects nothing. Lines that begin with `#` are comments.
"""

import itertools
import re
from collections.abc import Callable, Sequence
from typing import NamedTuple

from cgagen.counts import FARTHEST_COUNT, NO_ECHO_COUNT, UNLIT_COUNT, echo_count, light_count
from cgagen.errors import TraceError
from cgagen.robot import Robot, Sonar
from cgagen.words import COMMANDS as MOVEMENTS
from hil.target import Stimulus
from hil.traces.values import NS_PER_US, Sample, Trace, check_decision, refused

TIME = "t_ms"
TAIL = ("state", "command", "latency_us")
"""Columns that may be missing at the end, in this order."""

MOST_LATENCY_US = 200_000_000
"""OBS_DECISION has no room for more than 214 s."""

MEND = "correct it"

Cell = Callable[[str], int]
"""Turns a cell into a number. Raises ValueError with what would be right."""


class Column(NamedTuple):
    """A column of sensors: its name without the unit, and what it may be in."""

    name: str
    units: dict[str, Cell]


def columns_of(robot: Robot) -> list[Column]:
    """Return the columns of a robot's sensors, in their order: sonars, antennas, lights."""
    columns = [
        Column(sonar.name, {"_counts": _count, "_in": _echo_of(robot, sonar)})
        for sonar in robot.sonars
    ]
    columns += [Column(f"antenna_{antenna.name}", {"": _flag}) for antenna in robot.antennas]
    if robot.light:
        columns += [
            Column(f"light_{sensor.name}", {"_counts": _count, "_in": _light_of(robot, side)})
            for side, sensor in enumerate(robot.light.sensors)
        ]
    return columns


def header_of(robot: Robot) -> str:
    """Return the first line of a robot's vectors, in counts."""
    names = [column.name + next(iter(column.units)) for column in columns_of(robot)]
    return ",".join([TIME, *names, *TAIL])


def parse_vectors(text: str, name: str, robot: Robot) -> Trace:
    """Read vectors.

    Args:
        text: of the file.
        name: of the file, for messages.
        robot: whose they are.

    Raises:
        TraceError: a line that cannot be; the sentence has its number.
    """
    rows = [
        (number, [cell.strip() for cell in line.split(",")])
        for number, line in enumerate(text.removeprefix("\ufeff").splitlines(), 1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if not rows:
        raise refused(name, "", "holds no header and no reading", f"begin with {header_of(robot)}")
    (line, names), *body = rows
    cells = _cells_of(names, f"{name}: line {line}", robot)
    samples = [
        _sample(row, names, cells, number, seq, name, robot)
        for seq, (number, row) in enumerate(body, 1)
    ]
    if not samples:
        raise refused(name, f"line {line}", "no reading follows the header", "add one")
    _check_times(name, samples)
    first_ns = samples[0].time_ns
    return Trace(name, tuple(_later(sample, -first_ns) for sample in samples))


def vectors_text(trace: Trace, robot: Robot) -> str:
    """Return a trace as CSV, in counts; the columns behind the sensors where one has something."""
    kept = [
        index
        for index in range(len(TAIL))
        if any(_tail(sample)[index] is not None for sample in trace.samples)
    ]
    names = header_of(robot).split(",")[: -len(TAIL)]
    lines = [",".join([*names, *(TAIL[index] for index in kept)])]
    for sample in trace.samples:
        reading = sample.stimulus
        numbers = (*reading.sonars, *map(int, reading.touched), *reading.lights)
        tail = [_tail(sample)[index] for index in kept]
        cells = [_decimal(sample.time_ns, 1_000_000), *map(str, numbers)]
        lines.append(",".join([*cells, *("" if one is None else str(one) for one in tail)]))
    return "\n".join(lines) + "\n"


def _tail(sample: Sample) -> tuple[int | None, int | None, str | None]:
    latency = sample.latency_ns
    text = None if latency is None else _decimal(latency, NS_PER_US)
    return sample.state, sample.command, text


def _decimal(value_ns: int, unit_ns: int) -> str:
    """Return whole nanoseconds in a larger unit, exactly.

    >>> _decimal(1_500, 1_000), _decimal(2_000_000, 1_000_000)
    ('1.5', '2')
    """
    whole, rest = divmod(value_ns, unit_ns)
    digits = f"{rest:0{len(str(unit_ns)) - 1}d}".rstrip("0")
    return f"{whole}.{digits}" if digits else str(whole)


def _cells_of(names: Sequence[str], where: str, robot: Robot) -> list[Cell]:
    """Return what reads each column; the header has to be the robot's, to the letter."""
    wanted = header_of(robot)
    columns = columns_of(robot)
    choices: list[dict[str, Cell]] = [{TIME: _time}]
    choices += [{one.name + unit: cell for unit, cell in one.units.items()} for one in columns]
    cells: list[Cell] = []
    for index, options in enumerate(choices):
        given = names[index] if index < len(names) else "nothing"
        if given not in options:
            raise TraceError(
                f"{where}: column {index + 1} is {given[:40]!r}, where a {robot.name} has "
                f"{' or '.join(options)}; the header is like {wanted}"
            )
        cells.append(options[given])
    rest = list(names[len(choices) :])
    if rest != [one for one in TAIL if one in rest]:
        raise TraceError(
            f"{where}: behind the sensors may come {', '.join(TAIL)}, each once and in this order, "
            f"not {', '.join(rest)[:60]!r}; the header is like {wanted}"
        )
    tail: dict[str, Cell] = {"state": _state, "command": _command_of(robot), "latency_us": _us}
    return [*cells, *(tail[one] for one in rest)]


def _sample(
    row: list[str],
    names: Sequence[str],
    cells: list[Cell],
    number: int,
    seq: int,
    name: str,
    robot: Robot,
) -> Sample:
    where = f"line {number}"
    if len(row) != len(names):
        raise refused(name, where, f"has {len(row)} cells and the header {len(names)}", MEND)
    values: list[int | None] = []
    for title, cell, text in zip(names, cells, row, strict=True):
        if not text and title in TAIL:
            values.append(None)
            continue
        try:
            values.append(cell(text))
        except ValueError as error:
            raise refused(name, where, f"{title} is {text[:40]!r}: {error}", MEND) from error
    tail = dict(zip(names, values, strict=True))
    state, command, latency = (tail.get(one) for one in TAIL)
    wrong = check_decision(robot.role, state, command)
    if wrong:
        raise refused(name, where, wrong, MEND)
    numbers = [value or 0 for value in values]
    sonars, touched = 1 + len(robot.sonars), 3 + len(robot.sonars)
    lights = touched + (len(robot.light.sensors) if robot.light else 0)
    stimulus = Stimulus(
        tuple(numbers[1:sonars]),
        (bool(numbers[sonars]), bool(numbers[sonars + 1])),
        tuple(numbers[touched:lights]),
    )
    return Sample(numbers[0], stimulus, seq & 0xFFFF, state, command, latency, where)


def _check_times(name: str, samples: Sequence[Sample]) -> None:
    for before, after in itertools.pairwise(samples):
        if after.time_ns < before.time_ns:
            raise refused(
                name,
                after.where,
                f"the time goes back from {_decimal(before.time_ns, 1_000_000)} ms to "
                f"{_decimal(after.time_ns, 1_000_000)} ms",
                "put the lines in order",
            )


def _later(sample: Sample, by_ns: int) -> Sample:
    return Sample(
        sample.time_ns + by_ns,
        sample.stimulus,
        sample.seq,
        sample.state,
        sample.command,
        sample.latency_ns,
        sample.where,
    )


# -- Cells -------------------------------------------------------------------------------------


def _time(text: str) -> int:
    """Return milliseconds as nanoseconds.

    >>> _time("1.25")
    1250000
    """
    match = re.fullmatch(r"([0-9]{1,12})(?:\.([0-9]{1,3}))?", text)
    if not match:
        raise ValueError("milliseconds are wanted, such as 20 or 20.125")
    return int(match[1]) * 1_000_000 + int((match[2] or "").ljust(3, "0")) * NS_PER_US


def _us(text: str) -> int:
    match = re.fullmatch(r"([0-9]{1,9})(?:\.([0-9]{1,3}))?", text)
    if not match:
        raise ValueError("microseconds are wanted, such as 20 or 20.05")
    if int(match[1]) > MOST_LATENCY_US:
        raise ValueError(f"it is {MOST_LATENCY_US} at most")
    return int(match[1]) * NS_PER_US + int((match[2] or "").ljust(3, "0"))


def _count(text: str) -> int:
    if not re.fullmatch(r"[0-9]{1,5}", text) or int(text) > FARTHEST_COUNT:
        raise ValueError(f"a count is 0 to {FARTHEST_COUNT}")
    return int(text)


def _flag(text: str) -> int:
    if text not in ("0", "1"):
        raise ValueError("it is 1 for touched and 0 for free")
    return int(text)


def _inches(text: str, nothing: str) -> float | None:
    if text == nothing:
        return None
    if not re.fullmatch(r"[0-9]{1,4}(\.[0-9]{1,6})?", text):
        raise ValueError(f"inches are wanted, such as 12.5, or {nothing}")
    return float(text)


def _echo_of(robot: Robot, sonar: Sonar) -> Cell:
    def cell(text: str) -> int:
        distance_in = _inches(text, "none")
        if distance_in is None:
            return NO_ECHO_COUNT
        return echo_count(distance_in, robot.echo_counts_per_in, *robot.echo_limits_counts(sonar))

    return cell


def _light_of(robot: Robot, side: int) -> Cell:
    curve = robot.light_curve(side)

    def cell(text: str) -> int:
        distance_in = _inches(text, "dark")
        return UNLIT_COUNT if distance_in is None else light_count(distance_in, curve)

    return cell


def _state(text: str) -> int:
    if not re.fullmatch(r"[0-9]{1,2}", text):
        raise ValueError("a state is a number")
    return int(text)


def _command_of(robot: Robot) -> Cell:
    movements = [str(one) for one in MOVEMENTS[robot.role]]

    def cell(text: str) -> int:
        if text in movements:
            return movements.index(text)
        if not re.fullmatch(r"[0-7]", text):
            raise ValueError(f"a command is 0 to 7, or one of {', '.join(movements)}")
        return int(text)

    return cell
