"""`cgagen trace`: record, convert and show what a robot has sensed."""

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cgagen.verbs.console import Console, with_console
from cgagen.verbs.named_file import GenomeType
from cgagen.verbs.simulate import FIGURE_7, PoseType
from cgagen.verbs.trace_record import SIDES, asked, subject_named
from cgagen.verbs.words import Verbs, Words
from cgagen.verbs.world_options import world_options
from cgagen.verbs.written import OUTPUT, in_folder

if TYPE_CHECKING:
    from cgagen.robot import Robot
    from hil.traces import Trace

FILE = click.Path(path_type=Path, dir_okay=False)
LEVELS = ("smoke", "boundary")
LISTENED_HELP = "a device, id:SERIAL, a URL of pyserial's, emu:BUILD, or auto."


@click.group("trace", cls=Verbs)
def trace_verb() -> None:
    """Record what a robot has sensed, convert it, and show it.

    A trace is a file of frames of the stimulus rig (candump's .log; .asc, .blf and .trc are read,
    too) or a table with units in its header (.csv). `cgagen verify GENOME --trace FILE` replays
    it. Beside a trace lies FILE.json, which says where it comes from, and, for frames, rig.dbc.
    """


@trace_verb.command("record")
@click.argument("genome", type=GenomeType(), required=False)
@click.option("-o", "--output", type=OUTPUT, required=True, help="FILE.log or FILE.csv.")
@click.option("--robot", metavar="NAME|FILE", help="The robot. Default: the genome's.")
@click.option(
    "--build",
    type=click.Path(path_type=Path, file_okay=False, exists=True),
    metavar="DIR",
    help="With --target: ask the programs of this build.",
)
@click.option(
    "--target",
    metavar="URL",
    default="simulator",
    show_default=True,
    help="Who decides: simulator, emulator, serial:PORT, can:INTERFACE:CHANNEL.",
)
@click.option("--predator", type=PoseType(), help=f"Where it starts. Default: {FIGURE_7[0]}")
@click.option("--prey", type=PoseType(), help=f"Where it starts. Default: {FIGURE_7[1]}")
@click.option("--steps", type=click.IntRange(1, 100_000), help="Of the episode. Default: 100")
@click.option("--of", "side", type=Words(SIDES), help="Whose readings. Default: predator")
@click.option("--level", type=Words(LEVELS), help="The readings of a level of verify.")
@click.option("--seed", type=int, default=1, show_default=True, help="With --level.")
@click.option("--from", "other", type=FILE, metavar="TRACE", help="The readings of a trace.")
@click.option("--sweep", is_flag=True, help="Each sensor from near to far, one after the other.")
@click.option("--port", metavar="PORT", help=f"Listen to a robot at work: {LISTENED_HELP}")
@click.option("--readings", type=click.IntRange(1, 1_000_000), help="With --port: end after these.")
@click.option(
    "--for",
    "limit_s",
    type=click.FloatRange(0.1, 86_400),
    default=60.0,
    show_default=True,
    help="With --port: end after so many seconds.",
)
@click.option("--force", is_flag=True, help="Write over what is there.")
@world_options
@with_console
def record_verb(console: Console, /, genome: Path | None, **given: Any) -> None:
    """Record a trace: the readings of an episode, of a level, of a trace, or of a robot at work.

    The readings of an episode come from the simulator, which GENOME hunts in; the default poses
    are those of the paper's test (figure 7). The target is asked about each of them. The same
    readings on the same target give the same bytes. With --port nothing is sent and nothing is
    reset: the robot hunts, and its telemetry is written down with the computer's times, until
    --readings, --for or Ctrl-C ends it.
    """
    from cgagen.errors import RigError
    from cgagen.verbs.emulated_port import named_port
    from hil.traces import write_trace
    from hil.traces.listening import record_telemetry

    given["output"] = in_folder(given["output"], "trace.log")
    on_wire = given["port"] or given["target"] not in ("simulator", "emulator")
    read = [genome, given["other"]]
    _check_output(given["output"], read, given["force"], repeats=not on_wire)
    left_out, gone = 0, ""
    if given["port"]:
        subject = subject_named(console, genome, given, "simulator")
        with named_port(given["port"], "main") as port:
            console.note(f"{port}: listening for {given['limit_s']:g} s at most; Ctrl-C ends it")
            trace, heard = record_telemetry(
                subject, port, given["readings"] or 1_000_000, given["limit_s"]
            )
        if heard.lost or heard.spoiled:
            console.note(f"{port}: {heard.lost} lines lost, {heard.spoiled} spoiled")
        if not heard.greeted:
            console.note(
                f"{port}: no banner was heard, so nothing shows that this genome is at work "
                "there; reset the robot while it is listened to, to make sure"
            )
        gone = heard.gone
    else:
        subject, trace, left_out = asked(console, genome, given)
    files = write_trace(given["output"], trace, subject.robot, given["force"])
    if left_out:
        console.note(f"{given['target']}: {left_out} readings left out, which it cannot be given")
    _say(console, trace, subject.robot, files, left_out)
    if gone:
        raise RigError(f"{gone}; what was heard before is in {given['output']}")


@trace_verb.command("convert")
@click.argument("source", type=FILE)
@click.argument("output", type=OUTPUT)
@click.option("--robot", metavar="NAME|FILE", help="Whose it is. Default: what FILE.json says.")
@click.option("--readings-only", is_flag=True, help="Leave the recorded decisions out.")
@click.option("--force", is_flag=True, help="Write over what is there.")
@with_console
def convert_verb(
    console: Console,
    source: Path,
    output: Path,
    robot: str | None,
    readings_only: bool,
    force: bool,
) -> None:
    """Convert SOURCE (.log .log.gz .asc .blf .trc .csv) to OUTPUT (.log or .csv)."""
    from hil.traces import Origin, read_trace, write_trace
    from hil.traces.recording import without_decisions

    suffix = ".log" if source.suffix.lower() == ".csv" else ".csv"
    output = in_folder(output, source.name.split(".")[0] + suffix)
    _check_output(output, [source], force)
    body = _robot_of(source, robot)
    trace = read_trace(source, body)
    if trace.origin is None:
        kind = "hand" if source.suffix.lower() == ".csv" else "can"
        origin = Origin(kind, body.name, body.role, body.digest, source={"converted": source.name})
        trace = replace(trace, origin=origin)
    if readings_only:
        trace = without_decisions(trace)
    _say(console, trace, body, write_trace(output, trace, body, force), 0)


@trace_verb.command("show")
@click.argument("file", type=FILE)
@click.option("--robot", metavar="NAME|FILE", help="Whose it is. Default: what FILE.json says.")
@with_console
def show_verb(console: Console, file: Path, robot: str | None) -> None:
    """Print the readings of FILE, its situations, movements and times.

    A state in brackets was not recorded: it is what the robot's thresholds make of the reading.
    """
    from hil.traces import read_trace
    from hil.traces.shown import rows_of, table_of

    body = _robot_of(file, robot)
    trace = read_trace(file, body)
    data = {**_summary(trace, body), "stale": trace.stale, "rows": rows_of(trace, body)}
    lines = [table_of(trace, body), "", _words(trace, body)]
    console.result(data, "\n".join(lines))


def describe_trace(console: Console, file: Path, robot: str | None) -> None:
    """Say where a trace comes from, and how much is in it."""
    from hil.traces import read_trace

    body = _robot_of(file, robot)
    trace = read_trace(file, body)
    console.result({"kind": "trace", **_summary(trace, body)}, _words(trace, body))


def _check_output(
    output: Path, read: Iterable[Path | None], force: bool, repeats: bool = True
) -> None:
    """Refuse to write over anything, before a robot is asked that may not repeat itself.

    Args:
        output: of a trace.
        read: what the verb reads.
        force: see `check_outputs`.
        repeats: the same call gives the same bytes, over which it may write.
    """
    from cgagen.outputs import never
    from cgagen.verbs.written import check
    from hil.traces.storage import check_name, trace_files

    check_name(output)
    first, *beside = trace_files(output)
    kind = first[1] if repeats else never("a trace")
    check([(output, kind), *beside], [one for one in read if one is not None], force)


def _robot_of(file: Path, given: str | None) -> "Robot":
    """Return the robot of a trace: what was named, or what the sidecar or the folder says."""
    from cgagen.errors import TraceError
    from cgagen.robot import load_robot, shipped
    from cgagen.robot.reader import parse_robot
    from cgagen.whose import home_of
    from hil.traces.sidecar import read_origin, sidecar_path

    if given:
        return load_robot(given)
    if not file.exists():
        raise TraceError(f"{file}: no such file; name a trace")
    origin = read_origin(file, str(file))
    if origin is None:
        raise TraceError(
            f"{file}: no {file.name}.json says whose it is; name the robot with --robot"
        )
    if origin.robot_file is not None:
        return parse_robot(origin.robot_file, str(sidecar_path(file)))
    home = home_of(file)
    if home is not None and home.robot.digest == origin.robot_digest:
        return home.robot
    if origin.robot not in shipped("robot"):
        raise TraceError(
            f"{file}: recorded with {origin.robot}, which does not ship with cgagen; "
            "pass its file with --robot FILE"
        )
    return load_robot(origin.robot)


def _summary(trace: "Trace", robot: "Robot") -> dict[str, Any]:
    origin = trace.origin
    return {
        "robot": robot.name,
        "target": origin.target if origin else None,
        "genome": origin.genome if origin else None,
        "readings": len(trace.samples),
        "decisions": sum(one.decided for one in trace.samples),
    }


def _words(trace: "Trace", robot: "Robot") -> str:
    row = _summary(trace, robot)
    genome = f", genome {row['genome'][:8]}" if row["genome"] else ""
    by = f" by {row['target']}" if row["target"] else ""
    return f"{robot.name}{genome}: {row['readings']} readings, {row['decisions']} decisions{by}"


def _say(
    console: Console, trace: "Trace", robot: "Robot", files: list[Path], left_out: int
) -> None:
    data = {**_summary(trace, robot), "left_out": left_out, "files": [str(one) for one in files]}
    console.result(data, f"{_words(trace, robot)}\nwritten: {', '.join(map(str, files))}")
