"""`cgagen verify`: the firmware of a genome on trial, without writing a test."""

import shlex
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cgagen.verbs.console import Console, with_console

if TYPE_CHECKING:
    from hil.equivalence import Finding, Trial
    from hil.subject import Subject
    from hil.target import Stimulus, Target
    from hil.verify import Report

LEVELS = ("smoke", "boundary", "exhaustive")


@click.command("verify")
@click.argument("genome", type=click.Path(path_type=Path, dir_okay=False), required=False)
@click.option("--robot", metavar="NAME|FILE", help="The robot. Default: the genome's, the build's.")
@click.option(
    "--build",
    type=click.Path(path_type=Path, file_okay=False, exists=True),
    metavar="DIR",
    help="Try this build as it is, instead of building anew.",
)
@click.option(
    "--target",
    "targets",
    multiple=True,
    metavar="URL",
    help="Besides the emulator: serial:PORT. May be repeated.",
)
@click.option("--level", type=click.Choice(LEVELS), default=LEVELS[0], show_default=True)
@click.option("--seed", type=int, default=1, show_default=True, help="For what chance chooses.")
@click.option(
    "--reading",
    "readings",
    multiple=True,
    metavar="COUNTS",
    help="Try this reading alone, such as 1843,0,0/--/0,170. May be repeated.",
)
@with_console
@click.pass_context
def verify_verb(
    context: click.Context,
    console: Console,
    genome: Path | None,
    robot: str | None,
    build: Path | None,
    targets: tuple[str, ...],
    level: str,
    seed: int,
    readings: tuple[str, ...],
) -> None:
    r"""Compare the firmware of a robot with the simulator.

    The images are run on the emulator: their table, every state that a reading leads to, every
    threshold with one count less and more; and their sources must compile to the same bytes. A
    prey needs no GENOME: `cgagen verify --robot servobot-prey`.

    \b
    Exit codes:
      0   PASS: all decisions are the simulator's
      7   BLOCKED: a target is sick or holds another program
      9   FAIL: a decision is not the simulator's
      11  UNPROVEN: not enough could be tried
    """
    from cgagen.tokenizer import Tokenizer
    from hil.stimuli import Level
    from hil.verify import verify

    with Tokenizer() as tokenizer:
        subject = _subject(genome, robot, build, tokenizer)
        report = verify(
            subject,
            tokenizer.compile,
            Level(level),
            seed,
            [_maker(url, subject) for url in targets if url != "emulator"],
            [_reading(text, subject) for text in readings] or None,
        )
    words = [str(genome)] if genome else []
    for option, value in (("--robot", robot), ("--build", build)):
        words += [option, str(value)] if value else []
    for url in targets:
        words += ["--target", url]
    repeat = _repeat(words, report, readings)
    console.result(_data(report, repeat), _text(report, repeat))
    context.exit(report.verdict.exit_code)


def _subject(
    genome: Path | None, robot: str | None, build: Path | None, tokenizer: Any
) -> "Subject":
    """Return what is on trial; what a build is to agree with is what was named beside it."""
    from dataclasses import replace

    from cgagen.build import make_build
    from cgagen.genome import check_interface, load
    from cgagen.robot import load_robot
    from hil.subject import read_subject, subject_of

    if genome is None and robot is None and build is None:
        raise click.UsageError("give a genome, a build with --build, or a prey with --robot")
    table = load(genome) if genome else None
    if build is None:
        body = load_robot(robot or (table.robot if table else ""))
        return subject_of(make_build(body, table, tokenizer), str(genome or body.name))
    subject = read_subject(build)
    body = load_robot(robot) if robot else subject.robot
    if table is not None:
        check_interface(table, body.name, body.interface, body.digest)
    return replace(subject, robot=body, genome=table or subject.genome)


def _maker(url: str, subject: "Subject") -> "Callable[[], Target]":
    """Return what makes a target, once it is known that there is such a kind."""
    from cgagen.errors import RigError
    from hil.targets import make_target

    try:
        make_target(url, subject)
    except RigError as error:
        raise click.UsageError(f"--target: {error}") from error
    return partial(make_target, url, subject)


def _reading(text: str, subject: "Subject") -> "Stimulus":
    from hil.stimuli import neutral
    from hil.target import stimulus_of

    plain = neutral(subject.robot)
    try:
        reading = stimulus_of(text)
    except ValueError as error:
        raise click.UsageError(f"--reading: {error}") from error
    shape = (len(reading.sonars), len(reading.lights))
    if shape != (len(plain.sonars), len(plain.lights)):
        raise click.UsageError(
            f"--reading: {text} is not of a {subject.robot.name}, whose readings are like "
            f"{plain.text()}"
        )
    return reading


def _repeat(words: list[str], report: "Report", readings: tuple[str, ...]) -> str:
    """Return the command that shows the smallest fault again, or all of this."""
    small = report.smallest
    found = [small.stimulus.text()] if small and small.stimulus else list(readings)
    options = [word for text in found for word in ("--reading", text)]
    if not found:
        options = ["--level", str(report.level), "--seed", str(report.seed)]
    return shlex.join(["cgagen", "verify", *words, *options])


def _text(report: "Report", repeat: str) -> str:
    subject = report.subject
    row = "{:<18}{:<10}{:>10}{:>8}{:>7}{:>10}"
    heads = ("trial", "verdict", "decisions", "agreed", "stale", "left out")
    lines = [f"{subject.robot.name}: {subject.where}", "", row.format(*heads)]
    for name, trial in report.trials.items():
        agreed = sum(trial.agreed.values())
        cells = (trial.verdict, trial.decisions, agreed, trial.stale, trial.left_out)
        lines.append(row.format(name, *cells))
    reasons = [f"{name}: {trial.reason}" for name, trial in report.trials.items() if trial.reason]
    lines += ["", *reasons] if reasons else []
    if report.smallest is not None:
        lines += ["", *_finding(report.smallest, subject)]
    lines += [
        "",
        f"genome {subject.genome_digest}, robot {subject.robot.digest[:8]}, "
        + ", ".join(f"{name} {image.digest[:8]}" for name, image in subject.images.items())
        + f", level {report.level}, seed {report.seed}",
        f"again: {repeat}",
        str(report.verdict),
    ]
    return "\n".join(lines)


def _finding(small: "Finding", subject: "Subject") -> list[str]:
    lines = []
    if small.stimulus is not None:
        lines.append(f"smallest reading: {small.stimulus.text()}")
    for word, seen in (("expected", small.expected), ("observed", small.observed)):
        if seen is None or seen.command < 0:
            lines.append(f"{word}: no decision")
        else:
            movement = subject.movement(seen.command)
            lines.append(f"{word}: state {seen.state}, command {seen.command} {movement}")
    return [*lines, *(f"decided in {line}" for line in small.lines)]


def _data(report: "Report", repeat: str) -> dict[str, Any]:
    subject, small = report.subject, report.smallest
    return {
        "verdict": str(report.verdict),
        "robot": {"name": subject.robot.name, "digest": subject.robot.digest},
        "genome": subject.genome.digest if subject.genome else None,
        "images": {name: image.digest for name, image in subject.images.items()},
        "level": str(report.level),
        "seed": report.seed,
        "trials": {name: _trial(trial) for name, trial in report.trials.items()},
        "smallest": {
            "reading": small.stimulus.text() if small.stimulus else None,
            "why": small.why,
            "expected": {"state": small.expected.state, "command": small.expected.command},
            "observed": {"state": small.observed.state, "command": small.observed.command}
            if small.observed
            else None,
            "lines": [line._asdict() for line in small.lines],
        }
        if small
        else None,
        "again": repeat,
    }


def _trial(trial: "Trial") -> dict[str, Any]:
    return {
        "target": trial.target,
        "verdict": str(trial.verdict),
        "reason": trial.reason,
        "tried": trial.tried,
        "agreed": trial.agreed,
        "stale": trial.stale,
        "left_out": trial.left_out,
    }
