"""`cgagen calibrate`: measurements into a robot file."""

import sys
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cgagen.verbs.console import Console, with_console
from cgagen.verbs.named_file import GenomeType
from cgagen.verbs.written import OUTPUT, check, in_folder

if TYPE_CHECKING:
    from cgagen.calibrate import Calibration, Effect
    from cgagen.robot import Robot

TYPED = "-"


@click.command("calibrate")
@click.argument("tables", metavar="FILE...", nargs=-1, required=True)
@click.option("--robot", required=True, metavar="NAME|FILE", help="The robot as it was.")
@click.option(
    "-o",
    "--output",
    type=OUTPUT,
    metavar="FILE",
    help="The robot file to write. Default: none, only say what would be in it.",
)
@click.option("--date", default="", metavar="TEXT", help="When it was measured, for the comments.")
@click.option(
    "--genome",
    type=GenomeType(),
    metavar="FILE",
    help="Say what the numbers do to this genome's capture rate.",
)
@click.option("--opponent", metavar="NAME|FILE", help="The other robot. Default: the one shipped.")
@click.option("--arena", default="colony", show_default=True, help="Name or file.")
@click.option("--force", is_flag=True, help="Overwrite the output.")
@with_console
def calibrate_verb(
    console: Console,
    tables: tuple[str, ...],
    robot: str,
    output: Path | None,
    date: str,
    genome: Path | None,
    opponent: str | None,
    arena: str,
    force: bool,
) -> None:
    r"""Turn measurements into a robot file, with mean, spread and count beside each number.

    A FILE is a table of comma-separated values, `-` one that is typed. Movements: repeats of some
    gait cycles, with distance along and to the right of the heading before, and turn, counter-
    clockwise positive. Sensors: the count that the chip measured (`cgagen robot sensors`) with the
    other end at a marked distance; light sensors are light_left and light_right.

    \b
      movement,cycles,along_in,right_in,turn_deg      sensor,distance_in,count
      FORWARD,5,12.1,0.1,-7                           front,24,4425
      FORWARD,5,11.8,0.0,-8                           light_left,24,430

    `_cm` or `_mm` may stand for `_in`. Movements that do not fit their mirror image or their
    inverse, repeats far from the others, and sensors that differ are pointed out.
    """
    from cgagen.bench_protocol import plain
    from cgagen.calibrate import calibrate, read_measurements
    from cgagen.robot import load_arena, load_robot

    if not date.isprintable():
        raise click.UsageError("--date: one line of text is wanted")
    body, field = load_robot(robot), load_arena(arena)
    output = in_folder(output, f"{plain(body.name)}.toml") if output is not None else None
    _check_output(output, [*tables, robot, arena, opponent, genome], force)
    texts = {("typed" if name == TYPED else name): _text_of(name) for name in tables}
    found = calibrate(body, robot, read_measurements(body, texts), field.units_per_in, date)
    effects = None
    if genome is not None:
        effects = _effects(genome, opponent, (body, found.robot), field)
    if output is not None:
        from cgagen.files import write_text

        write_text(output, found.text)
    console.result(_data(found, effects, output), _text(found, effects, output))


def _text_of(name: str) -> str:
    from cgagen.inputs import MEASUREMENTS, decoded, read_stream, read_text

    if name != TYPED:
        return read_text(name, MEASUREMENTS)
    return decoded(read_stream(sys.stdin.buffer, name, MEASUREMENTS), name, MEASUREMENTS)


def _check_output(output: Path | None, inputs: Iterable[Path | str | None], force: bool) -> None:
    """Refuse to write over any robot: it may have taken weeks."""
    from cgagen.outputs import never

    if output is not None:
        read = [Path(name) for name in inputs if name not in (None, TYPED)]
        check([(output, never("a robot"))], read, force)


def _effects(
    genome: Path, opponent: str | None, robots: "tuple[Robot, Robot]", arena: Any
) -> "tuple[Effect, Effect]":
    """Return how the genome does with the robot as it was, and as it was measured."""
    from cgagen.calibrate import effect_of
    from cgagen.genome import check_interface, load
    from cgagen.robot import load_robot
    from cgagen.words import Role

    before, after = robots
    role = Role.PREY if before.role is Role.PREDATOR else Role.PREDATOR
    other = load_robot(opponent or f"servobot-{role}", role=role)
    predator = before if before.role is Role.PREDATOR else other
    table = load(genome)
    check_interface(table, predator.name, predator.interface, predator.digest)
    return effect_of(table, before, other, arena), effect_of(table, after, other, arena)


def _text(
    found: "Calibration", effects: "tuple[Effect, Effect] | None", output: Path | None
) -> str:
    lines = ["{:<22}{:>10}{:>10}{:>8}".format("one gait cycle", "mean", "spread", "repeats")]
    row = "{:<22}{:>10.3f}{:>10}{:>8}"
    for movement, one in found.movements.items():
        for name, value in one._asdict().items():
            spread = "-" if value.spread is None else f"{value.spread:.3f}"
            lines.append(row.format(f"{movement} {name}"[:22], value.mean, spread, value.repeats))
    if not found.movements:
        lines = []
    if found.us_per_in is not None:
        lines.append(f"sound: {found.us_per_in.mean:.3f} us per inch, {found.us_per_in.mark()}")
    for name, curve in found.curves.items():
        points = ", ".join(f"{count} at {distance:g} in" for distance, count in curve.points)
        lines.append(f"lamp, {name}: {points}")
    lines += [f"warning: {warning}" for warning in found.warnings]
    if effects is not None:
        before, after = effects
        lines += [
            "",
            "{:<24}{:>10}{:>10}".format("from the 100 fixed starts", "before", "after"),
            f"{'fitness':<24}{before.fitness:>11.1f}{after.fitness:>10.1f}",
            f"{'captured':<24}{before.captured:>11.0%}{after.captured:>10.0%}",
        ]
    lines.append(f"\nrobot file: {output}" if output else "\nnothing written; give -o FILE")
    return "\n".join(lines)


def _data(
    found: "Calibration", effects: "tuple[Effect, Effect] | None", output: Path | None
) -> dict[str, Any]:
    return {
        "robot": found.robot.digest,
        "output": str(output) if output else None,
        "movements": {
            str(movement): {name: value._asdict() for name, value in one._asdict().items()}
            for movement, one in found.movements.items()
        },
        "us_per_in": found.us_per_in._asdict() if found.us_per_in else None,
        "curves": {
            name: [list(point) for point in curve.points] for name, curve in found.curves.items()
        },
        "warnings": list(found.warnings),
        "effect": dict(zip(("before", "after"), (e._asdict() for e in effects), strict=True))
        if effects
        else None,
    }
