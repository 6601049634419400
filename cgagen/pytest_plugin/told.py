"""What the terminal says of trials."""

from collections.abc import Iterable, Mapping
from typing import Any

NOT_TRIED = "NOT TRIED"
"""Of a test that was skipped, or a chip that was not asked: the whole is UNPROVEN then."""


def told(robot: Mapping[str, Any], level: str, seed: int) -> list[str]:
    """Return a line for each trial of a robot's data."""
    genome = (robot["genome"] or robot["robot"])[:8]
    main = robot["images"]["main"][:8]
    return [
        f"{NOT_TRIED} {robot['name']}, {name}: {trial['reason']}"
        if trial["verdict"] == NOT_TRIED
        else f"{trial['verdict']} {robot['name']} on {trial['target']}: {trial['decisions']} "
        f"decisions, level {level}, seed {seed}, image {main}, genome {genome}"
        + (f", {trial['stale']} stale" if trial["stale"] else "")
        + (f", {trial['left_out']} left out" if trial["left_out"] else "")
        + (f"; {trial['note']}" if trial["note"] else "")
        for name, trial in sorted(robot["trials"].items())
    ]


def chips_not_asked(robots: Iterable[Mapping[str, Any]]) -> list[str]:
    """Return the line that says that the whole is not proven, where chips were not asked."""
    rows = [row for robot in robots for row in robot["trials"].values()]
    count = sum(row["verdict"] == NOT_TRIED for row in rows)
    return [f"UNPROVEN: {count} of what was to be shown was not tried"] if count else []
