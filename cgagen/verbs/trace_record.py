"""What `cgagen trace record` asks for: whose readings, which, and of whom."""

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cgagen.verbs.console import Console
from cgagen.verbs.simulate import FIGURE_7, PoseType
from cgagen.verbs.world_options import load_hunter

if TYPE_CHECKING:
    from cgagen.robot import Robot
    from hil.subject import Subject
    from hil.target import Stimulus
    from hil.traces import Trace

SIDES = ("predator", "prey")


def asked(
    console: Console, genome: Path | None, given: dict[str, Any]
) -> "tuple[Subject, Trace, int]":
    """Record from a target that is asked reading by reading."""
    from cgagen.errors import RigError
    from hil.targets import make_target
    from hil.traces.recording import record_readings

    if any(given[name] for name in ("level", "other", "sweep")):
        subject = subject_named(console, genome, given, given["target"])
        stimuli, source = _stimuli(subject, given)
    else:
        subject, stimuli, source = _episode(console, genome, given)
    seed = given["seed"] if given["level"] else None
    try:
        target = make_target(given["target"], subject)
    except RigError as error:
        raise click.UsageError(f"--target: {error}") from error
    try:
        target.open()
        trace, left_out = record_readings(subject, target, stimuli, source, seed)
    finally:
        target.close()
    return subject, trace, left_out


def _stimuli(subject: "Subject", given: dict[str, Any]) -> "tuple[list[Stimulus], dict[str, Any]]":
    from hil.stimuli import Level, stimuli_of
    from hil.traces import read_trace
    from hil.traces.recording import sweep

    robot = subject.robot
    if given["sweep"]:
        return sweep(robot), {"sweep": "sensors"}
    if given["level"]:
        return stimuli_of(robot, Level(given["level"]), given["seed"]), {"level": given["level"]}
    trace = read_trace(given["other"], robot)
    origin = trace.origin
    return trace.stimuli, dict(origin.source) if origin else {"from": given["other"].name}


def _episode(
    console: Console, genome: Path | None, given: dict[str, Any]
) -> "tuple[Subject, list[Stimulus], dict[str, Any]]":
    """Play an episode and return whose readings were wanted, with them."""
    from cgagen.words import Role
    from hil.traces.recording import episode_readings, episode_source
    from sim.numbers import world_numbers
    from sim.starts import start_of

    if genome is None:
        raise click.UsageError("an episode needs GENOME; or say --level, --sweep, --from or --port")
    pose = PoseType()
    poses = {
        name: given[name] or pose.convert(default, None, None)
        for name, default in zip(SIDES, FIGURE_7, strict=True)
    }
    loaded, predator, prey, arena, options, _ = load_hunter(
        genome, given["robot"], given, console.note
    )
    numbers = world_numbers(predator, prey, arena, options)
    radii = (numbers.predator.radius, numbers.prey.radius)
    start = start_of(poses["predator"], poses["prey"], numbers.side, radii)
    role = Role(given["side"] or "predator")
    steps = given["steps"] or 100
    body = predator if role is Role.PREDATOR else prey
    subject = _subject_of(
        body, loaded if role is Role.PREDATOR else None, given, given["target"], str(genome)
    )
    said = {name: value for name, value in asdict(options).items() if value is not None}
    source = episode_source(role, poses, steps, loaded, said)
    return subject, episode_readings(loaded, numbers, start, steps, role), source


def subject_named(
    console: Console, genome: Path | None, given: dict[str, Any], target: str
) -> "Subject":
    """Return whose readings and decisions are recorded."""
    from cgagen.genome import load
    from cgagen.robot import load_robot
    from cgagen.verbs.robot_choice import robot_of

    table = load(genome) if genome else None
    if given["build"]:
        named = load_robot(given["robot"]) if given["robot"] else None
        return _subject_of(named, table, given, target, str(given["build"]))
    if table is None and given["robot"] is None:
        raise click.UsageError("give a genome, a build with --build, or a prey with --robot")
    if table is not None and genome is not None:
        body = robot_of(console, table, genome, given["robot"])
    else:
        body = load_robot(given["robot"])
    if table is None and body.limits is not None:
        raise click.UsageError(f"{body.name} is a predator and needs GENOME")
    return _subject_of(body, table, given, target, str(genome or body.name))


def _subject_of(
    body: "Robot | None", table: Any, given: dict[str, Any], target: str, where: str
) -> "Subject":
    """Return a subject with its programs, where the target has any use for them."""
    from hil.subject import Subject, held, read_subject, subject_of

    if given["build"]:
        return held(read_subject(given["build"]), body, table)
    if body is None:
        raise TypeError("a robot is wanted where no build is")
    if target == "simulator":
        return Subject(body, table, {}, {}, {}, {}, where)
    from cgagen.build import make_build
    from cgagen.tokenizer import Tokenizer

    with Tokenizer() as tokenizer:
        return subject_of(make_build(body, table, tokenizer), where)
