"""`cgagen info`: every sort of file of ours is described, and what is none of ours is told."""

import json
import os
import shutil
import struct
import zlib
from pathlib import Path

import pytest

from cgagen.cli import main
from cgagen.inputs import start_of
from cgagen.verbs.info_sorts import Sort
from cgagen.verbs.info_tables import TABLES
from hil import traces
from hil.decisions import Decision, write_decisions
from hil.kills import record_of, record_text
from hil.target import Observation, Stimulus
from tests.subjects import FIRMWARE, subject

PREDATOR = FIRMWARE / "predator"
SHIPPED = Path(traces.__file__).parent
TEMPLATES = FIRMWARE.parent / "templates"


def told(capfd: pytest.CaptureFixture[str], *words: str | Path) -> tuple[int, str, str]:
    code = main(["info", *map(str, words)])
    out, err = capfd.readouterr()
    return code, out, err


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with one file of every sort that the verbs write."""
    folder = tmp_path_factory.mktemp("made")
    small = ["--generations", "3", "--population", "8", "--fixed-starts", "4", "--starts", "2"]
    assert main(["evolve", "--run", str(folder / "run"), *small]) == 0
    words = ["--vcd", "a.vcd", "--trace", "a.csv", "--coverage", "a.info", "--for", "20ms"]
    words = [str(folder / word) if word.startswith("a.") else word for word in words]
    assert main(["emulate", str(PREDATOR), "--input", "", *words]) == 0
    assert main(["compile", str(PREDATOR / "main.bsp"), "--map", str(folder / "map.csv")]) == 0
    (folder / "reports").mkdir()
    report = ["--report", str(folder / "reports"), "--report", str(folder / "v.html")]
    main(["verify", "--build", str(PREDATOR), "--reading", "0,0,0/--/0,0", *report])
    write_decisions(folder / "d.jsonl", [Decision(Stimulus((7,)), Observation(1, 3, 0))] * 3)
    (folder / "kills.json").write_text(record_text(record_of(subject("predator"), [])))
    (folder / "marks.csv").write_text("sensor,distance_in,count\nfront,24,4425\nfront,24,4431\n")
    (folder / "walks.csv").write_text("movement,cycles,along_cm,right_cm,turn_deg\nWAIT,1,0,0,0\n")
    shutil.copy(folder / "run" / "0-run.toml", folder / "copy.toml")
    shutil.copy(PREDATOR / "build.json", folder / "copy.json")
    (folder / "bare.genome").write_text("001 " * 64)
    return folder


CASES: tuple[tuple[str, str, str], ...] = (
    # file, `kind`, a part of the text
    ("servobot-prey", "robot", "the prey servobot-prey, BS2p and BS2"),
    ("colony", "arena", "the arena colony, 300 x 300 units"),
    ("MADE/run", "run", "a run, seed 1, 1 trial(s) of 3 generations"),
    ("MADE/run/0-run.toml", "run", "a run, seed 1"),
    ("MADE/run/1-predator.toml", "robot", "the predator servobot-predator"),
    ("MADE/run/1-arena.toml", "arena", "the arena colony"),
    ("MADE/run/2-fitness.csv", "reports_csv", "on the fixed starts, 2 generations from 1 to 3"),
    ("MADE/run/2-training.csv", "reports_csv", "its own random starts, 3 generations from 1 to"),
    ("MADE/run/2-population-g001.csv", "population", "a population of 8, 8 of them different"),
    ("MADE/run/2-checkpoint.npz", "checkpoint", "trial 1 after generation 3, population 8"),
    ("MADE/run/best.genome", "genome", "a genome for servobot-predator"),
    ("MADE/bare.genome", "genome", "a genome for servobot-predator"),
    ("MADE/copy.toml", "record", "the settings of a run, seed 1"),
    ("MADE/copy.json", "build_record", "what a build of servobot-predator holds, genome 8e241ca1"),
    ("MADE/a.vcd", "waveform", "a waveform of 61 signals"),
    ("MADE/a.csv", "instructions", " instructions, the last at "),
    ("MADE/a.info", "coverage", "main.bsp: 5 of 163 lines"),
    ("MADE/a.info.txt", "listing", "5 of 163 lines"),
    ("MADE/map.csv", "source_map", " statements"),
    ("MADE/reports", "reports", "robots: servobot-predator "),
    ("MADE/reports/hil-report.json", "report", "again: cgagen verify --build"),
    ("MADE/v.html", "page", "a report's page, "),
    ("MADE/d.jsonl", "decisions", "3 decisions in 1 states"),
    ("MADE/kills.json", "kills", "0 of 0 mutants killed, 0 survive"),
    ("MADE/marks.csv", "measurements", "2 measurements (front 2)"),
    ("MADE/walks.csv", "measurements", "1 measurements (WAIT 1)"),
    (f"{PREDATOR}", "build", "main.bsp (BS2p): 2048 bytes"),
    (f"{PREDATOR / 'build.json'}", "build", "main.bsp (BS2p): 2048 bytes"),
    (f"{PREDATOR / 'bench.toml'}", "bench", "chips main main.bsp, locomotion locomotion.bs2; 20"),
    (f"{PREDATOR / 'memory.txt'}", "memory", "what main.bsp (BS2p) and locomotion.bs2 (BS2) take"),
    (f"{PREDATOR / 'wiring.txt'}", "wiring", "wiring of servobot-predator, a predator: 27 pins"),
    (f"{PREDATOR / 'main.bsp'}", "source", "a PBASIC source for a BS2p"),
    (f"{PREDATOR / 'main.bin'}", "image", "an image for a BS2p"),
    (f"{SHIPPED / 'hunt.log'}", "trace", "54 readings, 54 decisions"),
    (f"{SHIPPED / 'vectors.csv'}", "trace", "18 readings, 18 decisions by hand"),
    (f"{SHIPPED / 'hunt.log.json'}", "sidecar", "says of hunt.log that it holds 54 readings"),
    (f"{SHIPPED / 'rig.dbc'}", "frames", "for CAN tools, as this version has it"),
    (f"{TEMPLATES / '_sense.j2'}", "template", "a template of PBASIC"),
)


@pytest.mark.parametrize(("name", "kind", "said"), CASES, ids=[case[0][-24:] for case in CASES])
def test_a_file_of_ours_is_described(
    made: Path, capfd: pytest.CaptureFixture[str], name: str, kind: str, said: str
) -> None:
    name = name.replace("MADE", str(made))
    code, out, err = told(capfd, name)
    assert (code, said in out) == (0, True), (out, err)
    code, out, _ = told(capfd, name, "--json")
    assert (code, json.loads(out)["kind"]) == (0, kind)


def test_every_sort_has_a_case() -> None:
    apart = {"RUN", "BUILD", "ROBOT", "ARENA", "GENOME", "IMAGE", "SOURCE", "TRACE"}
    assert {kind.upper() for _, kind, _ in CASES} == {sort.name for sort in Sort}
    assert {sort.name for sort in Sort} - {sort.name for sort in TABLES} == apart


def png() -> bytes:
    head = struct.pack(">IIBBBBB", 1, 1, 8, 0, 0, 0, 0)
    chunk = b"IHDR" + head
    return (
        b"\x89PNG\r\n\x1a\n" + struct.pack(">I", 13) + chunk + struct.pack(">I", zlib.crc32(chunk))
    )


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("x.png", png(), "seems to be a PNG picture"),
        ("x.jpg", b"\xff\xd8\xff\xe0JFIF", "a JPEG picture"),
        ("x.svg", b"<svg xmlns='x'></svg>", "an SVG picture"),
        ("x.pdf", b"%PDF-1.4", "a PDF document"),
        ("x", b"\x7fELF\x02\x01\x01\0", "a program"),
        ("x.zip", b"PK\x03\x04\x14\0", "a ZIP archive"),
        ("x.gz", b"\x1f\x8b\x08\0", "packed by gzip"),
        ("x.npy", b"\x93NUMPY\x01\0", "a NumPy array"),
        ("x.html", b"<!DOCTYPE html><html><title>Shop</title></html>", "a web page"),
        ("x.json", b'{"name": "left-pad"}', "JSON"),
        ("x.xml", b"<?xml version='1.0'?>", "XML"),
        ("x.toml", b"[tool]\nx = 1\n", "TOML without a format of ours (cgagen-arena-1, "),
        ("x.toml", b'format = "other-robot-2"\n', "TOML of the format other-robot-2"),
        ("x.txt", b"Dear all,\n", "seems to be text, none of ours"),
        ("x.txt", "Stra\u00dfe".encode("cp1252"), "text that is not UTF-8"),
        ("x.txt", "Dear".encode("utf-16"), "UTF-16"),
        ("x.dat", b"\0\1\2", "binary data"),
        ("x.sh", b"#!/bin/sh\n", "a script"),
        ("x.toml", b"", "x.toml: is empty"),
        ("x.genome", b" \n\t\n", "holds nothing but blanks"),
    ],
)
def test_what_is_none_of_ours_is_told_by_what_it_seems(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], name: str, content: bytes, said: str
) -> None:
    (tmp_path / name).write_bytes(content)
    code, out, err = told(capfd, tmp_path / name)
    assert (code, out) == (3, "")
    assert said in err
    assert "name a genome, a run, a build" in err


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("x.csv", b"generation,mean,best,worst,captured\n1,2\n"),
        ("x.csv", b"generation,mean,best,worst,captured\n1,a,b,c,d\n"),
        ("x.csv", b"individual,training_fitness,fixed_fitness,fixed_captured,bits\n"),
        ("x.json", b'{\n "format": "cgagen-hil-report-1"'),
        ("x.json", b'{\n "format": "cgagen-kills-1", "rows": [1]}'),
        ("x.json", b'{"format": "cgagen-trace-1", "robot": 3, "readings": 1}'),
        ("x.json", b'{"format": "cgagen-build-1"}'),
        ("x.toml", b'format = "cgagen-run-1"\n'),
        ("x.toml", b'format = "cgagen-bench-1"\nchip = 3\n'),
        ("x.toml", b'format = "cgagen-robot-1"\n'),
        ("x.toml", b'format = "cgagen-arena-1"\nname = 1\n'),
        ("x.npz", b"PK\x03\x04" + b"\0" * 22 + b"\x0a\0\0\0format.npy"),
        ("x.jsonl", b'{"seq": 1, "reading": "7/--"}\n'),
        ("x.genome", b'format = "cgagen-genome-1"\nbits = "2"\n'),
    ],
)
def test_a_damaged_file_of_ours_is_a_sentence(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], name: str, content: bytes
) -> None:
    (tmp_path / name).write_bytes(content)
    code, out, err = told(capfd, tmp_path / name)
    assert (code, out, "bug of ours" in err) == (3, "", False)
    assert name in err


def test_what_is_not_there_or_no_file(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "hunter.genome").touch()
    assert "(did you mean hunter.genome?)" in told(capfd, tmp_path / "huntr.genome")[2]
    assert "(did you mean servobot-prey?)" in told(capfd, "servobot-pray")[2]
    code, _, err = told(capfd, tmp_path)
    assert (code, "neither a run nor a build (it holds hunter.genome)" in err) == (3, True)
    os.mkfifo(tmp_path / "pipe")
    assert "is a pipe" in told(capfd, tmp_path / "pipe")[2]
    code, _, err = told(capfd, "x" * 300)
    assert (code, "cannot be looked at (File name too long)" in err) == (3, True)


def test_a_file_is_meant_before_a_name(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    text = (FIRMWARE / "prey" / "robot.toml").read_text()
    Path("servobot-prey").write_text(text.replace('"servobot-prey"', '"mine"', 1))
    assert "the prey mine" in told(capfd, "servobot-prey")[1]


def test_options_say_something_or_are_refused(capfd: pytest.CaptureFixture[str]) -> None:
    code, _, err = told(capfd, "servobot-prey", "--model", "BS2")
    assert (code, "--model says nothing about a robot" in err) == (2, True)
    assert start_of(PREDATOR / "main.bin", 4) is not None
