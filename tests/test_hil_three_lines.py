"""Robots with the paper's three lines alone: judged as the others are, and planted faults seen."""

import json
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from cgagen.cli import cgagen
from cgagen.firmware.render import shipped_templates
from cgagen.tokenizer import Tokenizer
from hil.conduct import try_conduct
from hil.equivalence import Verdict
from hil.subject import Subject, subject_of
from hil.timing import try_timing
from tests.firmware_cases import CASES, built, changed
from tests.subjects import FIRMWARE

FREE = ("predator-free-running", "prey-free-running")


def free(case: str = "predator-free-running") -> Subject:
    return subject_of(built(case), case)


def planted(chip: str, old: str, new: str, tokenizer: Tokenizer) -> Subject:
    """A robot on three lines with another program in one chip."""
    one = free()
    assert old in one.sources[chip], old
    source = one.sources[chip].replace(old, new, 1)
    image = tokenizer.compile(source, one.files[chip]).image
    return replace(one, sources={**one.sources, chip: source}, images={**one.images, chip: image})


@pytest.mark.parametrize("case", FREE)
def test_they_pass_and_everything_is_tried(case: str) -> None:
    trial, timing = try_timing(free(case))
    assert (trial.verdict, trial.reason) == (Verdict.PASS, "")
    assert timing is not None
    assert timing.waiting_ns < timing.decision_ns < timing.waiting_ns + 60_000_000
    assert 20_000_000 < timing.shortest_frame_ns < timing.longest_frame_ns < 45_000_000
    assert timing.jitter_ns < 1_000
    trial = try_conduct(free(case))
    assert (trial.verdict, trial.reason) == (Verdict.PASS, "")
    assert trial.agreed == {0: 1, 1: 1, 2: 1}


PULSES = "Pulses:                                         ' one frame: a pulse for each servo\n"
TELL = "Tell:                                           ' in: commandLatch, set by Decide\n"
LATCHED = "  commandLatch = command "
DIRS = "  commandDirs = %0111"

FAULTS = [
    ("locomotion", PULSES, PULSES + "  PAUSE 30\n", "gaps: "),
    (
        "locomotion",
        "  GOSUB Pulses\n  GOSUB Move",
        "  PAUSE 40\n  GOSUB Pulses\n  GOSUB Move",
        "gaps: ",
    ),
    (
        "locomotion",
        "      GOSUB Rise\n      PAUSE 5 - phase * 4",
        "      GOSUB Pulses\n      PAUSE 0",
        "rise: ",
    ),
    (
        "locomotion",
        "command = commandLines & %0111\n",
        "command = commandLines & %0011\n",
        "gait: ",
    ),
    ("locomotion", "  IF command = (commandLines & %0111) THEN Walk", "  GOTO Walk", "faults: "),
    ("locomotion", '"*LINES"', '"*LINE"', "faults: says "),
    ("locomotion", "  lastMove = request(3)\n", "", "bench: ?M0a is walked twice"),
    ("locomotion", "BenchLeave:\n", "BenchLeave:\n  liftLM = 140\n", "after leaving"),
    (
        "main",
        "  GOSUB Sense\n  GOSUB Decide",
        "  commandDirs = %0111\n  GOSUB Sense\n  GOSUB Decide",
        "drives a line",
    ),
    ("main", LATCHED, "  commandLatch = 7 - command\n" + LATCHED, "lines: "),
    ("main", DIRS, "  commandDirs = %0011\n" + DIRS, "lines: "),
    ("main", DIRS, "  commandDirs = %0000\n" + DIRS, "lines: "),
    ("main", TELL, TELL + "  IF commandDirs = 7 THEN RETURN\n  commandLatch = 0\n", "lines: "),
    (
        "main",
        "Start:\n",
        "Start:\n  commandDirs = %0111\n  commandDirs = 0\n  commandLatch = 1\n"
        "  commandDirs = %0111\n  PAUSE 1\n  commandDirs = 0\n",
        "drives a line",
    ),
    ("main", "decisions = decisions + 1", "decisions = decisions + 1 & 127", "telemetry: "),
    ("main", "DEC echo(Left)", "DEC echo(Right)", "telemetry: "),
    (
        "main",
        "  GOSUB Report\n",
        '  GOSUB Report\n  SEROUT Port, Baud, ["*BUSY", CR]\n',
        "telemetry: ",
    ),
    ("main", "HEX2 state", "HEX2 state + 1", "bench: ?Q0x is answered"),
    ("main", "BenchQuestion:", "BenchQuestion:\n  commandDirs = %0111\n'", "bench: drives a line"),
    ("main", "  PAUSE EchoGap - (echo(Front) / EchoMs MAX EchoGap)\n", "", "sensing: "),
]


@pytest.mark.parametrize(("chip", "old", "new", "reason"), FAULTS)
def test_planted_faults_are_seen(
    chip: str, old: str, new: str, reason: str, tokenizer: Tokenizer
) -> None:
    trial = try_conduct(planted(chip, old, new, tokenizer))
    assert trial.verdict is Verdict.FAIL
    assert reason in trial.reason, trial.reason


@pytest.mark.parametrize(
    ("chip", "old", "new", "reason"),
    [
        ("locomotion", PULSES, PULSES + "  PAUSE 30\n", "ms for its pulse"),
        ("main", "  GOSUB Sense\n", "  GOSUB Sense\n  PAUSE 100\n", "a decision took"),
        ("main", "  GOSUB Tell\n", "  GOSUB Tell\n  PAUSE 300\n", "a look, its decision"),
        ("locomotion", "command = commandLines & %0111\n", "command = 1\n", "has not made"),
    ],
)
def test_times_of_three_lines_are_held(
    chip: str, old: str, new: str, reason: str, tokenizer: Tokenizer
) -> None:
    trial, _ = try_timing(planted(chip, old, new, tokenizer))
    assert trial.verdict is Verdict.FAIL
    assert reason in trial.reason, trial.reason


def test_a_main_controller_that_comes_back_late_lets_no_more_through(tokenizer: Tokenizer) -> None:
    """It commands what it had not decided, for a while after a reset."""
    old = "  FOR tries = 1 TO ListenTries"
    new = "  commandLatch = 5\n" + old
    trial = try_conduct(planted("main", old, new, tokenizer))
    assert trial.verdict is Verdict.PASS  # a latch that drives nothing is seen by nobody


def slow_templates(folder: Path) -> Path:
    """A user's templates, whose servo frames take 30 ms longer."""
    folder.mkdir()
    text = (shipped_templates() / "locomotion.bs2.j2").read_text("utf-8")
    (folder / "locomotion.bs2.j2").write_text(changed(text, (PULSES, PULSES + "  PAUSE 30\n")))
    return folder


def test_slow_frames_fail_at_the_exhaustive_level(tmp_path: Path) -> None:
    robot, build = tmp_path / "mine.toml", tmp_path / "build"
    robot.write_text(CASES["predator-free-running"], "utf-8")
    genome = str(FIRMWARE / "reference.genome")
    words = ["build", genome, "--robot", str(robot), "-o", str(build)]
    words += ["--templates", str(slow_templates(tmp_path / "templates"))]
    done = CliRunner().invoke(cgagen, words)
    assert done.exit_code == 0, done.output
    words = ["--json", "verify", genome, "--robot", str(robot), "--build", str(build)]
    done = CliRunner().invoke(cgagen, [*words, "--level", "exhaustive"])
    trials = json.loads(done.stdout)["trials"]
    verdicts = {name: trial["verdict"] for name, trial in trials.items()}
    assert done.exit_code == 9
    assert {name for name, one in verdicts.items() if one != "PASS"} == {"timing", "conduct"}
    assert "ms for its pulse, and goes limp" in trials["timing"]["reason"]
