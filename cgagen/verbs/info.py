"""`cgagen info`: what a file of ours is, in words."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cgagen.verbs.console import Console, with_console
from cgagen.verbs.info_folder import describe_build, describe_run
from cgagen.verbs.info_sorts import Sort, sort_of
from cgagen.verbs.rules import FREE, given_in, name_of
from cgagen.verbs.world_options import Hunter, load_hunter, world_options

if TYPE_CHECKING:
    from cgagen.genome import Genome

SHORT = {
    "FORWARD": "F",
    "BACKWARD": "B",
    "RIGHT_FORWARD": "RF",
    "LEFT_FORWARD": "LF",
    "ROTATE_RIGHT": "RR",
    "ROTATE_LEFT": "RL",
    "BACKUP_RIGHT": "BR",
    "BACKUP_LEFT": "BL",
}
"""Movements in two letters, so that 8 x 8 of them fit on a terminal."""

SAYING = {
    Sort.IMAGE: ("--model",),
    Sort.TRACE: ("--robot",),
    Sort.GENOME: tuple(one for one in FREE["info"] if one != "--model"),
}
"""Options that say something, by the sort of a file; of another sort none does."""


@click.command("info")
@click.argument("file", metavar="FILE|NAME", type=click.Path(path_type=Path))
@click.option("--robot", help="For a genome: another robot than its own, name or file.")
@click.option("--model", help="For an image: the chip that it is for, BS2 to BS2pe.")
@world_options
@with_console
def info_verb(console: Console, /, file: Path, model: str | None, **given: Any) -> None:
    """Describe any file or folder of ours, or a robot or an arena that ships, by its name.

    A genome is shown as its table of movements, with how often the 100 fixed starts of every
    run visit each state. States that are never visited are named: evolution could not see what
    their genes do. An image (*.bin) is listed as PBASIC that compiles to it again; its chip
    is known in a build folder, or where its source lies beside it, otherwise say --model.
    Runs, builds, robots, arenas, benches, sources, traces, tables, reports and what lies beside
    them are told in a few lines; what is none of ours, by what it seems to be.
    """
    sort = sort_of(file)
    _refuse_other_options(sort)
    match sort:
        case Sort.BUILD:
            describe_build(console, file)
        case Sort.BUILD_RECORD if file.name == "build.json":
            describe_build(console, file.parent)
        case Sort.RUN:
            describe_run(console, file)
        case Sort.RECORD if file.name == "0-run.toml":
            describe_run(console, file.parent)
        case Sort.ROBOT:
            _robot(console, file)
        case Sort.ARENA:
            _arena(console, file)
        case Sort.IMAGE:
            from cgagen.verbs.info_image import describe_image

            describe_image(console, file, model)
        case Sort.SOURCE:
            _source(console, file)
        case Sort.TRACE:
            from cgagen.verbs.trace import describe_trace

            describe_trace(console, file, given["robot"])
        case Sort.GENOME:
            _genome(console, file, given)
        case _:
            from cgagen.verbs.info_tables import describe

            told = describe(sort, file)
            kind = sort.name.lower()
            console.result({"kind": kind, "name": file.name, **told.data}, "\n".join(told.lines))


def _refuse_other_options(kind: Sort) -> None:
    """Refuse options that say nothing about a file of this kind.

    Raises:
        click.UsageError: the first of them.
    """
    context = click.get_current_context()
    allowed = {"FILE", "--json", *SAYING.get(kind, ())}
    own = [one for one in context.command.params if not (one.name or "").startswith("anywhere_")]
    for one in own:
        for name in map(name_of, [one, one], (False, True)):
            if name in given_in(context) - allowed:
                raise click.UsageError(f"{name} says nothing about {kind}; leave it out", context)


def _genome(console: Console, file: Path, given: dict[str, Any]) -> None:
    """Describe a genome: of itself, and what it does in its world where that can be had."""
    from cgagen.errors import RobotError
    from cgagen.genome import load

    try:
        hunter = load_hunter(file, given["robot"], given, console.note)
    except RobotError as error:  # a run of an older version: its genome is to be read all the same
        if given["robot"]:
            raise
        genome = load(file)
        console.note(f"note: {error}")
        console.result(_of_itself(genome), "\n".join(_bare_lines(file, genome)))
    else:
        _in_its_world(console, file, hunter)


def _of_itself(genome: "Genome") -> dict[str, Any]:
    """Return what a genome's file says, for JSON."""
    return {
        "kind": "genome",
        "robot": genome.robot,
        "digest": genome.digest,
        "origin": {"standing": str(genome.standing), **_said(genome)},
        "commands": genome.commands(),
    }


def _in_its_world(console: Console, file: Path, hunter: Hunter) -> None:
    from cgagen.run.streams import Purpose, stream
    from sim.episode import visits_of
    from sim.model import World, words_of

    genome, predator, prey, arena, options, settings = hunter
    world = World(predator, prey, arena, options, steps=settings.steps)
    generator = stream(settings.fixed_starts_seed, 0, 0, Purpose.FIXED_STARTS)
    starts = world.draw_starts(generator, settings.fixed_starts)
    words = words_of(genome.array()[None, :])
    _, caught = world.play(words, starts)
    visits = visits_of(words[:, 0].copy(), starts, settings.steps, world.numbers).tolist()
    captured = int((caught > 0).sum())
    data = _of_itself(genome) | {
        "visits": visits,
        "visited": sum(count > 0 for count in visits),
        "captured": captured,
        "starts": len(starts),
    }
    console.result(data, "\n".join(_genome_lines(file, genome, visits, captured, len(starts))))


def _said(genome: "Genome") -> dict[str, Any]:
    """Return what the file says of these bits, for JSON."""
    from dataclasses import asdict

    return {key: value for key, value in asdict(genome.evolved).items() if value}


def _genome_lines(
    file: Path, genome: "Genome", visits: list[int], captured: int, starts: int
) -> list[str]:
    """Return what is said of a genome.

    Args:
        file: that holds it.
        genome: the predator's.
        visits: how often each state was met from the fixed starts, 64 counts.
        captured: how many of those starts end in a capture.
        starts: how many there are.
    """
    met = sum(1 for count in visits if count)
    return [
        *_bare_lines(file, genome, visits),
        "The share is how often a state was met, up to the capture; - is never.",
        "",
        f"{captured} of {starts} fixed starts end in a capture.",
        f"{met} of {len(visits)} states are visited from the fixed starts; "
        f"{len(visits) - met} never are, and what their genes say was never tried:",
        *_never_met(visits),
    ]


def _bare_lines(file: Path, genome: "Genome", visits: list[int] | None = None) -> list[str]:
    """Return what is said of a genome in any case; `visits` as of `_genome_lines`, if known."""
    from cgagen.genome import Standing, origin_text

    facts = [f"{file.name}: a genome for {genome.robot}, digest {genome.digest[:8]}"]
    facts += [origin_text(genome)] if genome.standing is not Standing.NONE else []
    return [
        *facts,
        "",
        *_gene_rows(genome, visits),
        "",
        "   ".join(f"{short} {name}" for name, short in SHORT.items()),
    ]


def _gene_rows(genome: "Genome", visits: list[int] | None) -> list[str]:
    """Return the table of genes: a row an obstacle, a column a target."""
    from cgagen.words import COMMANDS, Role, Situation, situation_name, state_of

    commands, total = genome.commands(), max(sum(visits or ()), 1)
    rows = [" " * 13 + "".join(f"{situation_name(t, 'target'):>13}" for t in Situation)]
    for obstacle in Situation:
        row = f"{situation_name(obstacle, 'object'):13}"
        for target in Situation:
            state = state_of(obstacle, target)
            short = SHORT[COMMANDS[Role.PREDATOR][commands[state]]]
            share = f"{visits[state] / total:7.2%}" if visits and visits[state] else "      -"
            row += f"{short:>5} {share if visits is not None else ' ' * 7}"
        rows.append(row.rstrip())
    return rows


def _never_met(visits: list[int]) -> list[str]:
    """Return the states that were never met: a line an obstacle that has any."""
    from cgagen.words import Situation, situation_name, state_of

    lines = []
    for obstacle in Situation:
        missed = [
            situation_name(target, "target")
            for target in Situation
            if not visits[state_of(obstacle, target)]
        ]
        if missed:
            lines.append(f"  {situation_name(obstacle, 'object'):13} with {', '.join(missed)}")
    return lines


def _named(file: Path) -> str:
    """Return what a loader is to be told: a file that is there is meant before a name is."""
    return str(file.absolute()) if file.exists() else str(file)


def _robot(console: Console, file: Path) -> None:
    from cgagen.robot import load_robot
    from cgagen.robot.seal import seal_fits

    robot = load_robot(_named(file))
    fits = seal_fits(robot.text)
    data = {
        "kind": "robot",
        "name": robot.name,
        "role": robot.role,
        "interface": robot.interface,
        "digest": robot.digest,
        "calibrated": fits,
    }
    edited = "\nedited since it was calibrated: its comments may be of other numbers"
    text = (
        f"{file.name}: the {robot.role} {robot.name}, {robot.main.model} and "
        f"{robot.locomotion.model}, digest {robot.digest[:8]}\n"
        + robot.interface.replace("; ", "\n")
        + (edited if fits is False else "")
    )
    console.result(data, text)


def _arena(console: Console, file: Path) -> None:
    from cgagen.robot import load_arena

    arena = load_arena(_named(file))
    data = {"kind": "arena", "name": arena.name, "digest": arena.digest}
    text = (
        f"{file.name}: the arena {arena.name}, {arena.side_units:g} x {arena.side_units:g} "
        f"units of {1 / arena.units_per_in:g} in, digest {arena.digest[:8]}"
    )
    console.result(data, text)


def _source(console: Console, file: Path) -> None:
    from cgagen.memory import report
    from cgagen.shell import command
    from cgagen.tokenizer import Tokenizer
    from cgagen.tokenizer.files import read_source

    with Tokenizer() as tokenizer:
        compiled = tokenizer.compile(read_source(file), str(file))
    model = compiled.image.model.name
    data = {
        "kind": "source",
        "model": model,
        "language": compiled.language,
        "project_files": list(compiled.project_files),
        "digest": compiled.image.digest,
        "memory": report(compiled).to_json(),
    }
    more = [f"further slots: {', '.join(compiled.project_files)}"] if compiled.project_files else []
    lines = [
        f"{file.name}: a PBASIC source for a {model}, image {compiled.image.digest[:8]}",
        *more,
        "",
        report(compiled).to_text().rstrip("\n"),
        "",
        f"run it: {command('emulate', file)}",
    ]
    console.result(data, "\n".join(lines))
