"""`cgagen emulate`: the files that it writes, those that it leaves alone, and what it refuses."""

import json
import re
from pathlib import Path
from typing import TextIO

import pytest

from cgagen.errors import StorageError
from cgagen.files import text_stream
from cgagen.tokenizer import Tokenizer
from cgagen.tokenizer.files import write_image
from tests.emulate_cases import BASIC, PREDATOR, PROGRAMS, Emulate, Program


def test_waveform_trace_and_coverage(emulate: Emulate, program: Program, tmp_path: Path) -> None:
    path = program(BASIC + "HIGH 3\nPAUSE 10\nLOW 3\nIF IN3 = 1 THEN LOW 4\n")
    files = [tmp_path / name for name in ("it.vcd", "it.csv", "it.info", "it.info.txt")]
    words = ("--vcd", files[0], "--trace", files[1], "--coverage", files[2])
    assert emulate(path, *words) == (0, "", "")
    first = [file.read_bytes() for file in files]
    wave, rows, info, listing = (data.decode() for data in first)
    assert " line $end\n" in wave
    assert "#147400\n" in wave
    assert "\nr4 " in wave
    assert rows.splitlines()[:3] == [
        "time_us,slot,bit,line,instruction",
        '0.000,0,14,3,"HIGH 3"',
        '147.400,0,30,4,"PAUSE 10"',
    ]
    assert rows.splitlines()[-1].endswith(',"END"')
    assert "DA:3,1\nDA:4,1\nDA:5,1\nDA:6,1\nLF:4\nLH:4\n" in info
    assert "BRDA:6,0,0,1\nBRDA:6,0,1,0\n" in info
    assert listing.startswith(f"coverage of {path}: 4 of 4 lines, 1 of 2 branches\n")
    assert emulate(path, *words) == (0, "", "")
    assert [file.read_bytes() for file in files] == first


def _fail_after(file: TextIO, path: Path) -> None:
    file.write("what led to it")
    assert not path.exists()
    raise KeyError


@pytest.mark.parametrize("option", ["--vcd", "--trace", "--coverage"])
def test_a_strangers_file_stays(option: str, emulate: Emulate, tmp_path: Path) -> None:
    stranger = tmp_path / "thesis.tex"
    stranger.write_text("precious")
    code, out, err = emulate(PROGRAMS / "hello.bs2", option, stranger)
    assert (code, out, stranger.read_text()) == (3, "", "precious")
    assert "--force" in err
    assert emulate(PROGRAMS / "hello.bs2", option, stranger, "--force")[0] == 0
    assert stranger.read_text() != "precious"


def test_the_listing_of_a_stranger_stays(emulate: Emulate, tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_text("precious")
    assert emulate(PROGRAMS / "hello.bs2", "--coverage", tmp_path / "a")[0] == 3
    assert not (tmp_path / "a").exists()


def test_two_files_of_one_name(emulate: Emulate, program: Program, tmp_path: Path) -> None:
    one = tmp_path / "one"
    for _ in range(2):
        assert emulate(PROGRAMS / "hello.bs2", "--vcd", one, "--trace", one)[0] == 2
        one.write_text("$timescale 1 ns $end\n")
    path = program(BASIC + "END\n")
    assert emulate(path, "--vcd", path, "--force")[0] == 2
    assert path.read_text() == BASIC + "END\n"


def test_a_folder_that_is_not_there(emulate: Emulate, tmp_path: Path) -> None:
    for option in ("--vcd", "--trace", "--coverage"):
        code, out, err = emulate(PROGRAMS / "hello.bs2", option, tmp_path / "no" / "file")
        assert (code, out, err.count("\n")) == (3, "", 1)
        assert "there is no folder" in err


def test_text_streams_are_whole_or_not_there(tmp_path: Path) -> None:
    path = tmp_path / "log"
    with pytest.raises(KeyError), text_stream(path) as file:
        _fail_after(file, path)
    assert path.read_text() == "what led to it"
    with pytest.raises(StorageError, match="cannot be written"), text_stream(tmp_path) as file:
        file.write("x")
    assert list(tmp_path.iterdir()) == [path]


# -- Errors -----------------------------------------------------------------------------------


def test_a_refused_source_is_located(emulate: Emulate, program: Program) -> None:
    code, out, err = emulate(program(BASIC + "HIHG 3\n"))
    assert (code, out, err.count("\n")) == (6, "", 1)
    assert "it.bs2:3:" in err


def test_a_broken_program_is_located(emulate: Emulate, program: Program, tmp_path: Path) -> None:
    path = program(BASIC + "FOR W0 = 2047 TO 1990\n  WRITE W0, $FF\nNEXT\n")
    trace = tmp_path / "it.csv"
    code, _, err = emulate(path, "--trace", trace)
    assert (code, err.count("\n")) == (3, 1)
    assert re.search(r"it\.bs2:\d: main: slot 0, ", err)
    assert trace.read_text().count("WRITE") > 3


def test_an_image_that_goes_astray_names_its_chip_once(emulate: Emulate, tmp_path: Path) -> None:
    image = tmp_path / "it.bin"
    image.write_bytes(b"\xff" * 2048)
    code, _, err = emulate(image, "--model", "BS2")
    assert (code, err.count("\n"), err.count("main:")) == (3, 1, 1)


def test_a_short_circuit_is_located(emulate: Emulate, program: Program) -> None:
    program(BASIC + "HIGH 1\nLOW 2\n")
    bench = program(
        'format = "cgagen-bench-1"\n[chip.main]\nsource = "it.bs2"\n'
        '[wire.x]\nends = ["main.P1", "main.P2"]\n',
        "it.toml",
    )
    code, _, err = emulate(bench)
    assert (code, err.count("\n")) == (3, 1)
    assert "it.bs2:4: " in err
    assert "main.P1 drives 1" in err


@pytest.mark.parametrize(
    ("words", "code"),
    [
        (("no.bs2",), 6),
        (("no.toml",), 3),
        (("no.bin",), 3),
        ((PROGRAMS / "hello.bs2", "--model", "BS2p"), 2),
        ((PROGRAMS / "hello.bs2", "--model", "BS9"), 3),
        ((PROGRAMS / "count.toml", "--model", "BS2"), 2),
        ((PROGRAMS / "hello.bs2", "--for", "soon"), 2),
        ((PROGRAMS / "hello.bs2", "--for", "-1s"), 2),
        ((PROGRAMS / "hello.bs2", "--for", "0"), 2),
        ((PROGRAMS / "hello.bs2", "--for", "1s", "--until-end"), 2),
        ((PREDATOR / "main.bin", "--chip", "legs"), 3),
    ],
)
def test_what_cannot_be(words: tuple[object, ...], code: int, emulate: Emulate) -> None:
    found, out, err = emulate(*words)
    assert (found, out) == (code, "")
    assert "Traceback" not in err
    assert "bug of ours" not in err


def test_coverage_wants_a_source(
    emulate: Emulate, program: Program, tokenizer: Tokenizer, tmp_path: Path
) -> None:
    image = tmp_path / "it.bin"
    write_image(image, tokenizer.compile(BASIC + "END\n").image)
    code, _, err = emulate(image, "--model", "BS2", "--coverage", tmp_path / "it.info")
    assert (code, "wants the source" in err) == (2, True)


# -- Durations --------------------------------------------------------------------------------

ROUTINES = (
    BASIC + "GOSUB Walk\nGOSUB Walk\nEND\nWalk:\nPAUSE 20\nGOSUB Stand\nRETURN\nStand:\nRETURN\n"
)


def test_durations_are_a_table_on_stderr(emulate: Emulate, program: Program) -> None:
    source = program(ROUTINES)
    code, out, err = emulate(source, "--durations")
    assert (code, out) == (0, "")
    rows = [line.split() for line in err.splitlines()]
    assert emulate(source, "--durations", " , Walk , ")[2].splitlines() == err.splitlines()[:2]
    assert rows[0] == ["label", "slot", "reached", "times", "best_us", "mean_us", "worst_us"]
    assert [row[:4] for row in rows[1:]] == [
        ["Walk", "0", "GOSUB", "2"],
        ["Stand", "0", "GOSUB", "2"],
    ]
    assert 20_000 < float(rows[1][4]) == float(rows[1][6]) < 22_000
    code, _, err = emulate(source, "--durations", "stand")
    assert (code, len(err.splitlines())) == (0, 2)
    code, _, err = emulate(source, "--durations=Walk,Run")
    assert (code, err.count("\n")) == (3, 1)
    assert "no label Run" in err


def test_durations_before_the_file(emulate: Emulate) -> None:
    code, _, err = emulate("--durations", PROGRAMS / "hello.bs2")
    assert code == 2
    assert "Missing argument 'FILE'; --durations took it for labels, so put that behind" in err
    assert "labels" not in emulate()[2]


def test_no_durations_are_said(emulate: Emulate, program: Program) -> None:
    code, out, err = emulate(program(BASIC + "Main:\nPAUSE 5\nEND\n"), "--durations")
    assert (code, out, err.count("\n")) == (0, "", 1)
    assert "no labelled routine has come to its end" in err


def test_durations_in_json(emulate: Emulate, program: Program) -> None:
    code, out, err = emulate(program(ROUTINES), "--json", "--durations=Walk")
    assert (code, err) == (0, "")
    (row,) = json.loads(out)["durations"]
    assert (row["label"], row["called"], row["times"], row["slot"]) == ("Walk", True, 2, 0)
    assert row["best_ns"] == row["mean_ns"] == row["worst_ns"] > 20_000_000
