"""`cgagen evolve` and `cgagen resume`: a population learns to hunt, in a folder that survives."""

import os
import re
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cgagen.shell import command
from cgagen.verbs.console import Console, with_console
from cgagen.verbs.progress import watch
from cgagen.verbs.world_options import load_world, note_compiling, open_points, world_options

if TYPE_CHECKING:
    from cgagen.robot import Arena, Robot
    from cgagen.run import (
        Inputs,
        Outcome,
        RunRecord,
        RunSettings,
        TrialOutcome,
        World,
        WorldFactory,
    )
    from sim.numbers import Options

COUNT = click.IntRange(min=1)
SEED = click.IntRange(0, 2**63 - 1)  # what a TOML integer can hold
ROWS_SHOWN = 8
"""Rows of the table at the end. choice: the whole is in 2-fitness.csv."""

_workers = click.option(
    "--workers",
    type=COUNT,
    default=lambda: len(os.sched_getaffinity(0)),
    show_default="all cores",
    help="Threads for one trial, processes for several. Changes no file.",
)


@click.command("evolve")
@click.option("--robot", default="servobot-predator", show_default=True, help="Name or file.")
@click.option("--generations", type=COUNT, default=300, show_default=True)
@click.option("--population", type=click.IntRange(min=2), default=256, show_default=True)
@click.option("--seed", type=SEED, default=1, show_default=True, help="Of all but fixed starts.")
@click.option("--trials", type=COUNT, default=1, show_default=True, help="Each in its folder.")
@click.option("--first-trial", type=COUNT, default=1, show_default=True, help="Its number.")
@_workers
@click.option(
    "--run",
    "folder",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="New run folder.  [default: runs/ROBOT-seedN]",
)
@click.option(
    "--mutation",
    type=click.FloatRange(0, 1),
    default=3e-5,
    show_default=True,
    help="Chance that a bit is inverted.",
)
@click.option("--elite", type=click.IntRange(min=0), default=0, show_default=True)
@click.option("--starts", type=COUNT, default=10, show_default=True, help="Per generation.")
@click.option("--steps", type=COUNT, default=200, show_default=True, help="Of an episode.")
@click.option("--fixed-starts", type=COUNT, default=100, show_default=True)
@click.option("--fixed-starts-seed", type=SEED, default=0, show_default=True)
@click.option("--evaluate-every", type=COUNT, default=10, show_default=True, metavar="GENERATIONS")
@world_options
@with_console
def evolve_verb(console: Console, /, folder: Path | None, workers: int, **given: Any) -> None:
    """Evolve a genome into a run folder.

    The defaults are the paper's. Options of the world that are not given are those of the
    robots' and the arena's files. Ctrl-C or a crash loses nothing: `cgagen resume` continues.

    \b
    The folder then holds
      best.genome      the best individual on the fixed starts
      2-fitness.csv    the population on the fixed starts: generation 1, 10, 20, ...
      2-training.csv   every generation on its own random starts
      trial-N/         all of this for each of several trials
    """  # noqa: D301 - click wants the backspace itself
    from cgagen import __version__
    from cgagen.run import RunRecord, start, stop_on_signals
    from sim.jit import kernel_digest

    settings = _settings(given)
    inputs = _inputs(given)
    versions = (("cgagen", __version__), ("world", kernel_digest()))
    record = RunRecord(settings, inputs, versions)
    if folder is None:
        name = re.sub(r"[^\w.-]+", "-", inputs.robot)
        folder = Path("runs") / f"{name}-seed{settings.seed}"
    note_compiling(console.note)
    with stop_on_signals() as stopped, _watched(console, settings) as observe:
        outcome = start(
            folder,
            record,
            partial(_make_world, record),
            workers=workers,
            observe=observe,
            stopped=stopped,
        )
    _print(console, outcome)


@click.command("resume")
@click.argument("run", type=click.Path(path_type=Path))
@_workers
@with_console
def resume_verb(console: Console, run: Path, workers: int) -> None:
    """Continue the run in the folder RUN after any interruption, bit for bit.

    Settings, robots and arena are taken from the folder. A complete run stays as it is.
    """
    from cgagen.run import read_record, resume, stop_on_signals

    settings = read_record(run).settings
    with stop_on_signals() as stopped, _watched(console, settings) as observe:
        outcome = resume(
            run,
            partial(_same_world, run),
            workers=workers,
            observe=observe,
            stopped=stopped,
        )
    if outcome.was_complete:
        console.note(f"{run}: the run was complete; nothing was left to do")
    _print(console, outcome)


def _same_world(run: Path, record: "RunRecord") -> "WorldFactory":
    """Return what makes the run's world; refuse where its step is not the one it began with."""
    from cgagen.errors import RunError
    from sim.jit import kernel_digest

    if dict(record.versions).get("world") != kernel_digest():
        raise RunError(
            f"{run}: the world step has changed since the run began, so its results would mix "
            "two; start a new run"
        )
    return partial(_make_world, record)


def _settings(given: dict[str, Any]) -> "RunSettings":
    """Return the settings that the options say; a usage error where they do not fit together."""
    from cgagen.evolve import Settings
    from cgagen.run import RunSettings

    try:
        return RunSettings(
            evolution=Settings(
                population=given["population"],
                mutation_rate=given["mutation"],
                elite=given["elite"],
            ),
            generations=given["generations"],
            starts_per_generation=given["starts"],
            steps=given["steps"],
            fixed_starts=given["fixed_starts"],
            fixed_starts_seed=given["fixed_starts_seed"],
            evaluate_every=given["evaluate_every"],
            seed=given["seed"],
            first_trial=given["first_trial"],
            trials=given["trials"],
            world=tuple(open_points(given).items()),
        )
    except ValueError as error:
        raise click.UsageError(str(error)) from None


def _inputs(given: dict[str, Any]) -> "Inputs":
    """Return the texts of the input files; refuse those that do not fit together."""
    from cgagen.run import Inputs
    from sim.numbers import world_numbers

    predator, prey, arena, options = load_world(given["robot"], given)
    world_numbers(predator, prey, arena, options)
    return Inputs(
        predator=predator.text,
        prey=prey.text,
        arena=arena.text,
        robot=predator.name,
        interface=predator.interface,
        robot_digest=predator.digest,
    )


def _parts(record: "RunRecord") -> "tuple[Robot, Robot, Arena, Options]":
    """Return what a world is made of, from the texts that the run folder keeps."""
    from cgagen.robot.reader import parse_arena, parse_robot
    from sim.numbers import Options

    inputs = record.inputs
    options: dict[str, Any] = dict(record.settings.world)
    return (
        parse_robot(inputs.predator, "1-predator.toml"),
        parse_robot(inputs.prey, "1-prey.toml"),
        parse_arena(inputs.arena, "1-arena.toml"),
        Options(**options),
    )


def _make_world(record: "RunRecord", threads: int) -> "World":
    """Return the world of a run. A plain function, so that worker processes can be given it."""
    from sim.model import World

    return World(*_parts(record), steps=record.settings.steps, threads=threads)


def _watched(console: Console, settings: "RunSettings") -> Any:
    """Return the context of an observer for this call."""
    return watch(console, settings.trials, not (console.quiet or console.no_progress))


def _print(console: Console, outcome: "Outcome") -> None:
    """Print what the run came to and what to type next."""
    best = outcome.best
    data = {
        "run": str(outcome.folder),
        "best_genome": str(outcome.best_file),
        "best": _best_data(best),
        "trials": [
            {
                "trial": trial.trial,
                "folder": str(trial.folder),
                "best": _best_data(trial),
                "fitness": [report._asdict() for report in trial.fixed],
            }
            for trial in outcome.trials
        ],
    }
    trial_words = f"trial {best.trial}, " if len(outcome.trials) > 1 else ""
    lines = [
        *(_trials_table(outcome) if len(outcome.trials) > 1 else _generations_table(best)),
        "",
        f"best genome: {outcome.best_file} ({trial_words}generation {best.best.generation}, "
        f"fitness {best.best.fitness:.1f}, {best.best.captured:.0%} captured)",
    ]
    if not console.quiet:
        lines.append(f"next:        {command('build', outcome.best_file)}")
    console.result(data, "\n".join(lines))


def _best_data(trial: "TrialOutcome") -> dict[str, Any]:
    """Return a trial's best individual for JSON."""
    best = trial.best
    return {
        "trial": trial.trial,
        "generation": best.generation,
        "fitness": best.fitness,
        "captured": best.captured,
        "bits": "".join(map(str, best.bits.tolist())),
    }


def _generations_table(trial: "TrialOutcome") -> list[str]:
    """Return a few generations of one trial, the first and the last among them."""
    last = len(trial.fixed) - 1
    count = min(ROWS_SHOWN, last + 1)
    shown = sorted({last * index // max(count - 1, 1) for index in range(count)})
    lines = ["generation     mean     best  captured   (population, fixed starts)"]
    for report in (trial.fixed[index] for index in shown):
        lines.append(
            f"{report.generation:10d} {report.mean:8.1f} {report.best:8.1f} {report.captured:8.0%}"
        )
    return lines


def _trials_table(outcome: "Outcome") -> list[str]:
    """Return the last generation of every trial."""
    lines = ["     trial     mean     best  captured   (last population, fixed starts)"]
    for trial in outcome.trials:
        last = trial.fixed[-1]
        lines.append(f"{trial.trial:10d} {last.mean:8.1f} {last.best:8.1f} {last.captured:8.0%}")
    return lines
