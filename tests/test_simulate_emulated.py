"""`cgagen simulate --emulated` as a user calls it."""

import re
from pathlib import Path

import pytest

from cgagen.cli import main
from cgagen.genome import load
from cgagen.robot import load_robot
from tests.subjects import FIRMWARE


def run(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str]:
    code = main(["simulate", *words])
    out = capsys.readouterr()
    return code, out.out + out.err


GENOME = str(FIRMWARE / "reference.genome")


def test_simulate_emulated_says_that_both_agree(capsys: pytest.CaptureFixture[str]) -> None:
    code, out = run(capsys, GENOME, "--emulated", "--steps", "2")
    assert code == 0
    assert "2 steps, all equal" in out


def test_simulate_emulated_fails_on_a_build_of_another_genome(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    flipped = tmp_path / "other.genome"
    flipped.write_text(load(Path(GENOME)).bits.translate({48: "1", 49: "0"}) + "\n")
    build = ["--build", str(FIRMWARE / "predator")]
    code, out = run(capsys, str(flipped), "--emulated", "--steps", "2", *build)
    assert code == 9
    assert "step 1: predator command" in out


def test_robots_without_referee_are_compared_and_not_judged(
    capsys: pytest.CaptureFixture[str],
) -> None:
    code, out = run(capsys, GENOME, "--emulated", "--no-referee", "--steps", "2")
    assert code == 0
    assert "each in its own time, not captured in 2 movements; the first" in out


def test_a_robot_on_three_lines_walks_in_its_own_time(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    robot = tmp_path / "three.toml"
    text = load_robot("servobot-predator").text
    robot.write_text(re.sub(r"(?m)^step_line = \{.*?\}", 'step_line = "none"', text))
    words = ["--emulated", "--steps", "1", "--robot", str(robot)]
    code, out = run(capsys, GENOME, *words)
    assert code == 0
    assert "servobot-predator: no step line" in out
    assert "each in its own time, not captured in 1 movements" in out


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--emulated", "--no-masking"], "masking is in the firmware"),
        (["--emulated", "--past-capture"], "leave out --past-capture"),
        (["--build", "firmware/predator"], "give both"),
        (["--no-referee"], "--no-referee is for --emulated"),
    ],
)
def test_what_the_firmware_cannot_know_is_refused(
    words: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    code, out = run(capsys, GENOME, *words)
    assert code == 2
    assert said in out


def test_a_build_is_of_the_genome_and_the_robot_that_were_named_wherever_the_hunt_leads(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """In one step no more than one gene is met; another one, and a trim, are none the less told."""
    bits = load(Path(GENOME)).bits
    other, robot = tmp_path / "other.genome", tmp_path / "mine.toml"
    other.write_text(bits[:-1] + {"0": "1", "1": "0"}[bits[-1]])
    text = load_robot("servobot-predator").text
    assert "\nLF = [0, 0]\n" in text
    robot.write_text(text.replace("\nLF = [0, 0]\n", "\nLF = [4, 0]\n"))
    build = ["--build", str(FIRMWARE / "predator"), "--emulated", "--steps", "1"]
    for words, said in (
        ([str(other)], "and the genome that was named beside it is "),
        (
            [GENOME, "--robot", str(robot)],
            "and the robot that was named beside it is servobot-predator (",
        ),
    ):
        code, out = run(capsys, *words, *build)
        assert (code, said in out) == (9, True), out
    assert run(capsys, GENOME, "--robot", "servobot-predator", *build)[0] == 0
