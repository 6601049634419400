"""No verb writes over what is not of its own kind, and of ours; it is refused before the work."""

import itertools
import json
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from cgagen import cli
from cgagen.build.record import FILES
from cgagen.emulator.coverage_report import LISTING, TRACEFILE
from cgagen.emulator.trace import HEADER
from cgagen.emulator.vcd import WAVEFORM
from cgagen.errors import FolderError, RunError, SamePlaceError, StoppedError
from cgagen.outputs import Kind, begins, check_outputs, never
from cgagen.run import start
from cgagen.tokenizer import Tokenizer
from cgagen.tokenizer.files import IMAGE, SOURCE_MAP
from cgagen.verbs.emulate_files import TRACE
from hil.decisions import DECISION_LINES
from hil.kills import MATRIX
from hil.report import KINDS
from hil.traces.storage import DBC, FRAMES, SIDECAR, VECTORS
from tests.output_cases import null_device
from tests.run_cases import resume_toy
from tests.stamp_programs import FOLDER as PROGRAMS
from tests.toy_run import ToyFactory, record

ROOT = Path(__file__).parent.parent
PREY = ROOT / "firmware" / "prey"
GENOME = ROOT / "firmware" / "reference.genome"

OTHERS = {
    "package.json": '{\n "name": "mine"\n}\n',
    "build.json": (PREY / "build.json").read_text(),
    "notes.txt": "years of work\n",
    "other.info": "TN:\nSF:mine.c\nend_of_record\n",
    "other.vcd": "$version Icarus Verilog $end\n$timescale 1s $end\n",
    "page.html": "<!doctype html>\n<html><head><title>mine</title></head></html>\n",
    "table.csv": "line,row,bit\n1,2,3\n",
    "image.png": "\x89PNG" + "\0" * 2044,
}
"""What a user has, none of it ours, by the names that it may have."""

WRITES: dict[str, tuple[str, ...]] = {
    "emulate --vcd": ("emulate", str(PROGRAMS / "hello.bs2"), "--vcd"),
    "emulate --trace": ("emulate", str(PROGRAMS / "hello.bs2"), "--trace"),
    "emulate --coverage": ("emulate", str(PROGRAMS / "hello.bs2"), "--coverage"),
    "emulate --port": ("emulate", "--model", "BS2", "--port", "tcp:0", "--for", "1s", "--vcd"),
    "compile -o": ("compile", str(PROGRAMS / "hello.bs2"), "-o"),
    "compile --map": ("compile", str(PROGRAMS / "hello.bs2"), "--map"),
    "verify --report": ("verify", "--build", str(PREY), "--report"),
    "calibrate -o": ("calibrate", "marks.csv", "--robot", "servobot-predator", "-o"),
    "monitor --log": ("monitor", "--port", f"emu:{PREY}", "--for", "1s", "--log"),
    "trace record -o": ("trace", "record", str(GENOME), "--sweep", "-o"),
    "trace convert": ("trace", "convert", str(ROOT / "hil" / "traces" / "sweep.log")),
}
"""Every verb that writes a file that is named, up to that name."""

SUFFIXES = {"verify --report": (".json", ".html"), "trace record -o": (".log", ".csv")}
SUFFIXES["trace convert"] = SUFFIXES["trace record -o"]

FORCED = [name for name in WRITES if name != "emulate --port"]


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    rows = "sensor,distance_in,count\nfront,24,4425\nfront,24,4430\n"
    (tmp_path / "marks.csv").write_text(rows)
    return tmp_path


@pytest.mark.parametrize("verb", WRITES)
@pytest.mark.parametrize("other", OTHERS)
def test_what_is_not_ours_is_named_and_kept(
    verb: str, other: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for suffix in SUFFIXES.get(verb, ("",)):
        path = folder / (other + suffix)
        path.write_text(OTHERS[other], encoding="latin-1")
        before = contents(folder)
        assert cli.main([*WRITES[verb], path.name]) == 3
        err = capsys.readouterr().err
        assert path.name in err
        assert "--force" in err
        assert contents(folder) == before
        os.unlink(path)


@pytest.mark.parametrize("verb", WRITES)
def test_a_folder_and_a_loop_are_refused(
    verb: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    suffix = SUFFIXES.get(verb, (".x",))[0]
    (folder / f"loop{suffix}").symlink_to(f"loop{suffix}")
    for words in ([], ["--force"]):
        assert cli.main([*WRITES[verb], f"loop{suffix}", *words]) in (2, 3)
        assert cli.main([*WRITES[verb], f"none/x{suffix}", *words]) in (2, 3)
        assert "bug of ours" not in capsys.readouterr().err
    assert sorted(os.listdir(folder)) == [f"loop{suffix}", "marks.csv"]


QUICK = [name for name in FORCED if name not in ("verify --report", "monitor --log")]


@pytest.mark.parametrize("verb", QUICK)
def test_force_and_what_is_ours(
    verb: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """With --force it is written; the same call then writes over its own, unless it is precious."""
    path = folder / f"notes{SUFFIXES.get(verb, ('.x',))[0]}"
    path.write_text("mine")
    assert cli.main([*WRITES[verb], path.name, "--force"]) == 0, capsys.readouterr().err
    written = contents(folder)
    assert written[path.name] != b"mine"
    assert cli.main([*WRITES[verb], path.name]) == (3 if verb == "calibrate -o" else 0)
    assert contents(folder) == written


@pytest.mark.parametrize("verb", [*QUICK, "verify --report", "monitor --log"])
def test_every_verb_leaves_a_device_in_its_place(verb: str, folder: Path) -> None:
    device = null_device(folder / "null")
    status = device.lstat()
    assert cli.main([*WRITES[verb], "null"]) == 0
    assert (device.lstat().st_ino, device.lstat().st_rdev) == (status.st_ino, status.st_rdev)
    assert sorted(os.listdir(folder)) == ["marks.csv", "null"]


def test_two_outputs_at_one_place(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shutil.copy(PROGRAMS / "hello.bs2", "it.bs2")
    os.link("it.bs2", "same.bs2")
    (folder / "link").symlink_to("x")
    emulate = ["emulate", "it.bs2", "--force"]
    for words in (
        [*emulate, "--vcd", "x", "--trace", "./x"],
        [*emulate, "--vcd", "x", "--trace", "link"],
        [*emulate, "--coverage", "x", "--vcd", "x.txt"],
        [*emulate, "--vcd", "it.bs2"],
        [*emulate, "--trace", "same.bs2"],
        ["compile", "it.bs2", "--force", "-o", "same.bs2"],
        ["calibrate", "marks.csv", "--robot", "servobot-predator", "--force", "-o", "marks.csv"],
    ):
        before = contents(folder)
        assert cli.main(words) == 2
        assert "; choose another name" in capsys.readouterr().err
        assert contents(folder) == before


def test_a_build_that_is_read_is_not_written_over(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in FILES & set(os.listdir(PREY)):
        shutil.copy(PREY / name, name)
    before = contents(folder)
    assert cli.main(["verify", "--build", ".", "--report", "build.json", "--force"]) == 2
    assert "is read in the same call" in capsys.readouterr().err
    assert contents(folder) == before


def test_many_may_write_to_a_null_device(folder: Path) -> None:
    device = null_device(folder / "null")
    words = ["--vcd", "null", "--trace", "null", "--coverage", "null"]
    assert cli.main(["emulate", str(PROGRAMS / "hello.bs2"), *words]) == 0
    assert device.lstat().st_rdev == os.stat("/dev/null").st_rdev


def test_a_table_is_added_to_only_if_it_is_one(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["robot", "sensors", "--port", f"emu:{PREY}", "--sensor", "front"]
    words += ["--distance", "24", "--readings", "2", "--table"]
    for name in ("notes.txt", "table.csv", "build.json"):
        (folder / name).write_text(OTHERS[name])
        assert cli.main([*words, name]) == 3
        assert "no counts are added to it" in capsys.readouterr().err
        assert (folder / name).read_text() == OTHERS[name]


@pytest.mark.parametrize("trials", [1, 2])
@pytest.mark.parametrize(
    "name", ["best.genome", "2-fitness.csv", "2-training.csv", "2-population-g001.csv"]
)
def test_a_run_does_not_go_on_over_other_files(tmp_path: Path, name: str, trials: int) -> None:
    calls = itertools.count()
    with pytest.raises(StoppedError):
        start(
            tmp_path / "run", record(trials=trials), ToyFactory(), stopped=lambda: next(calls) > 20
        )
    folder = tmp_path / "run" / ("" if trials == 1 else "trial-1")
    assert (folder / name).is_file()
    (folder / name).write_text("mine")
    with pytest.raises(RunError, match="the run would write over it; move it away"):
        resume_toy(tmp_path / "run")
    assert (folder / name).read_text() == "mine"
    if not name.startswith("2-population"):
        (folder / name).unlink()
        assert not resume_toy(tmp_path / "run").was_complete


SAMPLES: dict[str, tuple[Kind, Callable[[], bytes]]] = {
    "image": (IMAGE, (PREY / "main.bin").read_bytes),
    "map": (SOURCE_MAP, lambda: b"line,column,bit\n"),
    "trace of instructions": (TRACE, lambda: HEADER.encode() + b"\n"),
    "waveform": (WAVEFORM, lambda: b"$timescale 1 ns $end\n$version cgagen $end\n"),
    "tracefile": (TRACEFILE, lambda: b"TN:cgagen\nSF:x\n"),
    "listing": (LISTING, lambda: b"coverage of x\n"),
    "frames": (FRAMES, (ROOT / "hil/traces/hunt.log").read_bytes),
    "sidecar": (SIDECAR, (ROOT / "hil/traces/hunt.log.json").read_bytes),
    "dbc": (DBC, (ROOT / "hil/traces/rig.dbc").read_bytes),
    "vectors": (VECTORS, lambda: b"t_ms,front_counts\n"),
    "decisions": (DECISION_LINES, lambda: b'{"seq": 1, "reading": "7/--"}\n'),
    "report": (KINDS[".json"], lambda: json_text("cgagen-hil-report-1")),
    "matrix": (MATRIX, lambda: json_text("cgagen-kills-1")),
}


def json_text(form: str) -> bytes:
    return json.dumps({"format": form, "more": [1]}, indent=1).encode() + b"\n"


@pytest.mark.parametrize("name", SAMPLES)
def test_each_kind_knows_its_own_and_no_other(name: str) -> None:
    kind, sample = SAMPLES[name]
    assert kind.is_ours(sample())
    others = {other: make() for other, (_, make) in SAMPLES.items() if other != name}
    others |= {other: text.encode("latin-1") for other, text in OTHERS.items()}
    assert [other for other, data in others.items() if kind.is_ours(data)] == []


def test_every_image_that_we_make_is_known(tokenizer: Tokenizer) -> None:
    for path in sorted(PROGRAMS.glob("*.bs?")):
        image = tokenizer.compile(path.read_text("utf-8"), path.name).image
        assert IMAGE.is_ours(image.eeprom), path.name
    image = tokenizer.compile("' {$STAMP BS2}\nEND\n", "it").image
    assert IMAGE.is_ours(image.eeprom)


def test_an_empty_file_is_anybodys(tmp_path: Path) -> None:
    """`mktemp` makes such ones."""
    (tmp_path / "x").touch()
    check_outputs([(tmp_path / "x", never("a log"))])


def test_force_does_not_lead_past_one_place_for_two(tmp_path: Path) -> None:
    kind: Any = begins("a thing", "x")
    pair = [(tmp_path / "x", kind), (tmp_path / "y" / ".." / "x", kind)]
    (tmp_path / "y").mkdir()
    with pytest.raises(SamePlaceError):
        check_outputs(pair, force=True)
    (tmp_path / "x").write_text("y")
    with pytest.raises(FolderError, match="is not a thing of cgagen's"):
        check_outputs(pair[:1])
    check_outputs(pair[:1], force=True)
