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
from hil.kill import judge, subject_for
from hil.mutate import all_mutants
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
    trial = try_conduct(subject(case))
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
    trial = try_conduct(subject_of(build, "slow"))
    assert (trial.verdict, trial.reason) == (Verdict.PASS, "")


LATCHED = "  commandLatch = command "

RISES = "      GOSUB Rise\n      PAUSE 5 - phase * 4"

FAULTS = [
    ("locomotion", "DIRS = %0000", "DIRS = %1000", "handshake: holds the step line"),
    ("locomotion", "BenchHello: ", "BenchHello:\n  LOW StepLine  ' ", "in bench mode, as if it"),
    ("locomotion", RISES, "      GOSUB Pulses\n      PAUSE 0", "rise: two legs start"),
    ("locomotion", "    frames = StartFrames\n", "    frames = 1\n", "bench: centres a leg in 1"),
    ("main", "  IF polls < least THEN", "  IF polls * 9 < least THEN", "was cut short"),
    ("main", "  PAUSE GoTime", "  PAUSE GoTime - 1", "handshake: says GO too shortly"),
    ("main", "Start:\n", "Start:\n  LOW StepLine\n  PAUSE 9\n  INPUT StepLine\n", "drives a line"),
    ("main", "decisions = decisions + 1", "decisions = decisions + 1 & 127", "telemetry"),
    ("main", "DEC echo(Left)", "DEC echo(Right)", "telemetry"),
    ("main", "  PAUSE EchoGap - (", "  PAUSE 5 ' (", "lines: "),  # phantoms
    ("main", "  PAUSE EchoGap - (", "  PAUSE EchoGap - 3 - (", "ms behind the trigger before"),
    ("main", LATCHED, f"  IF command > 0 THEN{LATCHED}", "lines: "),
    ("locomotion", "  IF StepLine = 1 THEN Ready ", "' ", "what the lines say after a reset"),
    ("locomotion", "BenchLeave:\n", "BenchLeave:\n  liftLM = 140\n", "bench: moves as it is left"),
]  # fmt: skip


@pytest.mark.parametrize(("chip", "old", "new", "reason"), FAULTS)
def test_what_readings_and_movements_do_not_show_is_seen(
    chip: str, old: str, new: str, reason: str, tokenizer: Tokenizer
) -> None:
    trial = try_conduct(changed(subject("predator"), chip, old, new, tokenizer))
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


def test_images_are_judged_whatever_their_sources_say(tokenizer: Tokenizer) -> None:
    one = subject("predator")
    other = {
        **one.sources,
        "main": one.sources["main"].replace("GoTime          CON     100", "GoTime CON 9"),
    }
    trial = try_conduct(replace(one, sources=other))
    assert (trial.verdict, trial.tried) == (Verdict.PASS, {0: 1, 1: 1})


def test_what_cannot_be_judged_in_full_is_unproven_and_a_fault_in_it_is_seen(
    tokenizer: Tokenizer,
) -> None:
    """Telemetry in two statements, of which the first has no number: 255 is never come to."""
    one = subject("predator")
    split = changed(
        one,
        "main",
        ' [":", DEC decisions,',
        ' [":"]\n  SEROUT Port, Baud, [DEC decisions,',
        tokenizer,
    )
    trial = try_conduct(split)
    assert trial.verdict is Verdict.UNPROVEN
    assert "main.bsp: cannot be judged in full: no statement says" in trial.reason
    assert trial.agreed == {0: 0, 1: 1}
    worse = changed(split, "main", "  PAUSE GoTime", "  PAUSE GoTime - 1", tokenizer)
    assert try_conduct(worse).verdict is Verdict.FAIL


def test_a_number_that_is_copied_before_it_is_said_is_unproven(tokenizer: Tokenizer) -> None:
    """To overwrite the copy changes nothing: that is no fault of the program."""
    old, new = (
        '  SEROUT Port, Baud, [":", DEC decisions,',
        '  nearest = decisions\n  SEROUT Port, Baud, [":", DEC nearest,',
    )
    trial = try_conduct(changed(subject("predator"), "main", old, new, tokenizer))
    assert trial.verdict is Verdict.UNPROVEN
    assert "is not that of the variable which says it" in trial.reason


def test_a_bug_of_a_check_is_no_verdict(monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither a robot that is unproven nor a mutant that is killed: it ends the run."""

    def broken(*_words: object) -> None:
        raise IndexError("list index out of range")

    monkeypatch.setattr("hil.judge_main.decisions", broken)
    with pytest.raises(IndexError):
        try_conduct(subject("predator"))
    source = subject_for("prey").sources["main"]
    mutant = next(one for one in all_mutants(source) if one.kind == "threshold")
    with pytest.raises(IndexError) as caught:
        judge("prey", "main", mutant)
    assert any("while prey main line" in note for note in caught.value.__notes__)


def test_a_command_that_is_left_as_it_was_shows_from_registers(tokenizer: Tokenizer) -> None:
    """The answer to what is sensed at first is 0, as the lines are from a reset on."""
    new = f"  IF command > 0 THEN{LATCHED}"
    one = changed(read_subject(FIRMWARE / "predator"), "main", LATCHED, new, tokenizer)
    with pytest.raises(RigError, match="command 7, the robot with 29 and 0"):
        RegisterTarget(one, tokenizer.compile).open()
