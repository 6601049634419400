"""`cgagen verify`: the firmware of a genome on trial, without writing a test."""

import shlex
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cgagen.verbs.console import Console, with_console
from cgagen.verbs.named_file import GenomeType
from cgagen.verbs.verify_text import data_of, text_of
from cgagen.verbs.words import Words
from cgagen.verbs.written import OUTPUT, check, folder_at

if TYPE_CHECKING:
    from hil.outcome import Report
    from hil.subject import Subject
    from hil.target import Stimulus, Target

LEVELS = ("exhaustive", "boundary", "smoke")


@click.command("verify")
@click.argument("genome", type=GenomeType(), required=False)
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
    help="Besides the emulator: serial:PORT, serial-reset:PORT (resets it by DTR first), "
    "can:INTERFACE:CHANNEL. May be repeated.",
)
@click.option(
    "--legs",
    metavar="URL",
    help="The locomotion controller, serial:PORT or serial-reset:PORT: the robot walks each "
    "movement once.",
)
@click.option(
    "--level", type=Words(LEVELS), default=LEVELS[0], show_default=True, help="How much is tried."
)
@click.option("--seed", type=int, default=1, show_default=True, help="For what chance chooses.")
@click.option(
    "--reading",
    "readings",
    multiple=True,
    metavar="COUNTS",
    help="Try this reading alone, such as 1843,0,0/--/0,170. May be repeated.",
)
@click.option(
    "--trace",
    "traces",
    type=click.Path(path_type=Path, dir_okay=False),
    multiple=True,
    metavar="FILE",
    help="Replay this trace, too, on every target. May be repeated.",
)
@click.option(
    "--report",
    "reports",
    type=OUTPUT,
    multiple=True,
    metavar="FILE",
    help="Write a report: FILE.html is a page, FILE.json data, a folder gets both.",
)
@click.option(
    "--kills",
    type=click.Path(path_type=Path, dir_okay=False, exists=True),
    multiple=True,
    metavar="FILE",
    help="Kill matrix for the report, as `make hil-mutants` writes it.",
)
@click.option("--force", is_flag=True, help="Write over files that are no reports of ours.")
@with_console
@click.pass_context
def verify_verb(
    context: click.Context,
    console: Console,
    genome: Path | None,
    robot: str | None,
    build: Path | None,
    targets: tuple[str, ...],
    legs: str | None,
    level: str,
    seed: int,
    readings: tuple[str, ...],
    traces: tuple[Path, ...],
    reports: tuple[Path, ...],
    kills: tuple[Path, ...],
    force: bool,
) -> None:
    """Compare the firmware of a robot with the simulator.

    The images are run on the emulator: their table, every state that a reading leads to, every
    threshold with one count less and more, ties and pairs of thresholds, the whole sensor space
    cell by cell, all movements, the longest time, and what both controllers do on their lines and
    ports; and their sources must compile to the same bytes. So the image is proven for every
    reading. A --target on a wire is given every state, every threshold and some readings by
    chance, and what it holds is compared with the image that was proven. Level `boundary` tries
    a sample of the sensor space, `smoke` also leaves out ties and pairs. A prey needs no GENOME:
    `cgagen verify --robot servobot-prey`.

    \b
    Exit codes:
      0   PASS: all decisions are the simulator's
      7   BLOCKED: a target is sick or holds another program
      9   FAIL: a decision is not the simulator's
      11  UNPROVEN: not enough could be tried, or something was left out: its row says why
    """  # noqa: D301  click's sign for lines that stay as they are
    from cgagen.build.record import FILES as BUILD_FILES
    from cgagen.tokenizer import Tokenizer
    from hil.report import read_kills, report_files, report_of, write_reports
    from hil.stimuli import Level
    from hil.traces import read_trace
    from hil.verify import verify

    read = [one for one in (genome, robot, *traces, *kills) if one is not None]
    read += [build / name for name in BUILD_FILES] if build is not None else []
    for path in reports:
        folder_at(path)
    check(report_files(reports), map(Path, read), force)
    matrices = [read_kills(path) for path in kills]

    with Tokenizer(warn=console.note) as tokenizer:
        subject = _subject(console, genome, robot, build, tokenizer)
        report = verify(
            subject,
            tokenizer.compile,
            Level(level),
            seed,
            [_maker(url, subject) for url in targets if url != "emulator"],
            [_reading(text, subject) for text in readings] or None,
            [read_trace(path, subject.robot) for path in traces],
            _legs(legs, subject),
        )
    words = [str(genome)] if genome else []
    for option, value in (("--robot", robot), ("--build", build)):
        words += [option, str(value)] if value else []
    for url in targets:
        words += ["--target", url]
    words += ["--legs", legs] if legs else []
    repeat = _repeat(words, report, readings, traces)
    page = report_of([report.evidence.data()], level, seed, repeat, matrices)
    for file in write_reports(reports, page):
        console.note(f"report: {file}")
    console.result(data_of(report, repeat), text_of(report, repeat))
    context.exit(report.verdict.exit_code)


def _subject(
    console: Console, genome: Path | None, robot: str | None, build: Path | None, tokenizer: Any
) -> "Subject":
    """Return what is on trial; what a build is to agree with is what was named beside it."""
    from dataclasses import replace

    from cgagen.build import make_build
    from cgagen.genome import check_interface, load
    from cgagen.robot import load_robot
    from cgagen.verbs.robot_choice import robot_of
    from hil.subject import alike, held, read_subject, subject_of

    if genome is None and robot is None and build is None:
        raise click.UsageError("give a genome, a build with --build, or a prey with --robot")
    table = load(genome) if genome else None
    if build is None:
        if table is not None and genome is not None:
            body = robot_of(console, table, genome, robot)
        else:
            body = load_robot(robot or "")
        return subject_of(make_build(body, table, tokenizer), str(genome or body.name))
    subject = read_subject(build)
    body = load_robot(robot) if robot else subject.robot
    if body.role is not subject.role:
        held(subject, body, None)  # a prey and a predator have no states in common
    body = subject.robot if alike(body, subject.robot) else body
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


def _legs(url: str | None, subject: "Subject") -> str | None:
    """Return the name of a port of legs, once it is known to be one."""
    from cgagen.errors import RigError
    from hil.wired_walks import legs_on

    if url is not None:
        try:
            legs_on(url, subject)
        except RigError as error:
            raise click.UsageError(f"--legs: {error}") from error
    return url


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


def _repeat(
    words: list[str], report: "Report", readings: tuple[str, ...], traces: tuple[Path, ...]
) -> str:
    """Return the command that shows the smallest fault again, or all of this."""
    small = report.smallest
    options = ["--level", str(report.level), "--seed", str(report.seed)]
    if small and small.stimulus and not report.from_trace:
        options = ["--reading", small.stimulus.text()]
    elif readings:
        options = [word for text in readings for word in ("--reading", text)]
    if not small or report.from_trace:
        options += [word for path in traces for word in ("--trace", str(path))]
    return shlex.join(["cgagen", "verify", *words, *options])
