"""Capture rates: the simulator's, of robots each in its own time, and of robots on three lines.

`python -m hil.rates` builds what has to be built, plays the fixed starts, and prints a table. It
states how far robots and simulator part; nothing of it passes or fails.
"""

import re
import sys
from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from statistics import median

import click

from cgagen.build import make_build
from cgagen.robot import Robot, load_arena
from cgagen.robot.reader import parse_robot
from cgagen.tokenizer import Tokenizer
from hil.hunt import fixed_starts
from hil.parting import Parting, part
from hil.subject import Subject, read_subject, subject_of
from sim.numbers import world_numbers

FIRMWARE = Path(__file__).parent.parent / "firmware"
STARTS, STEPS = 20, 200
"""Of the fixed starts, and movements of the predator at most. Choice; the paper's steps."""

FOUR, THREE = "with a step line", "on three lines"
_STEP_LINE = re.compile(r"^step_line\s*=\s*\{[^}]*\}", re.M)


def on_three_lines(robot: Robot) -> Robot:
    """Return the robot as its file says it without a step line.

    >>> from cgagen.robot import load_robot
    >>> on_three_lines(load_robot("servobot-prey")).link.step_line is None
    True
    """
    if robot.link.step_line is None:
        return robot
    return parse_robot(_STEP_LINE.sub('step_line = "none"', robot.text), robot.name)


def freed(subject: Subject, tokenizer: Tokenizer) -> Subject:
    """Return a robot built anew for three lines."""
    build = make_build(on_three_lines(subject.robot), subject.genome, tokenizer)
    return subject_of(build, f"{subject.where}, {THREE}")


@dataclass(frozen=True, slots=True)
class Rates:
    """What came of some hunts.

    Attributes:
        partings: one of each start.
        steps: movements of the predator at most.
    """

    partings: tuple[Parting, ...]
    steps: int

    def rows(self) -> list[tuple[str, str]]:
        """Return words and figures of a table."""
        hunts = self.partings
        both = [one for one in hunts if one.simulated_at and one.captured_at]
        farthest = sorted(one.farthest_units for one in hunts)
        rows = [
            ("starts", str(len(hunts))),
            ("movements at most", str(self.steps)),
            ("captured by the simulator", _share(one.simulated_at for one in hunts)),
            ("captured by the robots", _share(one.captured_at for one in hunts)),
            ("captured by both", f"{len(both)}"),
            ("decisions alike at first, median", f"{median(one.decided_alike for one in hunts):g}"),
            (
                "farthest apart after as many movements, median and most",
                f"{median(farthest):.0f} and {farthest[-1]:.0f} units",
            ),
        ]
        if both:
            ratio = median((one.captured_at or 0) / (one.simulated_at or 1) for one in both)
            rows.append(("movements to the capture, robots by simulator, median", f"{ratio:.2f}"))
        troubles = [one.trouble for one in hunts if one.trouble]
        return [*rows, *(("trouble", one) for one in troubles)]

    def text(self) -> str:
        """Return the table."""
        return "\n".join(f"  {words:<56}  {figure}" for words, figure in self.rows())


def _share(captures: Iterable[int | None]) -> str:
    listed = list(captures)
    caught = sum(one is not None for one in listed)
    return f"{caught} ({100 * caught / len(listed):.0f} %)"


@cache
def _subjects(kind: str) -> tuple[Subject, Subject]:
    predator, prey = (read_subject(FIRMWARE / role) for role in ("predator", "prey"))
    if kind == FOUR:
        return predator, prey
    with Tokenizer() as tokenizer:
        return freed(predator, tokenizer), freed(prey, tokenizer)


def play(kind: str, number: int, steps: int) -> Parting:
    """Play one of the fixed starts with the reference robots, with or without a step line."""
    predator, prey = _subjects(kind)
    arena = load_arena("colony")
    numbers = world_numbers(predator.robot, prey.robot, arena)
    starts = fixed_starts(predator, prey, numbers, arena.start_gap_units, number + 1)
    result = part(predator, prey, numbers, starts[number : number + 1], steps)
    return result if not result.trouble else replace(result, trouble=f"{number}: {result.trouble}")


def rates(kind: str, numbers: Sequence[int], steps: int, workers: int = 1) -> Rates:
    """Play some of the fixed starts.

    Args:
        kind: `FOUR` or `THREE`.
        numbers: of the starts, from 0.
        steps: movements of the predator at most.
        workers: processes.
    """
    count = len(numbers)
    if workers == 1:
        return Rates(tuple(play(kind, number, steps) for number in numbers), steps)
    with ProcessPoolExecutor(workers) as pool:
        return Rates(tuple(pool.map(play, [kind] * count, numbers, [steps] * count)), steps)


@click.command()
@click.option("--starts", type=click.IntRange(1, 100), default=STARTS, show_default=True)
@click.option("--steps", type=click.IntRange(1, 10_000), default=STEPS, show_default=True)
@click.option("--workers", type=click.IntRange(1, 64), default=2, show_default=True)
def main(starts: int, steps: int, workers: int) -> None:
    """Play the first fixed starts without referee and print how far robots and simulator part."""
    for kind in (FOUR, THREE):
        found = rates(kind, range(starts), steps, workers)
        click.echo(f"the reference robots {kind}, without referee\n{found.text()}\n")
    sys.exit(0)


if __name__ == "__main__":
    main()
