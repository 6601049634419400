"""`cgagen info`: what a file of ours is, in words."""

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cgagen.verbs.console import Console, with_console
from cgagen.verbs.rules import FREE, given_in, name_of
from cgagen.verbs.world_options import load_hunter, world_options

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
    "an image": ("--model",),
    "a trace": ("--robot",),
    "a genome": tuple(one for one in FREE["info"] if one != "--model"),
}
"""Options that say something, by the kind of a file; of another kind none does."""

TRACES = re.compile(r"\.(log(\.gz)?|csv|asc|blf|trc)$")


@click.command("info")
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--robot", help="For a genome: another robot than its own, name or file.")
@click.option("--model", help="For an image: the chip that it is for, BS2 to BS2pe.")
@world_options
@with_console
def info_verb(console: Console, /, file: Path, model: str | None, **given: Any) -> None:
    """Describe FILE: a genome, a run or build folder, a robot or arena, an image or a trace.

    A genome is shown as its table of movements, with how often the 100 fixed starts of every
    run visit each state. States that are never visited are named: evolution could not see what
    their genes do. An image (*.bin) is listed as PBASIC that compiles to it again; its chip
    is known in a build folder, or where its source lies beside it, otherwise say --model.
    """
    if (file / "build.json").is_file():
        _refuse_other_options("a build")
        _build(console, file)
    elif file.is_dir():
        _refuse_other_options("a run")
        _run(console, file)
    elif file.suffix == ".toml":
        _refuse_other_options("a robot or arena")
        _robot(console, file)
    elif file.suffix == ".bin":
        from cgagen.verbs.info_image import describe_image

        _refuse_other_options("an image")
        describe_image(console, file, model)
    elif TRACES.search(file.name):
        from cgagen.verbs.trace import describe_trace

        _refuse_other_options("a trace")
        describe_trace(console, file, given["robot"])
    else:
        _refuse_other_options("a genome")
        _genome(console, file, given)


def _refuse_other_options(kind: str) -> None:
    """Refuse options that say nothing about a file of this kind.

    Raises:
        click.UsageError: the first of them.
    """
    context = click.get_current_context()
    allowed = {"FILE", "--json", *SAYING.get(kind, ())}
    for one in context.command.params:
        for name in map(name_of, [one, one], (False, True)):
            if name in given_in(context) - allowed:
                raise click.UsageError(f"{name} says nothing about {kind}; leave it out", context)


def _genome(console: Console, file: Path, given: dict[str, Any]) -> None:
    from cgagen.run.streams import Purpose, stream
    from sim.episode import visits_of
    from sim.model import World, words_of

    hunter = load_hunter(file, given["robot"], given, console.note)
    genome, predator, prey, arena, options, settings = hunter
    world = World(predator, prey, arena, options, steps=settings.steps)
    generator = stream(settings.fixed_starts_seed, 0, 0, Purpose.FIXED_STARTS)
    starts = world.draw_starts(generator, settings.fixed_starts)
    words = words_of(genome.array()[None, :])
    _, caught = world.play(words, starts)
    visits = visits_of(words[:, 0].copy(), starts, settings.steps, world.numbers).tolist()
    captured = int((caught > 0).sum())
    data = {
        "kind": "genome",
        "robot": genome.robot,
        "digest": genome.digest,
        "commands": genome.commands(),
        "visits": visits,
        "visited": sum(count > 0 for count in visits),
        "captured": captured,
        "starts": len(starts),
    }
    console.result(data, "\n".join(_genome_lines(file, genome, visits, captured, len(starts))))


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
    origin, met = genome.origin, sum(1 for count in visits if count)
    facts = [f"{file.name}: a genome for {genome.robot}, digest {genome.digest[:8]}"]
    if origin.generation is not None and origin.fitness is not None:
        facts.append(
            f"seed {origin.seed}, trial {origin.trial}, generation {origin.generation}, "
            f"fitness {origin.fitness:.1f}"
        )
    return [
        *facts,
        "",
        *_gene_rows(genome, visits),
        "",
        "   ".join(f"{short} {name}" for name, short in SHORT.items()),
        "The share is how often a state was met, up to the capture; - is never.",
        "",
        f"{captured} of {starts} fixed starts end in a capture.",
        f"{met} of {len(visits)} states are visited from the fixed starts; "
        f"{len(visits) - met} never are, and what their genes say was never tried:",
        *_never_met(visits),
    ]


def _gene_rows(genome: "Genome", visits: list[int]) -> list[str]:
    """Return the table of genes: a row an obstacle, a column a target."""
    from cgagen.words import COMMANDS, Role, Situation, situation_name, state_of

    commands, total = genome.commands(), max(sum(visits), 1)
    rows = [" " * 13 + "".join(f"{situation_name(t, 'target'):>13}" for t in Situation)]
    for obstacle in Situation:
        row = f"{situation_name(obstacle, 'object'):13}"
        for target in Situation:
            state = state_of(obstacle, target)
            short = SHORT[COMMANDS[Role.PREDATOR][commands[state]]]
            share = f"{visits[state] / total:7.2%}" if visits[state] else "      -"
            row += f"{short:>5} {share}"
        rows.append(row)
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


def _run(console: Console, folder: Path) -> None:
    from cgagen.run import read_record

    settings = read_record(folder).settings
    lines = [
        f"{folder.name}: a run, seed {settings.seed}, {settings.trials} trial(s) of "
        f"{settings.generations} generations, population {settings.evolution.population}"
    ]
    best = folder / "best.genome"
    lines.append(f"best genome: {best}" if best.is_file() else "no best genome yet")
    data = {
        "kind": "run",
        "seed": settings.seed,
        "trials": settings.trials,
        "generations": settings.generations,
        "population": settings.evolution.population,
        "has_best": best.is_file(),
    }
    console.result(data, "\n".join(lines))


def _robot(console: Console, file: Path) -> None:
    from cgagen.inputs import ROBOT, start_of
    from cgagen.robot import load_arena, load_robot

    if b'format = "cgagen-arena-1"' in (start_of(file, ROBOT.most) or b""):
        arena = load_arena(str(file))
        data = {"kind": "arena", "name": arena.name, "digest": arena.digest}
        text = (
            f"{file.name}: the arena {arena.name}, {arena.side_units:g} x {arena.side_units:g} "
            f"units of {1 / arena.units_per_in:g} in, digest {arena.digest[:8]}"
        )
    else:
        robot = load_robot(str(file))
        data = {
            "kind": "robot",
            "name": robot.name,
            "role": robot.role,
            "interface": robot.interface,
            "digest": robot.digest,
        }
        text = (
            f"{file.name}: the {robot.role} {robot.name}, {robot.main.model} and "
            f"{robot.locomotion.model}, digest {robot.digest[:8]}\n"
            + robot.interface.replace("; ", "\n")
        )
    console.result(data, text)


def _build(console: Console, folder: Path) -> None:
    from cgagen.build import read_record
    from cgagen.inputs import BUILD_FILE, read_text

    data, memory = read_record(folder), read_text(folder / "memory.txt", BUILD_FILE)
    console.result({"kind": "build", **data}, f"{folder.name}: a build\n\n{memory.rstrip()}")
