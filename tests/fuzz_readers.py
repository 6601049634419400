"""The readers of every kind of file, each with files that are right, for `tests.fuzz_inputs`."""

import gzip
import json
import shutil
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import can

from cgagen import checkpoint, genome
from cgagen.build.checked import checked_images
from cgagen.calibrate.measurements import read_measurements
from cgagen.emulator.bench_file import read_bench
from cgagen.errors import CgagenError
from cgagen.firmware import generate
from cgagen.inputs import IMAGE, MEASUREMENTS, read_bytes, read_text
from cgagen.robot import load_arena, load_robot
from cgagen.robot.reader import ROBOTS_FOLDER
from cgagen.run import read_record
from cgagen.run.sound import check_populations, check_tables, trouble_of
from cgagen.stamp.chips import chip
from cgagen.stamp.decode import decode
from cgagen.stamp.image import Image
from cgagen.stamp.listing import listing
from cgagen.tokenizer import Tokenizer
from cgagen.tokenizer.files import read_source
from hil.dbc import dbc_text
from hil.decisions import Decision, read_decisions
from hil.fate import SURVIVORS, reviews
from hil.kills import FORMAT as KILLS_FORMAT
from hil.report import read_kills
from hil.requirements import OURS, read_requirements
from hil.simulated import SimulatedTarget
from hil.stimuli import every_state
from hil.subject import read_subject
from hil.traces import read_trace
from tests.run_cases import unbroken
from tests.subjects import FIRMWARE, subject
from tests.toy_run import record
from tests.trace_cases import messages, predator, some

Read = Callable[[bytes], object]

TRACES = Path(__file__).parent.parent / "hil" / "traces"
PROGRAMS = Path(__file__).parent / "programs"
RUN = record()


@dataclass(frozen=True)
class Reader:
    """One kind of file.

    Attributes:
        name: of the kind.
        samples: returns files that are right.
        prepare: returns what puts a file into a folder and reads it as the verbs do.
    """

    name: str
    samples: Callable[[], list[bytes]]
    prepare: Callable[[Path], Read]


def _file(name: str, read: Callable[[Path], object]) -> Callable[[Path], Read]:
    """Return the preparation of a reader that takes a file by its name."""

    def prepare(folder: Path) -> Read:
        def put(data: bytes) -> object:
            (folder / name).write_bytes(data)
            return read(folder / name)

        return put

    return prepare


def _in_copy(source: Path, name: str, read: Callable[[Path], object]) -> Callable[[Path], Read]:
    """Likewise, of a reader of folders, where one file is another."""

    def prepare(folder: Path) -> Read:
        copy = folder / "copy"
        shutil.copytree(source, copy)

        def put(data: bytes) -> object:
            (copy / name).write_bytes(data)
            return read(copy)

        return put

    return prepare


def _of_run(name: str) -> Callable[[Path], Read]:
    """Likewise, of a whole run of the toy."""

    def prepare(folder: Path) -> Read:
        for one, content in unbroken(1)[1].items():
            (folder / one).write_bytes(content)

        def put(data: bytes) -> object:
            (folder / name).write_bytes(data)
            return _resumed(folder)

        return put

    return prepare


def _resumed(folder: Path) -> None:
    """Look at a run that is done as `resume` does."""
    one = read_record(folder)
    shape = (one.settings.evolution.population, one.settings.evolution.bits)
    path = folder / "2-checkpoint.npz"
    state = checkpoint.restore(path, one.digest, 1, shape)
    trouble = trouble_of(state, one.settings)
    if trouble:
        raise checkpoint.damaged(str(path), trouble)
    check_populations(folder, state, one.settings)
    check_tables(folder, state)


def _in_run(name: str) -> Callable[[], list[bytes]]:
    return lambda: [unbroken(1)[1][name]]


def _files(*paths: Path) -> Callable[[], list[bytes]]:
    return lambda: [path.read_bytes() for path in paths]


def _build(folder: Path) -> None:
    checked_images(folder)
    read_subject(folder)


def _image(model: str) -> Callable[[Path], object]:
    def read(path: Path) -> object:
        image = Image(chip(model), read_bytes(path, IMAGE))
        return listing(decode(image.eeprom, image.model), image, {})

    return read


def _trace(path: Path) -> object:
    return read_trace(path, predator().robot)


@cache
def _by_can(suffix: str) -> bytes:
    """Return what python-can writes."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"a{suffix}"
        with can.Logger(path) as writer:
            for message in messages(some(predator()), 0.0, 0):
                writer.on_message_received(message)
        return path.read_bytes()


def _beside(trace: str, beside: str) -> Callable[[Path], Read]:
    """Return the preparation of what lies beside a trace."""

    def prepare(folder: Path) -> Read:
        shutil.copy(TRACES / trace, folder / trace)

        def put(data: bytes) -> object:
            (folder / beside).write_bytes(data)
            return _trace(folder / trace)

        return put

    return prepare


def _table(path: Path) -> object:
    texts = {"typed": read_text(path, MEASUREMENTS)}
    return read_measurements(load_robot("servobot-predator"), texts)


def _decisions() -> list[bytes]:
    one = subject("predator")
    stimuli = list(every_state(one.robot).values())[:8]
    seen = SimulatedTarget(one).decide_all(stimuli)
    pairs = zip(stimuli, seen, strict=True)
    return ["".join(Decision(*pair).line() for pair in pairs).encode()]


def _template(folder: Path) -> object:
    one = subject("predator")
    return generate(one.robot, one.genome, folder)


@cache
def _tokenizer() -> Tokenizer:
    return Tokenizer().__enter__()


def _source(path: Path) -> object:
    return _tokenizer().compile(read_source(path), path.name)


def _templates(folder: Path) -> Read:
    """Templates are filled in here, and not in a process each: that is tried elsewhere."""
    from cgagen.firmware import render, sandbox

    def put(data: bytes) -> object:
        (folder / "_telemetry.j2").write_bytes(data)
        confined, render.render_confined = render.render_confined, sandbox.render
        try:
            return _template(folder)
        finally:
            render.render_confined = confined

    return put


def _refuse_nothing(path: Path) -> object:
    return reviews.__wrapped__(path)


READERS: dict[str, Reader] = {
    one.name: one
    for one in (
        Reader("robot", _files(*(ROBOTS_FOLDER / f"servobot-{one}.toml"
                                 for one in ("predator", "prey"))),
               _file("mine.toml", lambda path: load_robot(str(path)))),
        Reader("arena", _files(ROBOTS_FOLDER / "colony.toml"),
               _file("arena.toml", lambda path: load_arena(str(path)))),
        Reader("genome", _files(FIRMWARE / "reference.genome"), _file("a.genome", genome.load)),
        Reader("run", _in_run("0-run.toml"), _of_run("0-run.toml")),
        Reader("run-input", _in_run("1-prey.toml"), _of_run("1-prey.toml")),
        Reader("run-table", _in_run("2-fitness.csv"), _of_run("2-fitness.csv")),
        Reader("run-best", _in_run("best.genome"), _of_run("best.genome")),
        Reader("population", _in_run("2-population-g015.csv"), _of_run("2-population-g015.csv")),
        Reader("checkpoint", _in_run("2-checkpoint.npz"), _of_run("2-checkpoint.npz")),
        Reader("build", _files(FIRMWARE / "predator" / "build.json"),
               _in_copy(FIRMWARE / "predator", "build.json", _build)),
        Reader("build-image", _files(FIRMWARE / "predator" / "main.bin"),
               _in_copy(FIRMWARE / "predator", "main.bin", _build)),
        Reader("image", _files(FIRMWARE / "prey" / "main.bin"), _file("a.bin", _image("BS2p"))),
        Reader("image-bs2", _files(FIRMWARE / "prey" / "locomotion.bin"),
               _file("a.bin", _image("BS2"))),
        Reader("bench", _files(FIRMWARE / "predator" / "bench.toml"),
               _in_copy(FIRMWARE / "predator", "bench.toml",
                        lambda folder: read_bench(folder / "bench.toml"))),
        Reader("log", _files(TRACES / "wall.log"), _file("a.log", _trace)),
        Reader("log.gz", lambda: [gzip.compress((TRACES / "wall.log").read_bytes(), mtime=0)],
               _file("a.log.gz", _trace)),
        Reader("asc", lambda: [_by_can(".asc")], _file("a.asc", _trace)),
        Reader("blf", lambda: [_by_can(".blf")], _file("a.blf", _trace)),
        Reader("trc", lambda: [_by_can(".trc")], _file("a.trc", _trace)),
        Reader("vectors", _files(TRACES / "vectors.csv"), _file("a.csv", _trace)),
        Reader("sidecar", _files(TRACES / "wall.log.json"), _beside("wall.log", "wall.log.json")),
        Reader("dbc", lambda: [dbc_text().encode()], _beside("wall.log", "rig.dbc")),
        Reader("measurements",
               lambda: [b"movement,cycles,along_in,right_in,turn_deg\nFORWARD,5,11.8,0.0,-8\n"
                        b"BACKWARD,5,-11.8,0.1,2\n",
                        b"sensor,distance_in,count\nfront,12,2212\nlight_left,24,430\n"],
               _file("a.csv", _table)),
        Reader("decisions", _decisions, _file("a.jsonl", lambda path: list(read_decisions(path)))),
        Reader("kills", lambda: [json.dumps({"format": KILLS_FORMAT, "images": {}}).encode()],
               _file("kills.json", read_kills)),
        Reader("reviews", _files(SURVIVORS), _file("survivors.toml", _refuse_nothing)),
        Reader("requirements", _files(OURS), _file("requirements.toml", read_requirements)),
        Reader("template", _files(FIRMWARE.parent / "templates" / "_telemetry.j2"), _templates),
        Reader("source", lambda: [path.read_bytes() for path in sorted(PROGRAMS.glob("*.bs*"))],
               _file("a.bs2", _source)),
    )
}  # fmt: skip
"""By name, each with the reader of the verbs."""

__all__ = ["READERS", "CgagenError", "Reader"]
