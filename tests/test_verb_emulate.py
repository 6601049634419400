"""`cgagen emulate` as a user calls it."""

import json
import os
import pty
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from typing import TextIO

import pytest

from cgagen.cli import main
from cgagen.emulator.conversation import Conversation
from cgagen.emulator.programs import bench_of_sources
from cgagen.emulator.screen import Screen
from cgagen.emulator.session import Why, run_session
from cgagen.errors import StorageError
from cgagen.files import text_stream
from cgagen.tokenizer import Tokenizer
from cgagen.tokenizer.files import write_image
from cgagen.verbs import emulate_bench
from cgagen.verbs.keyboard import from_stdin

PROGRAMS = Path(__file__).parent / "programs"
PREDATOR = Path(__file__).parent.parent / "firmware" / "predator"

BASIC = "' {$STAMP BS2}\n' {$PBASIC 2.5}\n"
ENDLESS = BASIC + 'DO\n  DEBUG "."\n  PAUSE 100\nLOOP\n'

Emulate = Callable[..., tuple[int, str, str]]


@pytest.fixture
def emulate(
    capfdbinary: pytest.CaptureFixture[bytes],
    tokenizer: Tokenizer,
    monkeypatch: pytest.MonkeyPatch,
) -> Emulate:
    """Call the verb; stdout is bytes as latin-1, so that CR stays CR.

    All calls share one tokenizer, because starting one takes most of a call's time.
    """
    monkeypatch.setattr(emulate_bench, "Tokenizer", lambda: nullcontext(tokenizer))

    def call(*words: object) -> tuple[int, str, str]:
        code = main(["emulate", *map(str, words)])
        out, err = capfdbinary.readouterr()
        return code, out.decode("latin-1"), err.decode()

    return call


@pytest.fixture
def program(tmp_path: Path) -> Callable[..., Path]:
    """Write a source."""

    def write(text: str, name: str = "it.bs2") -> Path:
        path = tmp_path / name
        path.write_text(text)
        return path

    return write


Program = Callable[..., Path]


# -- What can be run --------------------------------------------------------------------------


def test_a_source(emulate: Emulate) -> None:
    assert emulate(PROGRAMS / "hello.bs2", "--expect-end") == (0, "Hello, Stamp!\r", "")


def test_a_source_with_further_slots(emulate: Emulate) -> None:
    code, out, err = emulate(PROGRAMS / "run_slots.bs2", "--expect-end")
    assert (code, err) == (0, "")
    assert out.endswith("fleas = 259\r")


def test_a_bench(emulate: Emulate) -> None:
    assert emulate(PROGRAMS / "count.toml", "--expect-end") == (0, "0\r12\r", "")


def test_another_chip_of_a_bench(emulate: Emulate, program: Program) -> None:
    program(BASIC + 'DEBUG "one"\n', "one.bs2")
    program(BASIC + 'PAUSE 20\nDEBUG "two"\n', "two.bs2")
    bench = program(
        'format = "cgagen-bench-1"\n[chip.first]\nsource = "one.bs2"\n'
        '[chip.second]\nsource = "two.bs2"\n',
        "bench.toml",
    )
    assert emulate(bench) == (0, "one", "")
    assert emulate(bench, "--chip", "second") == (0, "two", "")
    code, out, err = emulate(bench, "--chip", "seconds")
    assert (code, out, err.count("\n")) == (3, "", 1)
    assert "did you mean second?" in err


def test_an_image_beside_its_source(
    emulate: Emulate, program: Program, tokenizer: Tokenizer
) -> None:
    source = program(BASIC + "DEBUG BIN1 IN3, CR\n")
    image = source.with_suffix(".bin")
    write_image(image, tokenizer.compile(source.read_text()).image)
    code, out, err = emulate(image)
    assert (code, out) == (0, "0\r")
    assert "it.bs2:3: P3 is read" in err
    source.unlink()
    code, out, err = emulate(image)
    assert (code, out) == (2, "")
    assert "--model" in err
    code, out, err = emulate(image, "--model", "bs2")
    assert (code, out) == (0, "0\r")
    assert "main: P3 is read" in err


def test_an_image_of_a_build_knows_its_model(emulate: Emulate) -> None:
    code, out, _ = emulate(PREDATOR / "main.bin", "--for", "300ms")
    assert (code, out[:22]) == (0, "#1 M servobot-predator")


def test_the_bench_of_a_build(emulate: Emulate) -> None:
    code, out, err = emulate(PREDATOR / "bench.toml", "--for", "2s")
    assert (code, err) == (0, "")
    assert re.search(r":0 F\d+ R\d+ L\d+ .*C\d", out)


# -- Ends, times, exit codes ------------------------------------------------------------------


@pytest.mark.parametrize(
    ("words", "milliseconds"), [(("--for", "250ms"), 250), (("--for", "0.25s"), 250), ((), 10_000)]
)
def test_the_time_is_over(
    words: tuple[str, ...], milliseconds: int, emulate: Emulate, program: Program
) -> None:
    code, out, _ = emulate(program(ENDLESS), "--json", *words)
    data = json.loads(out)
    assert (code, data["ended"], data["time_ns"]) == (0, "TIME", milliseconds * 1_000_000)
    dots = milliseconds / 102
    assert dots - 3 < len(data["output"]) < dots + 2


def test_no_end_where_one_is_expected(emulate: Emulate, program: Program) -> None:
    code, _, err = emulate(program(ENDLESS), "--for", "250ms", "--expect-end")
    assert code == 9
    assert "no END or STOP in 0.25 s" in err
    code, _, err = emulate(program(BASIC + "DO\nLOOP\n"), "--until-end", "--expect-end")
    assert code == 9
    assert "empty loop at" in err
    assert "it.bs2:4" in err


def test_stop_is_an_end(emulate: Emulate) -> None:
    code, out, _ = emulate(PROGRAMS / "stop.bs2", "--expect-end", "--json")
    assert (code, json.loads(out)["ended"]) == (0, "STOP")


def test_until_end_goes_past_ten_seconds(emulate: Emulate, program: Program) -> None:
    path = program(BASIC + 'PAUSE 15000\nDEBUG "late"\n')
    assert emulate(path)[1] == ""
    assert emulate(path, "--until-end") == (0, "late", "")


def test_what_nothing_can_bring_is_said(emulate: Emulate, program: Program) -> None:
    path = program(BASIC + 'DEBUG "a"\nSERIN 5, 84, [B0]\n')
    code, out, err = emulate(path, "--until-end", "--pin", "5=1")
    assert (code, out) == (0, "a")
    assert "it.bs2:4: the program waits for P5 to become 0" in err


def test_json_has_everything(emulate: Emulate, program: Program) -> None:
    code, out, err = emulate(program(BASIC + 'DEBUG "a", 200, DEC IN2, CR\n'), "--json")
    data = json.loads(out)
    assert (code, data["output"], data["floating"]) == (0, "a\xc80\r", ["main.P2"])
    assert (data["chip"], data["model"], data["ended"]) == ("main", "BS2", "END")
    assert data["instructions"] == 2
    assert "P2 is read" in err


# -- Pins -------------------------------------------------------------------------------------


def test_a_floating_pin_is_reported_once_with_its_line(emulate: Emulate, program: Program) -> None:
    path = program(BASIC + "FOR B0 = 1 TO 3\n  DEBUG BIN1 IN7\nNEXT\n")
    code, out, err = emulate(path)
    assert (code, out) == (0, "000")
    assert err.count("P7 is read") == 1
    assert "it.bs2:4: P7 is read, and nothing is wired to it: it reads 0" in err


@pytest.mark.parametrize("word", ["7=1", "P7=1", "main.P7=1"])
def test_a_held_pin(word: str, emulate: Emulate, program: Program) -> None:
    path = program(BASIC + "DEBUG BIN1 IN7\nLOW 7\nDEBUG BIN1 IN7\nINPUT 7\nDEBUG BIN1 IN7\n")
    assert emulate(path, "--pin", word) == (0, "101", "")


def test_pins_of_a_bench(emulate: Emulate) -> None:
    """P0 is on a wire with the other chip, which drives it: a resistor changes nothing."""
    assert emulate(PROGRAMS / "count.toml", "--pin", "0=0") == (0, "0\r12\r", "")


@pytest.mark.parametrize("word", ["16=1", "3", "3=2", "x=1", "=1", "3=", "-1=1", "nobody.P3=1"])
def test_wrong_pins(word: str, emulate: Emulate) -> None:
    code, out, err = emulate(PROGRAMS / "hello.bs2", "--pin", word)
    assert (code, out) == (3 if "nobody" in word else 2, "")
    assert "Traceback" not in err


# -- Input ------------------------------------------------------------------------------------


def test_input_waits_until_it_is_taken(emulate: Emulate, program: Program) -> None:
    path = program(
        BASIC + "PAUSE 500\nDEBUGIN DEC W0\nPAUSE 500\nDEBUGIN STR B4\\3\nDEBUG DEC W0, STR B4\\3\n"
    )
    assert emulate(path, "--input", "42 xyz", "--expect-end") == (0, "42xyz", "")


def test_in_real_time_input_is_not_held_back(
    emulate: Emulate, program: Program, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(time, "sleep", lambda _: None)
    path = program(BASIC + "PAUSE 500\nSERIN 16, 84, 500, None_, [B0]\nNone_:\nDEBUG DEC B0\n")
    assert emulate(path, "--input", "7") == (0, "55", "")
    assert emulate(path, "--input", "7", "--realtime") == (0, "0", "")


def test_echo(emulate: Emulate, program: Program) -> None:
    path = program(BASIC + 'DEBUG "?"\nDEBUGIN B0\nDEBUG B0 + 1\n')
    assert emulate(path, "--input", "a")[1] == "?b"
    assert emulate(path, "--input", "a", "--echo")[1] == "?ab"


def test_the_end_of_a_line_is_cr(emulate: Emulate, program: Program) -> None:
    path = program(BASIC + "DEBUGIN B0, B1, B2\nDEBUG DEC B0, DEC B1, DEC B2\n")
    assert emulate(path, "--input", "\n\r\nA")[1] == "131365"


def test_input_that_ends_too_early(emulate: Emulate) -> None:
    code, out, err = emulate(PROGRAMS / "debugin_bytes.bs2", "--input", "x", "--expect-end")
    assert (code, out) == (9, "got x\r")
    assert "debugin_bytes.bs2:8: the program waits for input that does not come" in err


def test_stdin_is_read_when_the_program_wants_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """An endless pipe does no harm."""
    reader, writer = os.pipe()
    os.write(writer, b"one\ntwo")
    with os.fdopen(reader) as stdin:
        monkeypatch.setattr(sys, "stdin", stdin)
        more = from_stdin(at_once=False, waits=lambda: pytest.fail("no terminal"))
        assert more(True) == b"one\rtwo"
        quick = from_stdin(at_once=True, waits=lambda: None)
        assert quick(True) == b""
        os.close(writer)
        assert more(False) is None


def test_a_pipe(tmp_path: Path) -> None:
    ran = cgagen(PROGRAMS / "echo_upper.bs2", given=b"Hello, pipe!.and what is left")
    assert ran.stdout == b"HELLO, PIPE!\rbye\r"
    assert (ran.returncode, ran.stderr) == (0, b"")


def test_a_closed_stdin() -> None:
    ran = cgagen(PROGRAMS / "echo_upper.bs2", "--for", "1s", stdin=subprocess.DEVNULL)
    assert (ran.returncode, ran.stdout) == (0, b"")
    assert b"waits for input" in ran.stderr


# -- Terminals and signals --------------------------------------------------------------------


def test_a_terminal_gets_its_own_codes(program: Program) -> None:
    path = program(BASIC + 'DEBUG CLS, "a", CRSRXY, 5, 7, "b", BKSP, CR, "c"\n')
    ours, theirs = pty.openpty()
    ran = subprocess.run(command(path), stdin=theirs, stdout=theirs, check=False, timeout=60)
    shown = os.read(ours, 1000)
    os.close(ours)
    os.close(theirs)
    assert ran.returncode == 0
    assert shown.replace(b"\r\r\n", b"\r\n") == b"\x1b[2J\x1b[Ha\x1b[8;6Hb\b \b\r\nc\r\n"


def test_a_user_is_asked_only_when_the_program_waits(program: Program) -> None:
    path = program(BASIC + "SERIN 16, 84, 20, Later, [B0]\nLater:\nDEBUGIN B1\nDEBUG B1 + 1\n")
    ours, theirs = pty.openpty()
    running = subprocess.Popen(
        command(path), stdin=theirs, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    assert running.stderr is not None
    assert running.stderr.readline() == b"\n"
    assert running.stderr.readline().startswith(b"(the program waits: type")
    os.write(ours, b"a\n")
    out, err = running.communicate(timeout=60)
    os.close(ours)
    os.close(theirs)
    assert (running.returncode, out, err) == (0, b"b", b"")


def test_every_control_code_makes_something() -> None:
    shown = Screen().shown(bytes([7, 9, 13, 3, 4, 5, 6, 10, 11, 12, 14, 2, 15, 3, 1, 16, 17, 200]))
    assert shown == (
        "\a\t\r\n\x1b[D\x1b[C\x1b[A\x1b[B\x1bD\x1b[K\x1b[J\x1b[3G\x1b[4d\x1b[H\x1b[2J\x1b[H\xc8"
    )


def test_ctrl_c_ends_cleanly(program: Program, tmp_path: Path) -> None:
    wave = tmp_path / "wave.vcd"
    path = program(ENDLESS)
    running = subprocess.Popen(
        command(path, "--realtime", "--until-end", "--vcd", wave),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    assert running.stdout is not None
    assert running.stdout.read(1) == b"."
    running.send_signal(signal.SIGINT)
    _, err = running.communicate(timeout=60)
    assert running.returncode == 130
    assert re.fullmatch(rb"cgagen: stopped by Ctrl-C at \d+\.\d{3} s\n", err)
    assert wave.read_text().startswith("$")
    assert sorted(each.name for each in tmp_path.iterdir()) == ["it.bs2", "wave.vcd"]


# -- Files ------------------------------------------------------------------------------------


def test_waveform_trace_and_coverage(emulate: Emulate, program: Program, tmp_path: Path) -> None:
    path = program(BASIC + "HIGH 3\nPAUSE 10\nLOW 3\nIF IN3 = 1 THEN LOW 4\n")
    files = [tmp_path / name for name in ("it.vcd", "it.csv", "it.info", "it.info.txt")]
    words = ("--vcd", files[0], "--trace", files[1], "--coverage", files[2])
    assert emulate(path, *words) == (0, "", "")
    first = [file.read_bytes() for file in files]
    wave, rows, info, listing = (data.decode() for data in first)
    assert " line $end\n" in wave
    assert "#150000\n" in wave
    assert "\nr4 " in wave
    assert rows.splitlines()[:3] == [
        "time_us,slot,bit,line,instruction",
        '0.000,0,14,3,"HIGH 3"',
        '150.000,0,30,4,"PAUSE 10"',
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
    assert emulate(PROGRAMS / "hello.bs2", "--vcd", one, "--trace", one)[0] == 2
    path = program(BASIC + "END\n")
    assert emulate(path, "--vcd", path, "--force")[0] == 2
    assert path.read_text() == BASIC + "END\n"


def test_a_folder_that_is_not_there(emulate: Emulate, tmp_path: Path) -> None:
    for option in ("--vcd", "--trace", "--coverage"):
        code, _, err = emulate(PROGRAMS / "hello.bs2", option, tmp_path / "no" / "file")
        assert (code, err.count("\n")) == (3, 1)


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


# -- Sessions of the library ------------------------------------------------------------------


def test_a_session_repeats_exactly(tokenizer: Tokenizer) -> None:
    compiled = tokenizer.compile((PROGRAMS / "debugin_strings.bs2").read_text())
    typed = (PROGRAMS / "debugin_strings.in").read_bytes()
    seen = []
    for _ in range(2):
        bench = bench_of_sources({0: compiled})
        chip, heard, left = bench.chip("main"), [], [typed]
        conversation = Conversation(
            bench,
            chip,
            lambda byte, heard=heard, bench=bench: heard.append((bench.clock.now_ns, byte)),
            lambda _, left=left: left.pop() if left else None,
        )
        outcome = run_session(bench, chip, conversation)
        assert outcome.why is Why.END
        seen.append((heard, outcome))
    assert seen[0] == seen[1]


def command(path: Path, *words: object) -> list[str]:
    return [sys.executable, "-m", "cgagen", "emulate", str(path), *map(str, words)]


def cgagen(
    path: Path, *words: object, given: bytes | None = None, stdin: int | None = None
) -> "subprocess.CompletedProcess[bytes]":
    return subprocess.run(
        command(path, *words),
        input=given,
        stdin=stdin,
        capture_output=True,
        check=False,
        timeout=60,
    )


# -- Durations --------------------------------------------------------------------------------

ROUTINES = (
    BASIC + "GOSUB Walk\nGOSUB Walk\nEND\nWalk:\nPAUSE 20\nGOSUB Stand\nRETURN\nStand:\nRETURN\n"
)


def test_durations_are_a_table_on_stderr(emulate: Emulate, program: Program) -> None:
    source = program(ROUTINES)
    code, out, err = emulate(source, "--durations")
    assert (code, out) == (0, "")
    rows = [line.split() for line in err.splitlines()]
    assert rows[0] == ["label", "slot", "reached", "times", "best_us", "mean_us", "worst_us"]
    assert [row[:4] for row in rows[1:]] == [
        ["walk", "0", "GOSUB", "2"],
        ["stand", "0", "GOSUB", "2"],
    ]
    assert 20_000 < float(rows[1][4]) == float(rows[1][6]) < 22_000
    code, _, err = emulate(source, "--durations", "stand")
    assert (code, len(err.splitlines())) == (0, 2)
    code, _, err = emulate(source, "--durations=Walk,Run")
    assert (code, err.count("\n")) == (3, 1)
    assert "no label Run" in err


def test_durations_in_json(emulate: Emulate, program: Program) -> None:
    code, out, err = emulate(program(ROUTINES), "--json", "--durations=Walk")
    assert (code, err) == (0, "")
    (row,) = json.loads(out)["durations"]
    assert (row["label"], row["called"], row["times"], row["slot"]) == ("walk", True, 2, 0)
    assert row["best_ns"] == row["mean_ns"] == row["worst_ns"] > 20_000_000
