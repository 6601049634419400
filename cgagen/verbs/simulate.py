"""`cgagen simulate`: one episode, step by step, as the paper's simulator showed it."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cgagen.errors import MismatchError
from cgagen.verbs.console import Console, with_console
from cgagen.verbs.world_options import load_hunter, world_options

if TYPE_CHECKING:
    from hil.hunt import Hunt
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
@click.argument("genome", type=click.Path(path_type=Path))
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
    """
    from sim.episode import play_episode
    from sim.model import words_of
    from sim.numbers import world_numbers
    from sim.starts import start_of

    _check_emulated(given)
    loaded, predator, prey, arena, options = load_hunter(
        genome, given["robot"], given, console.note
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
    data = {
        "genome": loaded.digest,
        "robot": predator.name,
        "captured_at_step": caught,
        "steps": [_data(step) for step in episode],
    }
    end = f"captured at step {caught}" if caught else f"not captured in {given['steps']} steps"
    hunt = None
    if given["emulated"]:
        hunt = _emulated(console, given, (loaded, predator, prey), numbers, start)
        data["emulated"] = _verdict(hunt)
        end = f"{end}\nfour emulated Stamps: {_verdict_text(hunt)}"
    console.result(data, "\n".join([_HEADER, *(_line(step) for step in episode), end]))
    if hunt is not None and hunt.difference is not None:
        raise MismatchError(f"{given['build'] or genome}: {hunt.difference.text()}")


_IN_FIRMWARE = ("masking", "light", "prey_policy")


def _check_emulated(given: dict[str, Any]) -> None:
    """Refuse what the firmware cannot know."""
    if given["build"] and not given["emulated"]:
        raise click.UsageError("--build is for --emulated; give both")
    if not given["emulated"]:
        return
    if given["past_capture"]:
        raise click.UsageError(
            "--emulated ends with the capture, after which the simulator holds both robots and "
            "the firmware does not; leave out --past-capture"
        )
    for name in _IN_FIRMWARE:
        if given[name] is not None:
            raise click.UsageError(
                f"--emulated: {name.replace('_', ' ')} is in the firmware, which is built from "
                "the robot's file; change it there and pass the file"
            )


def _emulated(
    console: Console, given: dict[str, Any], parts: Any, numbers: Any, start: Any
) -> "Hunt":
    """Build what has to be built, and hunt with it."""
    from cgagen.build import make_build
    from cgagen.tokenizer import Tokenizer
    from hil.hunt import hunt
    from hil.subject import read_subject, subject_of

    genome, predator, prey = parts
    folder = given["build"]
    with Tokenizer() as tokenizer:
        hunter = (
            read_subject(folder)
            if folder
            else subject_of(make_build(predator, genome, tokenizer), predator.name)
        )
        hunted = subject_of(make_build(prey, None, tokenizer), prey.name)
    console.note("emulating four Stamps: about a fifth of a second for a step")
    return hunt(hunter, hunted, numbers, start, given["steps"], genome)


def _verdict(hunt: "Hunt") -> dict[str, Any]:
    return {
        "steps": len(hunt.steps),
        "captured_at_step": hunt.captured_at,
        "robot_time_ms": hunt.steps[-1].time_ns // 1_000_000 if hunt.steps else None,
        "difference": hunt.difference and hunt.difference.text(),
    }


def _verdict_text(hunt: "Hunt") -> str:
    if hunt.difference is not None:
        return f"differ at step {hunt.difference.step}"
    seconds = hunt.steps[-1].time_ns / 1e9
    return f"{len(hunt.steps)} steps, all equal, in {seconds:.1f} s of the robots' time"


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
