"""All checks of a locomotion controller, in the order in which they run, by the robot's file."""

from itertools import pairwise

from cgagen.bench_protocol import (
    FRAME_LIMIT_MS,
    LISTEN_MS,
    LOCOMOTION_SLICE_MS,
    Banner,
    banner_text,
)
from cgagen.emulator.chip import Coverage
from cgagen.stamp.image import Image
from hil.legs_bench import late_hello, speaks
from hil.legs_line import gait, idle, line_kept_low, taken_back, unsteady_lines
from hil.legs_trial import LegsTrial
from hil.subject import Subject
from hil.trial import BYTE_NS, MS, want


def judge_legs(subject: Subject, image: Image, coverage: Coverage | None = None) -> None:
    """Try a locomotion controller.

    Raises:
        FailedCheck: by the first check that finds something.
        CgagenError: what it does is impossible on the bench.
    """
    trial = LegsTrial(subject, image, coverage)
    _start(trial)
    gait(trial)
    line_kept_low(trial)
    unsteady_lines(trial)
    taken_back(trial)
    idle(trial)
    trial.check_gaps("gaps")
    trial = LegsTrial(subject, image, coverage)
    speaks(trial, image)
    trial.check_gaps("gaps")
    late_hello(LegsTrial(subject, image, coverage))


def _start(trial: LegsTrial) -> None:
    """Banner, prompts, standing still with the line held low; then the line is let go."""
    robot, subject = trial.robot, trial.subject
    trial.go_on(2)
    servos = sum(1 << one.pin for one in robot.servo_set.servos)
    want(trial.chip.pins.directions & servos == servos, "gaps", "servo lines float at the start")
    want(trial.holds, "handshake", "the step line is not held low after a reset")
    want(trial.wait("pulse 0", FRAME_LIMIT_MS), "gaps", "no pulse soon after a reset")
    want(trial.wait("step 1", 1_500), "handshake", "the step line is never let go")
    digest = subject.sources["locomotion"].split("Source:  ")[1][:8]
    wanted = banner_text(Banner(1, "locomotion", robot.name, subject.genome_digest, digest)) + "\r"
    want(trial.said.rstrip(">") == wanted, "banner", f"says {trial.said!r}")
    prompts = trial.heard_ns[len(wanted) :]
    slices = [b - a for a, b in pairwise([*prompts, trial.now_ns])]
    want(len(prompts) > 1, "banner", "does not listen")
    whole = trial.now_ns - prompts[0]
    want(whole >= LISTEN_MS * MS, "banner", f"listens for {whole / MS:.0f} ms")
    want(whole < 2 * LISTEN_MS * MS, "banner", f"listens for {whole / MS:.0f} ms")
    *others, last = slices  # no prompt follows the last one
    least = LOCOMOTION_SLICE_MS * MS
    want(min(others) >= least + BYTE_NS and last >= least, "banner", "slices too short")
    frames = trial.frames(0, "gait")
    want(set(frames) == {trial.rest}, "gait", "does not stand after the reset")
    trial.check_gaps("gaps")
