"""`cgagen simulate`: one episode, step by step, as the paper's simulator showed it."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cgagen.errors import MismatchError
from cgagen.verbs.console import Console, with_console
from cgagen.verbs.named_file import GenomeType
from cgagen.verbs.robot_choice import IN_FIRMWARE
from cgagen.verbs.simulate_emulated import emulated
from cgagen.verbs.world_options import load_hunter, world_options

if TYPE_CHECKING:
    from sim.episode import Step

FIGURE_7 = ("268.75,31.25,180", "15,150,90")
"""The paper's test: 10 in from both walls of the south-east corner, heading west; the middle of
the west wall, heading north. Ref: S1 IV and figure 7."""


class PoseType(click.ParamType[tuple[float, float, float]]):
    """X,Y,DEG: two coordinates in arena units and a heading in degrees."""

    name = "X,Y,DEG"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[float, float, float]:
        """Return three finite numbers, or a usage error."""
        if isinstance(value, tuple):
            return value
        try:
            x, y, heading = (float(part) for part in str(value).split(","))
        except ValueError:
            self.fail(f"{value!r} is not X,Y,DEG, for example {FIGURE_7[0]}", param, ctx)
        if not all(abs(number) < 1e6 for number in (x, y, heading)):
            self.fail(f"{value!r}: three finite numbers are wanted", param, ctx)
        return x, y, heading


@click.command("simulate")
@click.argument("genome", type=GenomeType())
@click.option("--predator", type=PoseType(), default=FIGURE_7[0], show_default=True)
@click.option("--prey", type=PoseType(), default=FIGURE_7[1], show_default=True)
@click.option("--steps", type=click.IntRange(1, 100_000), default=100, show_default=True)
@click.option("--past-capture", is_flag=True, help="Play all steps, captured or not.")
@click.option("--robot", help="Another robot than the genome's: name or file.")
@click.option("--emulated", is_flag=True, help="Let the four Stamps hunt, too, and compare.")
@click.option(
    "--build",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="With --emulated: the predator's programs are this build's.",
)
@click.option("--no-referee", is_flag=True, help="With --emulated: each robot in its own time.")
@world_options
@with_console
def simulate_verb(console: Console, /, genome: Path, **given: Any) -> None:
    """Play one episode of GENOME and print what was sensed and decided at every step.

    The default poses are those of the paper's test (figure 7). A line is one gait cycle: the
    counts that the predator's chip measured, its two situations, the state, the movement that
    the genome answers with, and where both robots stand afterwards.

    With --emulated, the programs of predator and prey are built and run on four emulated Stamps
    from the same poses. Readings, decisions, the movements that the servos make, poses and the
    step of the capture have to be the simulator's; the first difference ends with exit code 9.
    For that a referee holds a finished robot until the other one has finished, too. With
    --no-referee, or where a robot has no step line, each walks in its own time, and how far they
    part from the simulator is told; that is no difference to fail for.
    """
    from sim.episode import play_episode
    from sim.model import words_of
    from sim.numbers import world_numbers
    from sim.starts import start_of

    loaded, predator, prey, arena, options, _ = load_hunter(
        genome,
        given["robot"],
        given,
        console.note,
        without=IN_FIRMWARE if given["emulated"] else (),
    )
    numbers = world_numbers(predator, prey, arena, options)
    start = start_of(
        given["predator"],
        given["prey"],
        numbers.side,
        (numbers.predator.radius, numbers.prey.radius),
    )
    words = words_of(loaded.array()[None, :])[:, 0].copy()
    episode = play_episode(words, start, given["steps"], numbers)
    caught = next((step.number for step in episode if step.captured), None)
    if caught and not given["past_capture"]:
        episode = episode[:caught]
    data: dict[str, Any] = {
        "genome": loaded.digest,
        "robot": predator.name,
        "captured_at_step": caught,
        "steps": [_data(step) for step in episode],
    }
    end = f"captured at step {caught}" if caught else f"not captured in {given['steps']} steps"
    difference = None
    if given["emulated"]:
        parts = loaded, predator, prey
        data["emulated"], told, difference = emulated(console, given, parts, numbers, start)
        end = f"{end}\nfour emulated Stamps: {told}"
    console.result(data, "\n".join([_HEADER, *(_line(step) for step in episode), end]))
    if difference is not None:
        raise MismatchError(f"{given['build'] or genome}: {difference}")


_HEADER = (
    "step   front right  left  touch  light L/R   obstacle     target        state  "
    "movement       predator (x, y, deg)  prey (x, y, deg)      dist   score"
)


def _line(step: "Step") -> str:
    from cgagen.words import situation_name

    reading = step.reading
    touch = ("L" if reading.touch_left else "-") + ("R" if reading.touch_right else "-")
    px, py, pd = step.predator
    qx, qy, qd = step.prey
    return (
        f"{step.number:4d}  {reading.front:6d}{reading.right:6d}{reading.left:6d}   {touch}   "
        f"{reading.light_left:5d}{reading.light_right:6d}   "
        f"{situation_name(step.obstacle, 'object'):13}"
        f"{situation_name(step.target, 'target'):13}"
        f"{step.state:5d}  {step.movement:14} ({px:5.1f},{py:6.1f},{pd:6.1f})  "
        f"({qx:5.1f},{qy:6.1f},{qd:6.1f})  {step.distance_units:6.1f}  {step.score:6.1f}"
    )


def _data(step: "Step") -> dict[str, Any]:
    from cgagen.words import situation_name

    return {
        "step": step.number,
        "reading": step.reading._asdict(),
        "obstacle": situation_name(step.obstacle, "object"),
        "target": situation_name(step.target, "target"),
        "state": step.state,
        "command": step.command,
        "movement": step.movement,
        "prey_reading": step.prey_reading._asdict(),
        "prey_command": step.prey_command,
        "prey_movement": step.prey_movement,
        "predator": step.predator,
        "prey": step.prey,
        "distance_units": step.distance_units,
        "score": step.score,
        "captured": step.captured,
    }
