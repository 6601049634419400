"""A trace in words: readings, situations, movements and times, as a table or as JSON."""

from typing import Any

from cgagen.robot import Robot
from cgagen.telemetry import prey_reason
from cgagen.words import COMMANDS, Role, situation_name, situations_of
from hil.simulated import states_of
from hil.traces.values import Sample, Trace


def rows_of(trace: Trace, robot: Robot) -> list[dict[str, Any]]:
    """Return a row for each reading, as JSON has it.

    The state is the recorded one, or, where none was recorded, what the robot's thresholds make
    of the reading; `recorded` tells which.
    """
    seen = states_of(robot, trace.stimuli).tolist()
    return [_row(one, state, robot) for one, state in zip(trace.samples, seen, strict=True)]


def table_of(trace: Trace, robot: Robot) -> str:
    """Return the rows as text; a state in brackets was not recorded."""
    rows = [_cells(row, robot) for row in rows_of(trace, robot)]
    heads = ["seq", "time_s", *_sensors(robot), *_situations(robot), "state", "movement"]
    widths = [max(len(row[n]) for row in [heads, *rows]) for n in range(len(heads))]
    numbers = 2 + len(_sensors(robot))
    return "\n".join(
        "  ".join(
            cell.rjust(width) if n < numbers else cell.ljust(width)
            for n, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in [heads, *rows]
    )


def _sensors(robot: Robot) -> list[str]:
    """Return the columns of a reading."""
    lights = [f"light_{one.name}" for one in robot.light.sensors] if robot.light else []
    return [*(one.name for one in robot.sonars), "touch", *lights]


def _situations(robot: Robot) -> list[str]:
    return ["obstacle", "target"] if robot.role is Role.PREDATOR else ["reason"]


def _row(sample: Sample, seen: int, robot: Robot) -> dict[str, Any]:
    stimulus = sample.stimulus
    state = seen if sample.state is None else sample.state
    command = sample.command
    left, right = stimulus.touched
    lights = [one.name for one in robot.light.sensors] if robot.light else []
    return {
        "seq": sample.seq,
        "time_s": sample.time_ns / 1e9,
        "sonars": dict(zip((one.name for one in robot.sonars), stimulus.sonars, strict=True)),
        "touched": {"left": left, "right": right},
        "lights": dict(zip(lights, stimulus.lights, strict=True)),
        "state": state,
        "recorded": sample.state is not None,
        **dict(zip(_situations(robot), _names(robot, state), strict=True)),
        "command": command,
        "movement": None if command is None else str(COMMANDS[robot.role][command]),
        "latency_us": None if sample.latency_ns is None else sample.latency_ns / 1e3,
        "reading": stimulus.text(),
    }


def _names(robot: Robot, state: int) -> tuple[str, ...]:
    """Return a state in words: a predator's two situations, what a prey reacts to."""
    if robot.role is Role.PREDATOR:
        obstacle, target = situations_of(state)
        return situation_name(obstacle, "object"), situation_name(target, "target")
    return (prey_reason(state, [one.name for one in robot.sonars]) or f"state_{state}",)


def _cells(row: dict[str, Any], robot: Robot) -> list[str]:
    touch = "".join(
        letter if bent else "-" for letter, bent in zip("LR", row["touched"].values(), strict=True)
    )
    state = str(row["state"]) if row["recorded"] else f"({row['state']})"
    return [
        str(row["seq"]),
        f"{row['time_s']:.3f}",
        *map(str, row["sonars"].values()),
        touch,
        *map(str, row["lights"].values()),
        *(row[name] for name in _situations(robot)),
        state,
        row["movement"] or "-",
    ]
