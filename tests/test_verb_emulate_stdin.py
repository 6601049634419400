"""What a run reads is what its user gave it, and a shell's loop keeps its list."""

import os
import pty
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from cgagen.verbs.keyboard import is_given, typed
from tests.emulate_cases import BASIC, PROGRAMS
from tests.output_cases import null_device
from tests.stamp_programs import unescaped

ECHO = BASIC + "again:\n  DEBUGIN B0\n  DEBUG B0\n  IF B0 <> 13 THEN again\n  END\n"
QUIET = BASIC + 'DEBUG "."\n'
BENCH = 'format = "cgagen-bench-1"\n[chip.main]\nsource = "echo.bs2"\n'


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "echo.bs2").write_text(ECHO)
    (tmp_path / "quiet.bs2").write_text(QUIET)
    (tmp_path / "bench.toml").write_text(BENCH)
    return tmp_path


def emulate(*words: object) -> str:
    return " ".join([sys.executable, "-m cgagen emulate --for 1s", *map(str, words)])


def shell(folder: Path, script: str, stdin: int | None = subprocess.DEVNULL) -> str:
    done = subprocess.run(
        ["bash", "-c", script],
        cwd=folder,
        stdin=stdin,
        capture_output=True,
        timeout=240,
        check=False,
    )
    assert b"bug of ours" not in done.stderr
    return done.stdout.decode("latin-1").replace("\r", "|")


@pytest.mark.parametrize("source", ["quiet.bs2", "echo.bs2", "bench.toml"])
@pytest.mark.parametrize("options", ["", "--realtime", "--json"])
def test_a_loop_runs_over_its_whole_list(folder: Path, source: str, options: str) -> None:
    (folder / "list").write_text("one\ntwo\nthree\nfour\n")
    run = emulate(source, options)
    said = shell(folder, f'while read f; do {run} >/dev/null; echo "$f"; done < list')
    assert said == "one\ntwo\nthree\nfour\n"


@pytest.mark.parametrize("source", ["quiet.bs2", "bench.toml"])
def test_a_loop_over_a_pipe_too(folder: Path, source: str) -> None:
    run = emulate(source)
    said = shell(
        folder, f'printf "1\\n2\\n3\\n" | while read f; do {run} > /dev/null; echo "$f"; done'
    )
    assert said == "1\n2\n3\n"


def test_no_more_is_taken_than_the_program_takes(folder: Path) -> None:
    """Of a pipe, and of a file that was named to be read."""
    run = emulate("echo.bs2")
    assert (
        shell(folder, f'printf "one\\ntwo\\nthree" | {{ {run}; {run}; cat; }}') == "one|two|three"
    )
    (folder / "text").write_text("one\ntwo\nthree\n")
    run = emulate("echo.bs2", "--input -")
    assert shell(folder, f"{{ {run}; {run}; cat; }} < text") == "one|two|three\n"


def test_what_was_given_is_read(folder: Path) -> None:
    (folder / "text").write_bytes("h\u00e9\n".encode())
    one, bench = emulate("echo.bs2"), emulate("bench.toml")
    assert shell(folder, f"{one} < text") == shell(folder, f"cat text | {one}") == "h\xe9|"
    for way in (f"{bench} < text", f"cat text | {bench}", f"{one} --realtime < text"):
        assert shell(folder, way) == ""
    assert shell(folder, f"{bench} --input - < text") == "h\xe9|"
    assert shell(folder, f"cat text | {bench} --input -") == "h\xe9|"
    assert shell(folder, f"{one} < /dev/null") == shell(folder, f"{one} <&-") == ""


def test_the_same_bytes_at_once_or_one_by_one(folder: Path) -> None:
    """Every program with input, through a pipe, sends what it sends when all of it is there."""
    tried = 0
    for path in sorted(PROGRAMS.glob("*.in"))[:6]:
        source, text = path.with_suffix(".bs2"), unescaped(path.read_text("utf-8"))
        words = [sys.executable, "-m", "cgagen", "emulate", str(source)]
        piped, given = (
            subprocess.run(
                [*words, *more], input=data, capture_output=True, timeout=60, check=True
            ).stdout
            for data, more in ((text, ()), (b"", ("--input", text.decode("cp1252"))))
        )
        assert piped == given == unescaped(path.with_suffix(".out").read_text("utf-8"))
        tried += 1
    assert tried == 6


def test_what_is_no_users_is_not_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def given(handle: int, at_once: bool = False) -> bool:
        with os.fdopen(os.dup(handle)) as stdin, monkeypatch.context() as inside:
            inside.setattr(sys, "stdin", stdin)
            return is_given(at_once)

    reading, writing = os.pipe()
    ours, theirs = pty.openpty()
    one, other = socket.socketpair()
    (tmp_path / "file").write_text("abc")
    file = os.open(tmp_path / "file", os.O_RDONLY)
    device = os.open(null_device(tmp_path / "null"), os.O_RDONLY)
    assert [given(handle) for handle in (reading, theirs, file)] == [True] * 3
    assert [given(handle, True) for handle in (reading, theirs, file)] == [False, True, False]
    os.read(file, 1)
    assert [given(handle) for handle in (file, one.fileno(), device)] == [False] * 3
    monkeypatch.setattr(sys, "stdin", None)
    assert not is_given(False)
    one.close()
    other.close()
    for handle in (reading, writing, ours, theirs, file, device):
        os.close(handle)
    assert typed("a\r\nb\nc") == b"a\rb\rc"
