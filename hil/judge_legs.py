"""All checks of a locomotion controller, in the order in which they run, by the robot's file."""

from collections.abc import Callable
from itertools import pairwise

from cgagen.bench_protocol import FRAME_LIMIT_MS, LISTEN_MS, LOCOMOTION_SLICE_MS, banner_text
from cgagen.emulator.chip import Coverage
from cgagen.stamp.image import Image
from hil.legs_bench import late_hello, speaks
from hil.legs_line import gait, idle, line_kept_low, say_go, taken_back, unsteady_lines
from hil.legs_roam import strides, unsteady_on_the_way
from hil.legs_trial import LegsTrial, standing
from hil.subject import Subject
from hil.trial import BYTE_NS, MS, want

SEEN_MS = 80
"""After it has let go of the step line, it has seen it high. Choice: two frames and more."""

READY_MS = 1_500
"""From a reset to the first GO that may be said, or the first movement. Choice: its double."""

RESET_MS = (7, 130, 410)
"""When it is reset after a movement has begun. Choice: in a frame, and in two phases."""


def judge_legs(subject: Subject, image: Image, coverage: Coverage | None = None) -> None:
    """Try a locomotion controller.

    Raises:
        FailedCheck: by the first check that finds something.
        CgagenError: what it does is impossible on the bench.
    """

    def new() -> LegsTrial:
        return LegsTrial(subject, image, coverage)

    trial = new()
    _start(trial)
    if trial.has_step:
        gait(trial)
        line_kept_low(trial)
        unsteady_lines(trial)
        taken_back(trial)
        idle(trial)
    else:
        strides(trial)
        unsteady_on_the_way(trial)
    trial.check_gaps("gaps")
    trial = new()
    speaks(trial, image)
    trial.check_gaps("gaps")
    late_hello(new())
    _resets(new)


def _start(trial: LegsTrial) -> None:
    """Banner, prompts, standing still; then the line is let go, or the first movement begins."""
    robot, began_ns = trial.robot, trial.now_ns
    trial.go_on(2)
    servos = sum(1 << one.pin for one in robot.servo_set.servos)
    want(trial.chip.pins.directions & servos == servos, "gaps", "servo lines float at the start")
    want(trial.wait("pulse 0", FRAME_LIMIT_MS), "gaps", "no pulse soon after a reset")
    if trial.has_step:
        want(trial.holds, "handshake", "the step line is not held low after a reset")
    ready = trial.wait("step 1" if trial.has_step else "moved", READY_MS)
    if not ready:
        trial.check_gaps("gaps")
    if trial.has_step:
        want(ready, "handshake", "the step line is never let go")
    else:
        want(ready, "hang", "never walks what the lines say")
    wanted = banner_text(trial.subject.banner("locomotion")) + "\r"
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
    frames = trial.frames(began_ns, "gait")
    want(set(frames) == {trial.rest}, "gait", "does not stand after the reset")
    trial.check_gaps("gaps")


def _resets(new: Callable[[], LegsTrial]) -> None:
    """A reset in a movement: all legs are put down, and it begins as from power-up."""
    trial = new()
    _start(trial)
    for time_ms in RESET_MS:
        if trial.has_step:
            trial.go_on(SEEN_MS)
            trial.wait("pulse 6", FRAME_LIMIT_MS)
            say_go(trial, 2)
        trial.go_on(time_ms)
        trial.reset()
        trial.rest = standing(trial.robot)
        _start(trial)
