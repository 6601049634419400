"""An emulated rig in a process of its own, and the command line that asks it."""

import re
import select
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator

import pytest
from click.testing import CliRunner

from cgagen.cli import main
from hil.rig import main as serve
from tests.subjects import FIRMWARE

WAIT_S = 60


@pytest.fixture(scope="module")
def served() -> Iterator[tuple[str, subprocess.Popen[str]]]:
    """A prey on a rig behind a serial adapter."""
    words = [sys.executable, "-m", "hil.rig", str(FIRMWARE / "prey"), "--slcan", "pty"]
    with subprocess.Popen(
        words, stdout=subprocess.PIPE, text=True, stdin=subprocess.DEVNULL
    ) as process:
        assert process.stdout is not None
        assert select.select([process.stdout], [], [], WAIT_S)[0]
        yield process.stdout.readline().strip(), process
        process.kill()


def test_verify_asks_a_rig_in_another_process(
    served: tuple[str, subprocess.Popen[str]], capsys: pytest.CaptureFixture[str]
) -> None:
    url, process = served
    assert url.startswith("can:slcan:/dev/")
    words = ["verify", "--build", str(FIRMWARE / "prey"), "--target", url]
    readings = ["--reading", "1000,0,0,0,0,0/--", "--reading", "0,0,0,0,0,0/LR"]
    assert main([*words, *readings]) == 11
    out = capsys.readouterr().out
    assert f"{url}: a rig sees no EEPROM; by its own banner" in out
    assert re.search(rf"\n{re.escape(url)} +PASS +2 +2 ", out)
    untried = ["cells", "movements", "timing", "conduct", "legs", "main bytes"]
    assert re.findall(r"\n(\w+(?: bytes)?) +NOT TRIED ", out) == untried
    assert out.rstrip().endswith("UNPROVEN")

    words[2] = str(FIRMWARE / "predator")
    assert main([*words, "--reading", "0,0,0/--/0,0"]) == 7
    assert "6 sonars and 0 light sensors, servobot-predator has 3 and 2" in capsys.readouterr().out

    process.send_signal(signal.SIGINT)
    assert process.wait(WAIT_S) == 0


def test_verify_says_what_a_target_is_called(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["verify", "--build", str(FIRMWARE / "prey"), "--target"]
    assert main([*words, "can:virtual"]) == 2
    assert "can:virtual: no name of a rig; say can:INTERFACE:CHANNEL" in capsys.readouterr().err


@pytest.mark.parametrize("place", ["usb", "pty:3", "tcp", "tcp:x"])
def test_a_place_that_is_none_is_a_sentence(place: str) -> None:
    ended = CliRunner().invoke(serve, [str(FIRMWARE / "prey"), "--slcan", place])
    assert ended.exit_code == 2
    assert f"--slcan {place}: say pty, or tcp:PORT with 0 for any" in ended.output


def test_a_build_that_is_none_is_a_sentence(tmp_path: object) -> None:
    ended = CliRunner().invoke(serve, [str(tmp_path)])
    assert ended.exit_code == 3
    assert "Traceback" not in ended.output


def test_a_port_that_cannot_be_had_is_a_sentence() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        for port in (taken.getsockname()[1], 70_000):
            ended = CliRunner().invoke(serve, [str(FIRMWARE / "prey"), "--slcan", f"tcp:{port}"])
            assert ended.exit_code == 7
            assert f"port {port} of this machine cannot be served" in ended.output
