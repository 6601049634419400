"""The options that several verbs share: which world an episode is played in."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from cgagen.robot import Arena, Robot
    from sim.numbers import Options

F = Callable[..., Any]

_PLAYERS = (
    click.option("--opponent", default="servobot-prey", show_default=True, help="Name or file."),
    click.option("--arena", default="colony", show_default=True, help="Name or file."),
)
_OPEN_POINTS = (
    click.option("--hold/--go-on", default=None, help="After a capture: stay, or go on hunting."),
    click.option("--masking/--no-masking", default=None, help="Ignore sonars facing the target."),
    click.option("--light", type=click.Choice(["dark", "ambient"]), help="How far the lamp shows."),
    click.option("--prey-policy", metavar="NAME", help="A policy of the opponent's file."),
    click.option("--walls", type=click.Choice(["slide", "stop"]), help="What a wall does."),
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
        load_robot(given["opponent"], role=Role.PREY),
        load_arena(given["arena"]),
        Options(**open_points(given)),
    )


def note_compiling(note: Callable[[str], None]) -> None:
    """Say that the first call on a machine takes longer, where this is the first."""
    from sim.jit import is_compiled

    if not is_compiled():
        note("compiling the world step, once on this machine: some ten seconds")


def load_hunter(
    path: Any, robot: str | None, given: dict[str, Any], note: Callable[[str], None]
) -> Any:
    """Load a genome and the world of its robot.

    Args:
        path: the genome's file.
        robot: another robot than the genome's, or None.
        given: the values of `world_options`.
        note: told where the robot is not the one the genome evolved on.

    Returns:
        The genome, the predator, the prey, the arena and the options.

    Raises:
        GenomeError: no genome, or for another kind of robot.
        RobotError: as of `load_world`.
    """
    from cgagen.errors import GenomeError
    from cgagen.genome import check_interface, load
    from cgagen.robot import shipped

    genome = load(path)
    if robot is None and genome.robot not in shipped("robot"):
        raise GenomeError(
            f"{path}: robot: {genome.robot!r} does not ship with cgagen; "
            "pass its file with --robot FILE"
        )
    parts = load_world(robot or genome.robot, given)
    predator = parts[0]
    said = check_interface(genome, predator.name, predator.interface, predator.digest)
    if said:
        note(said)
    note_compiling(note)
    return genome, *parts
