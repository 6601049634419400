"""A robot on the bench: its servos centred, a movement walked, its sensors read."""

import itertools
import json
import socket
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from cgagen.calibrate import read_measurements
from cgagen.cli import main
from cgagen.emulator.bench import Bench
from cgagen.errors import RigError
from cgagen.link import bench_hook
from cgagen.link.bench_hook import BenchHook
from cgagen.monitor import Decoder
from cgagen.monitor.readings import decisions
from cgagen.robot import load_robot
from cgagen.words import COMMANDS, Movement, Role
from hil.emulated import robot_bench
from hil.gait_reader import GaitReader
from hil.pipe import BytePipe
from hil.subject import read_subject
from tests.subjects import FIRMWARE

Served = Callable[..., tuple[str, Bench]]


@pytest.fixture
def served() -> Iterator[Served]:
    """Serve one chip of an emulated robot, and stop all of them at the end."""
    with ExitStack() as stack:

        def one(role: str, chip: str, kind: str = "tcp") -> tuple[str, Bench]:
            subject = read_subject(FIRMWARE / role)
            bench = robot_bench(subject.robot, subject.images)
            return stack.enter_context(BytePipe(bench, chip, kind)).url, bench

        yield one


def greeted(url: str) -> str:
    """Bring a chip into bench mode, as the half second after its power-up allows."""
    with BenchHook(url) as hook:
        hook.hello()
    return url


def changes(gait: GaitReader) -> int:
    """Return how often the servos were given another frame than the one before."""
    frames = gait.take().whole_frames()
    return sum(one != two for one, two in itertools.pairwise(frames))


# -- legs -----------------------------------------------------------------------------------------


def test_a_movement_is_walked_so_often(served: Served, capsys: pytest.CaptureFixture[str]) -> None:
    url, bench = served("prey", "locomotion")
    gait = GaitReader(load_robot("servobot-prey"), bench)
    greeted(url)
    gait.take()  # the legs rose one after another
    once = ["robot", "move", "rotate_right", "--port", url]
    assert main(once) == 0
    train = gait.take()
    assert gait.find(train).command == COMMANDS[Role.PREY].index(Movement.ROTATE_RIGHT)
    assert main(once) == 0
    again = changes(gait)
    capsys.readouterr()
    assert main([*once, "--cycles", "2"]) == 0
    assert changes(gait) == 2 * again > 0
    out, err = capsys.readouterr()
    assert "walked ROTATE_RIGHT 2 times" in out
    assert "ROTATE_RIGHT,2," in out
    assert "cycle 2 of 2" in err


def test_centring(served: Served, capsys: pytest.CaptureFixture[str]) -> None:
    url, bench = served("predator", "locomotion")
    gait = GaitReader(load_robot("servobot-predator"), bench)
    standing = gait.rest
    greeted(url)
    assert main(["robot", "move", "FORWARD", "--port", url]) == 0
    assert gait.take().whole_frames()[-1] != standing
    assert main(["--json", "robot", "centre", "--port", url]) == 0
    last = gait.take().whole_frames()[-1]
    assert all(abs(a - b) <= 4_000 for a, b in zip(last, standing, strict=True))
    assert json.loads(capsys.readouterr().out.splitlines()[-1])["robot"] == "servobot-predator"


def test_a_movement_that_this_robot_does_not_have(
    served: Served, capsys: pytest.CaptureFixture[str]
) -> None:
    url = greeted(served("prey", "locomotion")[0])
    assert main(["robot", "move", "BACKWARD", "--port", url]) == 2
    assert "a prey cannot BACKWARD; it can FORWARD, WAIT" in capsys.readouterr().err
    assert main(["robot", "move", "FLY", "--port", url]) == 2


def test_a_robot_that_is_named_is_the_one_at_hand(
    served: Served, capsys: pytest.CaptureFixture[str]
) -> None:
    """A prey's FORWARD is another command than a predator's: nothing may walk, nothing be noted."""
    url, bench = served("predator", "locomotion")
    gait = GaitReader(load_robot("servobot-predator"), bench)
    words = ["--robot", "servobot-prey", "--port", greeted(url)]
    assert main(["robot", "move", "FORWARD", *words]) == 7
    assert "the banner names servobot-predator, and the robot that" in capsys.readouterr().err
    assert changes(gait) == 0
    url, _ = served("predator", "main", "rfc2217")
    words = ["--robot", "servobot-prey", "--port", url, "--reset"]
    assert main(["robot", "sensors", *words, "--readings", "1"]) == 7
    assert "the banner names servobot-predator, and the robot that" in capsys.readouterr().err


def test_the_wrong_controller_is_named(served: Served, capsys: pytest.CaptureFixture[str]) -> None:
    url = greeted(served("prey", "main")[0])
    assert main(["robot", "centre", "--port", url]) == 7
    assert "the main controller is behind it" in capsys.readouterr().err


def test_a_reset_first_needs_no_hurry(served: Served) -> None:
    url, bench = served("prey", "locomotion", "rfc2217")
    assert main(["robot", "centre", "--port", url, "--reset"]) == 0
    assert bench.wire("step").level == 1  # bench mode: who says GO hears that nobody accepts


def test_an_emulated_robot_needs_no_port(capsys: pytest.CaptureFixture[str]) -> None:
    build = f"emu:{FIRMWARE / 'prey'}"
    assert main(["robot", "centre", "--port", build]) == 0
    assert main(["robot", "sensors", "--port", build, "--readings", "1"]) == 0
    out = capsys.readouterr().out
    assert "servobot-prey: all twelve servos are centred" in out
    assert "rear_right" in out
    assert main(["robot", "centre", "--port", "emu"]) == 7
    assert "emu:runs/demo/build-prey" in capsys.readouterr().err
    assert main(["robot", "centre", "--port", f"emu:{FIRMWARE / 'cat'}"]) == 3
    assert "cat" in capsys.readouterr().err


def test_nobody_there(capsys: pytest.CaptureFixture[str]) -> None:
    for words in (["centre"], ["move", "FORWARD"], ["sensors"]):
        assert main(["robot", *words, "--port", "/dev/no-such-port"]) == 7
        assert "/dev/no-such-port" in capsys.readouterr().err


def test_a_chip_that_does_not_listen_may_be_reset(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """At work the locomotion controller is silent and deaf."""
    monkeypatch.setattr(bench_hook, "HELLO_S", 0.2)
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = f"socket://127.0.0.1:{server.getsockname()[1]}"
        assert main(["robot", "centre", "--port", port]) == 7
        assert "or reset it (--reset does that by DTR)" in capsys.readouterr().err
        assert main(["robot", "centre", "--port", port, "--reset"]) == 7
        assert "carries no DTR to reset" in capsys.readouterr().err


# -- sensors --------------------------------------------------------------------------------------


def test_sensors_are_shown_and_become_a_table(
    served: Served, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    url, _ = served("predator", "main")
    table = tmp_path / "marks.csv"
    words = ["robot", "sensors", "--port", url, "--sensor", "front", "--table", str(table)]
    assert main(["--json", *words, "--distance", "125.4", "--readings", "2"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["decisions"] == 2
    assert data["sensors"]["front"] == {"low": 26666, "mean": 26666.0, "high": 26666, "readings": 2}
    assert data["sensors"]["light_left"]["high"] == 0
    assert main([*words, "--distance", "20", "--readings", "1"]) == 0
    out, err = capsys.readouterr()
    assert "front            26666   26666.0   26666" in out
    assert "front nothing" in err
    measured = read_measurements(load_robot("servobot-predator"), {"t": table.read_text()})
    assert [mark[1:] for mark in measured.sonars["front"]] == [
        *((125.4, 26666), (125.4, 26666), (20.0, 26666))
    ]


def test_half_of_what_a_table_needs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["robot", "sensors", "--port", "/dev/no-such-port", "--sensor", "front"]
    assert main(words) == 2
    assert "belong together" in capsys.readouterr().err


def test_a_robot_that_says_nothing() -> None:
    """It prompts, in bench mode, or is silent; either way the wait is bounded."""

    class Prompting:
        def read(self, size: int = 1) -> bytes:
            return b">"[:size]

        def write(self, data: bytes) -> int:
            return len(data)

    time_s = itertools.count(0, 0.5)
    with pytest.raises(RigError, match=r"COM: no telemetry in 8 s; reset the main controller"):
        list(decisions("COM", Prompting(), Decoder(None), lambda: next(time_s)))
