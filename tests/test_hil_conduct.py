"""Each controller's conduct on pins and port, for robots of several makes, and planted faults."""

from dataclasses import replace
from pathlib import Path

import pytest

from cgagen.build import make_build
from cgagen.errors import RigError
from cgagen.robot.reader import parse_robot
from cgagen.tokenizer import Tokenizer
from hil.conduct import try_conduct
from hil.equivalence import Verdict
from hil.registers import RegisterTarget
from hil.subject import Subject, read_subject, subject_of
from tests.firmware_cases import GENOME, PREDATOR, built
from tests.firmware_cases import changed as changed_text

FIRMWARE = Path(__file__).parent.parent / "firmware"


def subject(case: str) -> Subject:
    return subject_of(built(case), case)


@pytest.mark.parametrize(
    "case", ["predator-srf04", "predator-bs2e", "predator-bs2p-legs", "prey-silent"]
)
def test_robots_of_other_make_conduct_themselves(case: str, tokenizer: Tokenizer) -> None:
    trial = try_conduct(subject(case), tokenizer.compile)
    assert (trial.verdict, trial.reason) == (Verdict.PASS, "")
    assert trial.agreed == {0: 1, 1: 1}


def test_a_slow_robot_may_take_its_time(tokenizer: Tokenizer) -> None:
    """Its movements last for nearly twice as many frames; its sonars are asked seldom."""
    text = changed_text(
        PREDATOR,
        ("trigger_gap_ms = 25 ", "trigger_gap_ms = 80 "),
        ("lift_frames = 6 ", "lift_frames = 10 "),
        ("push_frames = 11 ", "push_frames = 24 "),
    )
    build = make_build(parse_robot(text, "slow.toml"), GENOME, tokenizer)
    trial = try_conduct(subject_of(build, "slow"), tokenizer.compile)
    assert (trial.verdict, trial.reason) == (Verdict.PASS, "")


LATCHED = "  commandLatch = command "

FAULTS = [
    ("main", "  PAUSE GoTime", "  PAUSE GoTime - 1", "handshake: says GO too shortly"),
    ("main", "Start:\n", "Start:\n  LOW StepLine\n  PAUSE 9\n  INPUT StepLine\n", "drives a line"),
    ("main", "decisions = decisions + 1", "decisions = decisions + 1 & 127", "telemetry"),
    ("main", "DEC echo(Left)", "DEC echo(Right)", "telemetry"),
    ("main", "  PAUSE EchoGap - (", "  PAUSE 5 ' (", "lines: "),  # phantoms
    ("main", "  PAUSE EchoGap - (", "  PAUSE EchoGap - 3 - (", "ms behind the trigger before"),
    ("main", LATCHED, f"  IF command > 0 THEN{LATCHED}", "lines: "),
    ("locomotion", "  IF StepLine = 1 THEN Ready ", "' ", "what the lines say after a reset"),
    ("locomotion", "BenchLeave:\n", "BenchLeave:\n  GOSUB Centre\n", "bench: moves as it is left"),
]  # fmt: skip


@pytest.mark.parametrize(("chip", "old", "new", "reason"), FAULTS)
def test_what_readings_and_movements_do_not_show_is_seen(
    chip: str, old: str, new: str, reason: str, tokenizer: Tokenizer
) -> None:
    trial = try_conduct(changed(subject("predator"), chip, old, new, tokenizer), tokenizer.compile)
    assert trial.verdict is Verdict.FAIL
    assert reason in trial.reason
    assert sum(trial.agreed.values()) == 1


def changed(one: Subject, chip: str, old: str, new: str, tokenizer: Tokenizer) -> Subject:
    """A robot with another program in one chip."""
    source = one.sources[chip]
    assert old in source
    source = source.replace(old, new, 1)
    image = tokenizer.compile(source, one.files[chip]).image
    return replace(one, sources={**one.sources, chip: source}, images={**one.images, chip: image})


def test_without_a_step_line_nothing_is_said(tokenizer: Tokenizer) -> None:
    trial = try_conduct(subject("prey-free-running"), tokenizer.compile)
    assert trial.verdict is Verdict.NOT_TRIED
    assert "no step line" in trial.reason


def test_a_source_of_another_image_leaves_its_chip_out(tokenizer: Tokenizer) -> None:
    one = subject("predator")
    other = {
        **one.sources,
        "main": one.sources["main"].replace("GoTime          CON     100", "GoTime CON 9"),
    }
    trial = try_conduct(replace(one, sources=other), tokenizer.compile)
    assert (trial.verdict, trial.tried) == (Verdict.PASS, {0: 1})


def test_a_source_without_the_names_of_a_generated_one_is_unproven(tokenizer: Tokenizer) -> None:
    one = subject("predator")
    source = one.sources["main"].replace("decisions", "looks    ")
    image = tokenizer.compile(source, "main.bsp").image
    other = replace(
        one, sources={**one.sources, "main": source}, images={**one.images, "main": image}
    )
    trial = try_conduct(other, tokenizer.compile)
    assert trial.verdict is Verdict.UNPROVEN
    assert "main.bsp lacks" in trial.reason


def test_a_command_that_is_left_as_it_was_shows_from_registers(tokenizer: Tokenizer) -> None:
    """The answer to what is sensed at first is 0, as the lines are from a reset on."""
    new = f"  IF command > 0 THEN{LATCHED}"
    one = changed(read_subject(FIRMWARE / "predator"), "main", LATCHED, new, tokenizer)
    with pytest.raises(RigError, match="command 7, the robot with 29 and 0"):
        RegisterTarget(one, tokenizer.compile).open()
