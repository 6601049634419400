"""`cgagen robot`: a robot on the bench, worked through its programming ports."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cgagen.verbs.console import Console, with_console
from cgagen.verbs.monitor import PORT_HELP
from cgagen.verbs.words import Verbs, Words
from cgagen.verbs.written import OUTPUT, in_folder
from cgagen.words import Movement

if TYPE_CHECKING:
    from cgagen.bench_protocol import Banner
    from cgagen.link.bench_hook import BenchHook
    from cgagen.monitor.readings import Readings

TABLE_READINGS = 10
"""Readings of a marked distance, where nothing else is said. Choice."""

PORT = click.option("--port", default="auto", show_default=True, metavar="PORT", help=PORT_HELP)
RESET = click.option("--reset", is_flag=True, help="Reset the Stamp by DTR first.")
ROBOT = click.option("--robot", metavar="NAME|FILE", help="Default: the one its banner names.")


@click.group("robot", cls=Verbs)
def robot_verb() -> None:
    """Work a robot on the bench: centre its servos, walk a movement, read its sensors.

    `centre` and `move` want the locomotion controller's port, `sensors` the main controller's. A
    Stamp listens for half a second after a reset, so press its button, or give --reset.
    """


@robot_verb.command("centre")
@PORT
@RESET
@with_console
def centre_verb(console: Console, /, port: str, reset: bool) -> None:
    """Put all legs down and straight out, and hold them there.

    The time to put the horns on the servos, and to find [servo.trim_counts] of the robot's file.
    The robot stays so until it is reset.
    """
    with _hook(port, reset) as hook:
        banner = _locomotion(hook)
        hook.centre()
    console.result(
        {"robot": banner.robot, "centred": True},
        f"{banner.robot}: all twelve servos are centred, and stay so until a reset",
    )


@robot_verb.command("move")
@click.argument(
    "movement", metavar="MOVEMENT", type=Words(tuple(map(str, Movement)), case_sensitive=False)
)
@click.option("--cycles", type=click.IntRange(1, 1_000), default=1, show_default=True)
@PORT
@RESET
@ROBOT
@with_console
def move_verb(
    console: Console, /, movement: str, cycles: int, port: str, reset: bool, robot: str | None
) -> None:
    """Walk some gait cycles of a MOVEMENT, and stand still again.

    Mark the place before, and measure: a line for `cgagen calibrate` is printed.
    """
    from cgagen.verbs.emulated_port import robot_behind

    with _hook(port, reset) as hook:
        banner = _locomotion(hook)
        command = _command(movement, hook.port, banner, robot or robot_behind(port))
        for cycle in range(1, cycles + 1):
            console.note(f"{movement}: cycle {cycle} of {cycles}")
            hook.move(command)
    row = f"{movement},{cycles},along,right,turn"
    console.result(
        {"robot": banner.robot, "movement": movement, "command": command, "cycles": cycles},
        f"{banner.robot}: walked {movement} {cycles} times, and stands\n"
        f"for calibrate: movement,cycles,along_in,right_in,turn_deg\n               {row}",
    )


@robot_verb.command("sensors")
@PORT
@RESET
@ROBOT
@click.option("--readings", type=click.IntRange(1, 100_000), help="Stop after so many.")
@click.option("--sensor", metavar="NAME", help="With --table: the sensor that faces the mark.")
@click.option("--distance", type=click.FloatRange(0), metavar="IN", help="Likewise: how far it is.")
@click.option(
    "--table",
    type=OUTPUT,
    metavar="FILE",
    help="Add a line for each reading to a table for `cgagen calibrate`.",
)
@with_console
def sensors_verb(console: Console, /, port: str, robot: str | None, **given: Any) -> None:
    """Show what the sensors of a robot count, decision by decision; Ctrl-C ends it.

    The main controller senses as it always does, so its robot walks: switch the locomotion
    controller off, or put the robot on a stand. The robot's file must have `telemetry = true`.
    """
    from cgagen.monitor import Decoder
    from cgagen.monitor.readings import Readings, decisions, sensor_names
    from cgagen.robot import load_robot
    from cgagen.verbs.emulated_port import robot_behind

    if given["table"]:
        given["table"] = in_folder(given["table"], "marks.csv")
        _check_table(given["table"])
    limit = given["readings"] or (TABLE_READINGS if given["table"] else None)
    named = robot or robot_behind(port)
    decoder = Decoder(load_robot(named) if named else None)
    found: Readings | None = None
    with _port(port, given["reset"]) as (name, wire):
        try:
            for line, said in decisions(name, wire, decoder):
                if found is None:
                    _refuse_unknown(given["sensor"], sensor_names(decoder.robot))
                    found = Readings(decoder.robot)
                found.add(said)
                console.note(line.text)
                if found.decisions == limit:
                    break
        except KeyboardInterrupt:
            console.note("")
    if given["table"] and found is not None:
        _append(given["table"], given["sensor"], given["distance"], found)
    console.result(_data(found), _text(found))


@contextmanager
def _hook(port: str, reset: bool) -> "Iterator[BenchHook]":
    """Open the conversation with a locomotion controller, and say hello."""
    from cgagen.errors import RigError
    from cgagen.link.bench_hook import BenchHook
    from cgagen.verbs.emulated_port import named_port

    with named_port(port, "locomotion") as name, BenchHook(name) as hook:
        if reset:
            hook.enter()
        else:
            try:
                hook.hello()
            except RigError as error:
                raise type(error)(f"{error} (--reset does that by DTR)") from error
        yield hook


def _locomotion(hook: "BenchHook") -> "Banner":
    """Return who answers; it has to be a locomotion controller."""
    from cgagen.errors import IdentityError

    banner = hook.greeting or hook.banner()
    if banner.chip != "locomotion":
        raise IdentityError(
            f"{hook.port}: the {banner.chip} controller is behind it; give the locomotion "
            "controller's port"
        )
    return banner


def _command(movement: str, port: str, banner: "Banner", robot: str | None) -> int:
    """Return the command for a movement of the robot at hand."""
    from cgagen.monitor.readings import refuse_other_robot
    from cgagen.robot import load_robot, shipped
    from cgagen.words import COMMANDS

    if robot is None and banner.robot not in shipped("robot"):
        raise click.UsageError(
            f"--robot: {banner.robot} does not ship with cgagen; give its file, which says whether "
            "it is a predator or a prey"
        )
    body = load_robot(robot or banner.robot)
    refuse_other_robot(port, banner.robot, body)
    commands = COMMANDS[body.role]
    if movement not in commands:
        raise click.UsageError(
            f"MOVEMENT: a {body.role} cannot {movement}; it can {', '.join(commands)}"
        )
    return commands.index(Movement(movement))


@contextmanager
def _port(name: str, reset: bool) -> "Iterator[tuple[str, Any]]":
    """Open a port under its lock."""
    from cgagen.link.port import locked_port, reset_by_dtr
    from cgagen.verbs.emulated_port import named_port

    with named_port(name, "main") as chosen, locked_port(chosen) as wire:
        if reset:
            reset_by_dtr(chosen, wire)
        yield chosen, wire


def _refuse_unknown(sensor: str | None, names: tuple[str, ...]) -> None:
    if sensor is not None and sensor not in names:
        raise click.UsageError(f"--sensor: {sensor} is not one of {', '.join(names)}")


def _append(path: Path, sensor: str, distance_in: float, found: "Readings") -> None:
    """Add lines to a table, with its header where it is new."""
    from cgagen.calibrate import HEADERS
    from cgagen.files import write_bytes
    from cgagen.inputs import MEASUREMENTS, read_bytes
    from cgagen.places import place_of

    rows = [f"{sensor},{distance_in:g},{count}" for count in found.counts(sensor)]
    before = b""
    if place_of(path).is_file_already:
        before = read_bytes(path, MEASUREMENTS).rstrip(b"\r\n") + b"\n"
    lines = rows if before else [HEADERS[1], *rows]
    write_bytes(path, before + "".join(line + "\n" for line in lines).encode())


def _check_table(path: Path) -> None:
    """Refuse to add lines to what is no table of a sensor's counts."""
    from cgagen.calibrate import HEADERS
    from cgagen.errors import FolderError
    from cgagen.inputs import MEASUREMENTS, read_text
    from cgagen.places import place_of

    if place_of(path).is_file_already:
        lines = [line for line in read_text(path, MEASUREMENTS).splitlines() if line.strip()]
        header = next((line for line in lines if not line.lstrip().startswith("#")), HEADERS[1])
        if [cell.strip() for cell in header.split(",")] != HEADERS[1].split(","):
            raise FolderError(
                f"{path}: its first line is not {HEADERS[1]}, so no counts are added to it; "
                "choose another name"
            )


def _text(found: "Readings | None") -> str:
    if found is None:
        return "no decision was heard"
    lines = ["{:<14}{:>8}{:>10}{:>8}".format("sensor", "least", "mean", "most")]
    for name in found.names:
        seen = found.seen(name)
        lines.append(f"{name:<14}{seen.low:>8}{seen.mean:>10.1f}{seen.high:>8}")
    touched = ", ".join(f"{side} {count}" for side, count in found.touched.items())
    lines.append(f"decisions: {found.decisions}; antennas touched: {touched}")
    return "\n".join([*lines, *(f"note: {note}" for note in found.notes)])


def _data(found: "Readings | None") -> dict[str, Any]:
    if found is None:
        return {"decisions": 0}
    return {
        "decisions": found.decisions,
        "sensors": {name: found.seen(name)._asdict() for name in found.names},
        "touched": found.touched,
        "notes": found.notes,
    }
