"""Traces as files: read whatever a suffix says, written whole or not at all."""

from pathlib import Path

from cgagen.errors import FolderError, TraceError
from cgagen.files import write_bytes, write_text
from cgagen.inputs import TRACE, read_bytes
from cgagen.outputs import Kind, begins
from cgagen.places import place_of
from cgagen.robot import Robot
from hil.dbc import dbc_text
from hil.traces.candump import SUFFIXES, log_text, read_rows, read_text
from hil.traces.questions import frames_of_samples, samples_of
from hil.traces.sidecar import DBC_FILE, FORMAT, read_origin, sidecar_path, sidecar_text
from hil.traces.values import Origin, Trace, refused
from hil.traces.vectors import TIME, parse_vectors, vectors_text

CSV, LOG = ".csv", ".log"
WRITTEN = (LOG, CSV)

FRAMES = begins("a trace of frames", "(0.")
VECTORS = begins("a table of readings", f"{TIME},")
SIDECAR = begins("what lies beside a trace", f'{{\n  "format": "{FORMAT}"')
DBC = Kind("the rig's DBC file", lambda head: head == dbc_text().encode())


def read_trace(path: Path | str, robot: Robot) -> Trace:
    """Read a trace of a robot.

    Args:
        path: `.csv` for vectors; `.log`, `.log.gz`, `.asc`, `.blf` or `.trc` for frames of a rig.
        robot: whose counts and sensors they are.

    Raises:
        TraceError: there is none, it is malformed, cut, out of order, or not of this robot.
    """
    path = Path(path)
    name = str(path)
    if not path.name.lower().endswith((CSV, *SUFFIXES)):
        raise refused(
            name, "", "a trace's name ends in " + ", ".join((CSV, *SUFFIXES)), "name a trace"
        )
    origin = read_origin(path, name)
    if origin is not None:
        _check_robot(origin, robot, str(sidecar_path(path)))
    if path.suffix.lower() == CSV:
        trace = parse_vectors(read_text(path, name), name, robot)
        return Trace(name, trace.samples, origin)
    samples, stale = samples_of(read_rows(path, name), name, robot)
    return Trace(name, samples, origin, stale)


def _check_robot(origin: Origin, robot: Robot, where: str) -> None:
    if origin.role is not robot.role:
        raise refused(
            where,
            "robot",
            f"recorded with {origin.robot}, a {origin.role}, and {robot.name} is a {robot.role}",
            "name its own robot",
        )
    if origin.robot_digest != robot.digest:
        raise refused(
            where,
            "robot",
            f"recorded with {origin.robot} of digest {origin.robot_digest[:8]}, and {robot.name} "
            f"here has {robot.digest[:8]}",
            "name that robot's file, or record it again",
        )


def trace_bytes(trace: Trace, robot: Robot, suffix: str) -> bytes:
    """Return the content of a trace's file.

    Args:
        trace: what is to be written.
        robot: whose it is.
        suffix: `.log` or `.csv`.

    Raises:
        TraceError: a state was recorded without a command, for which frames have no room.
        ValueError: another suffix.
    """
    if suffix == CSV:
        return vectors_text(trace, robot).encode()
    if suffix != LOG:
        raise ValueError(f"{suffix}: traces are written as {' or '.join(WRITTEN)}")
    for sample in trace.samples:
        if sample.state is not None and sample.command is None:
            raise refused(
                trace.name,
                sample.where,
                "a state without a command has no room in frames",
                "add the command, or write .csv",
            )
    return log_text(frames_of_samples(trace.samples, robot)).encode()


def check_name(path: Path) -> None:
    """Refuse a name that no trace can be written to, before any work is done.

    Raises:
        TraceError: another suffix, or no such folder.
    """
    if not path.parent.is_dir():
        raise TraceError(f"{path}: there is no folder {path.parent}; make it, or choose another")
    if path.suffix not in WRITTEN and not place_of(path).is_stream:
        raise TraceError(f"{path}: traces are written as .log or .csv; choose such a name")


def trace_files(path: Path) -> list[tuple[Path, Kind]]:
    """Return the files of a trace, itself first.

    A stream gets the trace alone.

    Args:
        path: whose name `check_name` takes.
    """
    kind = VECTORS if path.suffix == CSV else FRAMES
    if place_of(path).is_stream:
        return [(path, kind)]
    files = [(path, kind), (sidecar_path(path), SIDECAR)]
    return files if path.suffix == CSV else [*files, (path.with_name(DBC_FILE), DBC)]


def write_trace(path: Path, trace: Trace, robot: Robot, force: bool = False) -> list[Path]:
    """Write a trace, its sidecar and, for frames, the DBC file beside it.

    Args:
        path: `.log`, `.csv`, or a stream, which gets frames where its name says nothing.
        trace: with its origin.
        robot: whose it is.
        force: write over what is there.

    Returns:
        What was written.

    Raises:
        FolderError: a file is there already.
        TraceError: see `trace_bytes`; or nothing tells where the trace comes from.
        StorageError: the disk refuses.
    """
    check_name(path)
    if trace.origin is None:
        raise TraceError(f"{trace.name}: nothing tells where it comes from; name its robot")
    data = trace_bytes(trace, robot, CSV if path.suffix == CSV else LOG)
    beside = sidecar_text(trace.origin, data, len(trace.samples), robot)
    contents = {DBC: dbc_text().encode(), SIDECAR: beside.encode()}
    wanted = {file: contents.get(kind, data) for file, kind in trace_files(path)}
    for one, content in wanted.items():
        place = place_of(one)
        if not force and place.is_file_already and _content(one) != content:
            raise FolderError(f"{one}: is there already; choose another name, or give --force")
    for one, content in reversed(wanted.items()):  # with the trace, all of it is there
        write_bytes(one, content)
    return list(wanted)


def _content(path: Path) -> bytes | None:
    try:
        return read_bytes(path, TRACE)
    except TraceError:
        return None


def write_beside(path: Path, origin: Origin, readings: int, robot: Robot) -> None:
    """Write a sidecar for a file that was made by hand.

    Raises:
        StorageError: the disk refuses.
    """
    write_text(sidecar_path(path), sidecar_text(origin, read_bytes(path, TRACE), readings, robot))
