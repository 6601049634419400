"""Signals that ask for the end clean up as Ctrl-C does, and the exit code says which it was."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from cgagen.signals import Asked, held, signals_end
from cgagen.temporaries import is_temporary

FIRMWARE = Path(__file__).parent.parent / "firmware"

FOREVER = """' {$STAMP BS2}
again:
  TOGGLE 3
  GOTO again
"""

ENDS = pytest.mark.parametrize(
    ("number", "code"),
    [(signal.SIGTERM, 143), (signal.SIGHUP, 129), (signal.SIGINT, 130)],
    ids=["term", "hup", "int"],
)


def begun(folder: Path, *words: object, ready: Callable[[], bool]) -> subprocess.Popen[str]:
    """Begin a verb, and wait until it is at its work."""
    process = subprocess.Popen(
        [sys.executable, "-m", "cgagen", *map(str, words)],
        cwd=folder,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    until_s = time.monotonic() + 120
    while process.poll() is None and not ready():
        assert time.monotonic() < until_s, "it has not begun"
        time.sleep(0.02)
    return process


def temporaries(folder: Path) -> list[str]:
    return [name for name in os.listdir(folder) if is_temporary(name)]


@ENDS
def test_emulate_keeps_what_it_has_and_nothing_else(tmp_path: Path, number: int, code: int) -> None:
    """A waveform up to there is whole, as after Ctrl-C, which this verb takes for its end."""
    (tmp_path / "it.bs2").write_text(FOREVER)
    words = ("emulate", "it.bs2", "--until-end", "--vcd", "it.vcd", "--trace", "it.csv")
    with begun(tmp_path, *words, ready=lambda: len(temporaries(tmp_path)) == 2) as process:
        time.sleep(0.3)
        process.send_signal(number)
        process.send_signal(number)  # as `timeout` does
        _, err = process.communicate(timeout=60)
    assert process.returncode == (130 if number == signal.SIGINT else code), err
    assert "Traceback" not in err
    assert sorted(os.listdir(tmp_path)) == ["it.bs2", "it.csv", "it.vcd"]
    assert "$enddefinitions $end\n" in (tmp_path / "it.vcd").read_text()
    assert all((tmp_path / name).read_text().endswith("\n") for name in ("it.vcd", "it.csv"))


@ENDS
def test_monitor_lets_its_port_go(tmp_path: Path, number: int, code: int) -> None:
    log = tmp_path / "it.log"
    words = ("monitor", "--port", f"emu:{FIRMWARE / 'prey'}", "--log", "it.log")
    with begun(tmp_path, *words, ready=lambda: log.exists() and log.stat().st_size > 0) as process:
        process.send_signal(number)
        out, err = process.communicate(timeout=60)
    assert process.returncode == (0 if number == signal.SIGINT else code), err
    assert log.read_bytes().decode("latin-1").replace("\r", "\n") in out.replace("\r", "\n")
    assert os.listdir(tmp_path) == ["it.log"]


def test_what_was_switched_off_stays_so(tmp_path: Path) -> None:
    """`nohup` is for that."""
    (tmp_path / "it.bs2").write_text(FOREVER)
    code = "import signal, sys; signal.signal(signal.SIGHUP, signal.SIG_IGN); "
    code += "from cgagen.cli import main; sys.exit(main(sys.argv[1:]))"
    process = subprocess.Popen(
        [sys.executable, "-c", code, "emulate", "it.bs2", "--until-end", "--vcd", "it.vcd"],
        cwd=tmp_path,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
    )
    while process.poll() is None and not temporaries(tmp_path):
        time.sleep(0.02)
    process.send_signal(signal.SIGHUP)
    time.sleep(0.3)
    assert process.poll() is None
    process.send_signal(signal.SIGTERM)
    process.communicate(timeout=60)
    assert process.returncode == 143


def test_a_second_wish_interrupts_the_cleaning_only_when_it_is_another() -> None:
    asked = Asked()
    with pytest.raises(KeyboardInterrupt):
        asked(signal.SIGTERM, None)
    asked(signal.SIGTERM, None)
    asked._last_s -= 10
    with pytest.raises(KeyboardInterrupt):
        asked(signal.SIGINT, None)
    assert (asked.name, asked.exit_code) == ("SIGTERM", 143)


def test_handlers_are_put_back() -> None:
    before = [signal.getsignal(one) for one in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)]
    asked = Asked()
    with signals_end(asked), pytest.raises(KeyboardInterrupt):
        os.kill(os.getpid(), signal.SIGTERM)
    assert asked.number == signal.SIGTERM
    after = [signal.getsignal(one) for one in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)]
    assert after == before


def test_what_is_held_is_put_off_and_not_lost() -> None:
    done = []

    def work() -> None:
        with held():
            with held():
                os.kill(os.getpid(), signal.SIGTERM)
                time.sleep(0.01)
            done.append("all of it")

    with signals_end(Asked()):
        with pytest.raises(KeyboardInterrupt):
            work()
        assert done
        with held():
            done.append("and the next is as ever")
    assert len(done) == 2


def test_a_signal_in_the_making_of_a_class_has_its_own_exit_code(tmp_path: Path) -> None:
    """CPython would make SIGINT of it: dataclasses and named tuples are made by `exec`."""
    (tmp_path / "it.py").write_text(
        "import os, sys, time\n"
        "from cgagen.verbs.ending import end\n"
        "from cgagen.signals import Asked, signals_end\n"
        "asked = Asked()\n"
        "with signals_end(asked):\n"
        "    try:\n"
        "        exec('os.kill(os.getpid(), 15); time.sleep(1)')\n"
        "    except BaseException as error:\n"
        "        sys.exit(end(error, [], asked))\n"
    )
    done = subprocess.run(
        [sys.executable, "-m", "it"],
        cwd=tmp_path,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        check=False,
        timeout=60,
    )
    assert (done.returncode, b"stopped by SIGTERM" in done.stderr) == (143, True)
