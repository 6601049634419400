"""How a call ends: a sentence, an exit code, and nothing raw on the terminal."""

import errno
import os
import stat
import subprocess
import sys
import unicodedata
from pathlib import Path

import click
import pytest

from cgagen.cli import main
from cgagen.errors import GenomeError
from cgagen.verbs.ending import end
from tests.subjects import FIRMWARE, subject

EVIL = "\x1b[31mred\x1b]0;title\x07\x9b2J\r\u202eback\x7f[red]"


def calm(text: str) -> bool:
    """Whether every character takes a place; `[red]` is text, and no markup either."""
    return not any(
        unicodedata.category(one) in {"Cc", "Cf", "Zl", "Zp", "Cs"} and one not in "\n\t"
        for one in text
    )


# -- Errors -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("error", "code", "words"),
    [
        (GenomeError(f"{EVIL}: is none"), 3, r"cgagen: \x1b[31mred"),
        (GenomeError("x" * 70_000), 3, "70,000 characters"),
        (click.UsageError(f"no {EVIL}"), 2, r"Error: no"),
        (click.UsageError("y" * 70_000), 2, "70,000 characters"),
        (KeyboardInterrupt(), 130, "stopped by Ctrl-C"),
        (click.Abort(), 130, "stopped by Ctrl-C"),
        (OSError(errno.ENAMETOOLONG, "File name too long", "n" * 300), 3, "File name too long"),
        (OSError(errno.EFBIG, "File too large", "a.vcd"), 3, "a.vcd: the system refuses it (File"),
        (PermissionError(13, "Permission denied", b"b\xff"), 3, r"b\udcff: the system refuses it"),
        (MemoryError(), 3, "the memory does not suffice"),
        (click.exceptions.Exit(5), 5, ""),
    ],
)
def test_each_end_has_its_sentence_and_its_code(error, code, words, capsys) -> None:
    assert end(error, []) == code
    told = capsys.readouterr().err
    assert words in told
    assert calm(told)
    assert len(told) < 5_000


def test_an_end_of_a_file_is_no_ctrl_c(monkeypatch, tmp_path, capsys) -> None:
    """A damaged cache ended as `stopped by Ctrl-C`, 130: click makes one of the other."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))

    def verb(**_given: object) -> None:
        raise EOFError("Ran out of input")

    monkeypatch.setattr("cgagen.verbs.info._genome", lambda *_words: verb())
    assert main(["info", str(FIRMWARE / "reference.genome")]) == 1
    assert "a bug of ours (EOFError: Ran out of input)" in capsys.readouterr().err


@pytest.fixture
def bug(monkeypatch, tmp_path) -> Path:
    """A verb with a bug, and where its report will be."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))

    def broken(*_words: object) -> None:
        raise ZeroDivisionError(f"planted {EVIL} {'z' * 70_000}")

    monkeypatch.setattr("cgagen.verbs.info._genome", broken)
    return tmp_path / "state" / "cgagen"


def test_a_bug_of_ours_leaves_its_traceback_in_a_file_of_the_users(bug, capsys) -> None:
    words = ["info", str(FIRMWARE / "reference.genome")]
    assert main(words) == main(words) == 1
    told = capsys.readouterr().err
    assert "Traceback" not in told
    assert calm(told)
    assert len(told) < 2_000
    reports = sorted(bug.iterdir())
    assert len(reports) == 2  # nothing is overwritten
    for report in reports:
        assert str(report) in told
        assert stat.S_IMODE(report.stat().st_mode) == 0o600
        text = report.read_text("utf-8")
        assert "ZeroDivisionError: planted" in text
        assert "in broken" in text
        assert calm(text)


@pytest.mark.parametrize("place", [0, 1, 2])
def test_the_traceback_is_printed_where_v_stands_anywhere(bug, capsys, place) -> None:
    words = ["info", str(FIRMWARE / "reference.genome")]
    words.insert(place, "-v")
    assert main(words) == 1
    told = capsys.readouterr().err
    assert "Traceback" in told
    assert "in broken" in told
    assert calm(told)
    assert not bug.exists()


def test_a_bug_is_told_where_no_file_can_be_written(bug, capsys, monkeypatch) -> None:
    def refuse(*_words: object, **_more: object) -> tuple[int, str]:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("tempfile.mkstemp", refuse)
    assert main(["info", str(FIRMWARE / "reference.genome")]) == 1
    assert "run it again with -v for the details" in capsys.readouterr().err


def test_a_full_disk_behind_stdout() -> None:
    full = Path("/dev/full")
    if not full.is_char_device():
        pytest.skip("this system has no /dev/full")
    with full.open("w") as out:
        ran = subprocess.run(
            [sys.executable, "-m", "cgagen", "info", str(FIRMWARE / "prey" / "robot.toml")],
            stdout=out,
            stderr=subprocess.PIPE,
            stdin=subprocess.DEVNULL,
            check=False,
        )
    assert ran.returncode == 3
    assert b"No space left on device" in ran.stderr
    assert b"Exception ignored" not in ran.stderr


# -- What others have written -----------------------------------------------------------------


def hostile_robot(folder: Path) -> Path:
    text = (FIRMWARE / "predator" / "robot.toml").read_text("utf-8")
    name = "".join(f"\\u{ord(one):04x}" for one in EVIL)
    path = folder / "evil.toml"
    path.write_text(text.replace('name = "servobot-predator"', f'name = "{name}"'), "utf-8")
    return path


def named(folder: Path, source: Path, suffix: str) -> Path:
    path = folder / (EVIL.replace("/", "") + suffix)
    path.write_bytes(source.read_bytes())
    return path


def copied(folder: Path, changes: dict[str, bytes]) -> Path:
    build = folder / "build"
    build.mkdir()
    for path in (FIRMWARE / "predator").iterdir():
        (build / path.name).write_bytes(path.read_bytes() + changes.get(path.name, b""))
    return build


def bad_key(folder: Path) -> Path:
    path = folder / "key.toml"
    path.write_text('"' + "".join(f"\\u{ord(one):04x}" for one in EVIL) + '" = 1\n', "utf-8")
    return path


CALLS = {
    "a robot's name": lambda f: ["info", str(hostile_robot(f))],
    "a file's name": lambda f: ["info", str(named(f, FIRMWARE / "reference.genome", ".genome"))],
    "a missing file": lambda f: ["info", str(f / EVIL)],
    "a table": lambda f: ["info", str(copied(f, {"memory.txt": EVIL.encode()}))],
    "a damaged build": lambda f: ["info", str(copied(f, {"build.json": EVIL.encode()}))],
    "a key": lambda f: ["info", str(bad_key(f))],
    "a verb": lambda f: [EVIL],
    "an option": lambda f: ["info", f"--{EVIL}"],
    "a choice": lambda f: ["info", "x", "--model", EVIL],
    "a trace": lambda f: ["trace", "show", str(named(f, FIRMWARE / "reference.genome", ".log"))],
    "a bench": lambda f: ["emulate", str(bad_key(f))],
    "a source": lambda f: ["compile", str(named(f, FIRMWARE / "reference.genome", ".bs2"))],
    "readings": lambda f: ["verify", str(FIRMWARE / "reference.genome"), "--reading", EVIL],
    "measurements": lambda f: ["calibrate", str(bad_key(f)), "--robot", "servobot-prey"],
}


@pytest.mark.parametrize("which", CALLS)
@pytest.mark.parametrize("as_json", [False, True])
def test_nothing_of_others_moves_the_cursor(which, as_json, tmp_path, capsys) -> None:
    words = CALLS[which](tmp_path)
    code = main([*words, "--json"] if as_json else words)
    told = capsys.readouterr()
    assert calm(told.out), told.out
    assert calm(told.err), told.err
    assert told.out or told.err
    assert code != 1


def test_the_bytes_of_a_program_stay_bytes_on_a_pipe(tmp_path) -> None:
    """On a terminal they are rendered (`cgagen.emulator.screen`), which lets no ESC through."""
    source = tmp_path / "say.bs2"
    source.write_text("' {$STAMP BS2}\nDEBUG 27, 91, 155, CR\nEND\n", "utf-8")
    ran = subprocess.run(
        [sys.executable, "-m", "cgagen", "emulate", str(source)],
        stdout=subprocess.PIPE,
        stdin=subprocess.DEVNULL,
        check=True,
        env=os.environ | {"PYTHONPATH": str(FIRMWARE.parent)},
    )
    assert ran.stdout == b"\x1b[\x9b\r"


def test_the_subject_of_these_tests_is_there() -> None:
    assert subject("predator").robot.name == "servobot-predator"
