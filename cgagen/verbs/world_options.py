"""The options that several verbs share: which world an episode is played in."""

from collections.abc import Callable, Collection
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from cgagen.verbs.robot_choice import left_out_text
from cgagen.verbs.words import Words

if TYPE_CHECKING:
    from cgagen.genome import Genome
    from cgagen.robot import Arena, Robot
    from cgagen.run import RunSettings
    from sim.numbers import Options

F = Callable[..., Any]

OPPONENT, ARENA = "servobot-prey", "colony"
_DEFAULT = "Default: that of a genome's run, or"

_PLAYERS = (
    click.option("--opponent", metavar="NAME|FILE", help=f"The prey. {_DEFAULT} {OPPONENT}."),
    click.option("--arena", metavar="NAME|FILE", help=f"{_DEFAULT} {ARENA}."),
)
_OPEN_POINTS = (
    click.option("--hold/--go-on", default=None, help="After a capture: stay, or go on hunting."),
    click.option("--masking/--no-masking", default=None, help="Ignore sonars facing the target."),
    click.option("--light", type=Words(["dark", "ambient"]), help="How far the lamp shows."),
    click.option("--prey-policy", metavar="NAME", help="A policy of the opponent's file."),
    click.option("--walls", type=Words(["slide", "stop"]), help="What a wall does."),
)


def world_options(function: F) -> F:
    """Give a verb --opponent, --arena and the world's open points, as keyword arguments."""
    for option in reversed(_PLAYERS + _OPEN_POINTS):
        function = option(function)
    return function


def open_points(given: dict[str, Any]) -> dict[str, Any]:
    """Return the world's options that were given, by the names of `sim.numbers.Options`."""
    hold = given["hold"]
    values = {
        "after_capture": None if hold is None else "hold" if hold else "go_on",
        "masking": given["masking"],
        "light": given["light"],
        "prey_policy": given["prey_policy"],
        "walls": given["walls"],
    }
    return {name: value for name, value in sorted(values.items()) if value is not None}


def load_world(robot: str, given: dict[str, Any]) -> "tuple[Robot, Robot, Arena, Options]":
    """Load what a world is made of.

    Args:
        robot: the predator, name or file.
        given: the values of `world_options`.

    Raises:
        RobotError: a file that cannot be, or two that do not fit.
    """
    from cgagen.robot import load_arena, load_robot
    from cgagen.words import Role
    from sim.numbers import Options

    return (
        load_robot(robot, role=Role.PREDATOR),
        load_robot(given["opponent"] or OPPONENT, role=Role.PREY),
        load_arena(given["arena"] or ARENA),
        Options(**open_points(given)),
    )


def note_compiling(note: Callable[[str], None]) -> None:
    """Say that the first call on a machine takes longer, where this is the first."""
    from sim.jit import is_compiled

    if not is_compiled():
        note("compiling the world step, once on this machine: some ten seconds")


class Hunter(NamedTuple):
    """A genome and the world that it hunts in; the first five are what an episode is made of."""

    genome: "Genome"
    predator: "Robot"
    prey: "Robot"
    arena: "Arena"
    options: "Options"
    settings: "RunSettings"


def load_hunter(
    path: Path,
    robot: str | None,
    given: dict[str, Any],
    note: Callable[[str], None],
    without: Collection[str] = (),
) -> Hunter:
    """Load a genome and its world: the run's that it lies in, but for what was named.

    Args:
        path: the genome's file.
        robot: another robot than the genome's, or None.
        given: the values of `world_options`.
        note: told where the robot is not the one the genome evolved on, and where the run's world
            is not the one that ships.
        without: options of the run's world that are the robot file's all the same.

    Raises:
        GenomeError: no genome, or for another kind of robot.
        RobotError: as of `load_world`.
        CgagenError: the run or build around the genome has been changed.
    """
    from cgagen.genome import check_interface, load
    from cgagen.robot import load_arena, load_robot
    from cgagen.run import RunSettings
    from cgagen.whose import match
    from cgagen.words import Role
    from sim.numbers import Options

    genome = load(path)
    predator, home, said = match(genome, path, robot)
    if predator.role is not Role.PREDATOR:
        load_robot(robot or predator.name, role=Role.PREDATOR)  # says what is wrong
    record = home.record if home else None
    prey, arena = (home.prey, home.arena) if home else (None, None)
    prey = (
        prey
        if prey and not given["opponent"]
        else load_robot(given["opponent"] or OPPONENT, role=Role.PREY)
    )
    arena = arena if arena and not given["arena"] else load_arena(given["arena"] or ARENA)
    of_run: dict[str, Any] = dict(record.settings.world) if record else {}
    left_out = sorted(of_run.keys() & set(without))
    of_run = {name: value for name, value in of_run.items() if name not in without}
    options = Options(**(of_run | open_points(given)))
    kept = _kept(of_run, prey, arena, given)
    for one in (
        check_interface(genome, predator.name, predator.interface, predator.digest) or said,
        f"the world is the run's: {', '.join(kept)}" if kept else None,
        left_out_text(left_out),
    ):
        if one:
            note(f"note: {one}")
    note_compiling(note)
    settings = record.settings if record else RunSettings()
    return Hunter(genome, predator, prey, arena, options, settings)


def _kept(
    of_run: dict[str, Any], prey: "Robot", arena: "Arena", given: dict[str, Any]
) -> list[str]:
    """Return what a run's world has that is not what one would have without the run."""
    from cgagen.robot import load_arena, load_robot

    words = []
    if not given["opponent"] and prey.digest != load_robot(OPPONENT).digest:
        words.append(f"its prey {prey.name}")
    if not given["arena"] and arena.digest != load_arena(ARENA).digest:
        words.append(f"its arena {arena.name}")
    named = open_points(given)
    words += [
        f"{name.replace('_', ' ')} {value}"
        for name, value in sorted(of_run.items())
        if name not in named
    ]
    return words
