"""`cgagen build`: the programs of both Stamps."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cgagen.shell import command
from cgagen.verbs.console import Console, with_console
from cgagen.verbs.named_file import GenomeType

if TYPE_CHECKING:
    from cgagen.build import Build
    from cgagen.genome import Genome


@click.command("build")
@click.argument("genome", type=GenomeType(), required=False)
@click.option(
    "--robot",
    metavar="NAME|FILE",
    help="The robot: a name that ships with cgagen, or a TOML file. Default: the genome's.",
)
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="The build folder. Default: build/<name of the robot>.",
)
@click.option(
    "--templates",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Templates of yours; a file in here takes the place of ours of the same name.",
)
@click.option("--force", is_flag=True, help="Put the build into a folder that holds other things.")
@with_console
def build_verb(
    console: Console,
    genome: Path | None,
    robot: str | None,
    output: Path | None,
    templates: Path | None,
    force: bool,
) -> None:
    r"""Write and compile the programs of both Stamps of a robot.

    A predator is built from a GENOME, such as the best.genome of a run. A prey needs none:
    `cgagen build --robot servobot-prey`. The folder gets both sources, both EEPROM images, what
    they take of their chips, the wiring, and the genome and the robot that they come from. The
    same genome, robot and templates give the same bytes.

    \b
    Environment:
      CGAGEN_NODE       the Node program to use, before PATH
      CGAGEN_TOKENIZER  the tokenizer's index.js to use, instead of the cache
    """
    from cgagen.bench_protocol import plain
    from cgagen.build import check_build_folder, make_build, write_build
    from cgagen.genome import Standing, load, origin_text
    from cgagen.robot import load_robot
    from cgagen.tokenizer import Tokenizer
    from cgagen.verbs.robot_choice import robot_of

    if genome is None and robot is None:
        raise click.UsageError("give a genome, or with --robot a prey, which needs none")
    table = load(genome) if genome else None
    body = robot_of(console, table, genome, robot) if table and genome else load_robot(robot or "")
    folder = output or Path("build") / plain(body.name)
    read = [one for one in (genome, Path(robot) if robot else None) if one is not None]
    check_build_folder(folder, force, inputs=read)
    with Tokenizer(warn=console.note) as tokenizer:
        build = make_build(body, table, tokenizer, templates)
    for note in build.firmware.notes:
        console.note(f"note: {note}")
    if table and table.standing is Standing.EDITED:
        console.note(f"note: {genome}: {origin_text(table)}")
    files = build.files()
    write_build(folder, files, force)
    more = "" if console.quiet else f"\n{_next(folder, build)}"
    console.result(_data(folder, build, files), _text(folder, build) + more)


def _data(folder: Path, build: "Build", files: dict[str, bytes]) -> dict[str, Any]:
    import json

    from cgagen.build.record import RECORD_FILE

    return {"folder": str(folder), "note": build.note, "build": json.loads(files[RECORD_FILE])}


def _text(folder: Path, build: "Build") -> str:
    lines = [f"{build.robot.name}: {folder}", ""]
    head = ("program", "chip", "EEPROM used", "free", "RAM free", "calls", "source", "image")
    row = "{:<16}{:<7}{:>11}{:>14}{:>10}{:>7}  {:<10}{:<8}"
    lines.append(row.format(*head).rstrip())
    for built in build.programs:
        memory, source = built.memory, built.program.banner.source
        used = memory.program_bytes + memory.data_bytes
        free = f"{memory.free_bytes} ({memory.free_percent:.1f} %)"
        cells = (built.program.file, memory.model, used, free, memory.ram_free_bytes)
        lines.append(row.format(*cells, memory.gosub_depth, source, built.image.digest[:8]))
    lines += [
        "",
        _genome_text(build.genome) if build.genome else "genome: none, it acts by reflex",
        f"robot:  {build.robot.digest}",
    ]
    return "\n".join(lines)


def _genome_text(genome: "Genome") -> str:
    """Return a genome's digest, and whether its origin is that of other bits."""
    from cgagen.genome import Standing, origin_text

    edited = f" ({origin_text(genome)})" if genome.standing is Standing.EDITED else ""
    return f"genome: {genome.digest}{edited}"


def _next(folder: Path, build: "Build") -> str:
    """Return what to type next, and what to do with one's hands."""
    from cgagen.build.record import WIRING_FILE

    main, locomotion = (built.program for built in build.programs)
    return "\n".join(
        [
            "",
            "memory.txt says what each routine takes; build.json has every digest.",
            f"Wire the Stamps as {folder / WIRING_FILE} says.",
            f"next:   {command('verify', '--build', folder)}",
            f"next:   {command('flash', folder)}  # {main.file} into the {main.model}, "
            f"{locomotion.file} into the {locomotion.model}",
        ]
    )
