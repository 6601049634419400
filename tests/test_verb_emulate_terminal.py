"""`cgagen emulate` as a program of its own: pipes, terminals and Ctrl-C."""

import os
import pty
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from cgagen.emulator.screen import Screen
from cgagen.verbs.keyboard import from_stdin
from tests.emulate_cases import BASIC, ENDLESS, PROGRAMS, Program


def test_stdin_is_read_when_the_program_wants_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """An endless pipe does no harm, and the rest of it is others'."""
    reader, writer = os.pipe()
    os.write(writer, b"one\ntwo")
    with os.fdopen(reader) as stdin:
        monkeypatch.setattr(sys, "stdin", stdin)
        more = from_stdin(at_once=False, waits=lambda: pytest.fail("no terminal"))
        assert [more(True) for _ in range(5)] == [b"o", b"n", b"e", b"\r", b"t"]
        quick = from_stdin(at_once=True, waits=lambda: None)
        assert quick(True) == b"wo"
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
        stdin=subprocess.DEVNULL,
    )
    assert running.stdout is not None
    assert running.stdout.read(1) == b"."
    running.send_signal(signal.SIGINT)
    _, err = running.communicate(timeout=60)
    assert running.returncode == 130
    assert re.fullmatch(rb"cgagen: stopped by Ctrl-C at \d+\.\d{3} s\n", err)
    assert wave.read_text().startswith("$")
    assert sorted(each.name for each in tmp_path.iterdir()) == ["it.bs2", "wave.vcd"]


def test_a_reader_that_leaves_is_no_bug(program: Program) -> None:
    running = subprocess.Popen(
        command(program(ENDLESS), "--until-end"),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        stdin=subprocess.DEVNULL,
    )
    assert running.stdout is not None
    assert running.stderr is not None
    assert running.stdout.read(1) == b"."
    running.stdout.close()
    assert (running.wait(timeout=60), running.stderr.read()) == (141, b"")
    running.stderr.close()


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
