"""All checks of a locomotion controller, in the order in which they run, by the robot's file."""

from collections.abc import Callable
from itertools import pairwise

from cgagen.bench_protocol import FRAME_LIMIT_MS, LISTEN_MS, LOCOMOTION_SLICE_MS, banner_text
from cgagen.emulator.chip import Coverage
from cgagen.stamp.image import Image
from hil.legs_bench import late_hello, speaks
from hil.legs_line import gait, idle, line_kept_low, say_go, taken_back, unsteady_lines, walk
from hil.legs_roam import strides, unsteady_on_the_way
from hil.legs_trial import SERVOS, STARTS_MS, LegsTrial, standing
from hil.subject import Subject
from hil.trial import BYTE_NS, MS, want

SEEN_MS = 80
"""After it has let go of the step line, it has seen it high. Choice: two frames and more."""

SHORTEST_FRAME_MS = 18
"""Of rising legs, whatever their number: a servo is not pulsed more often. Choice."""

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
        trial.check_gaps("gaps")
        _reset_in_go(trial)
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
    """Legs rise one after another, banner, prompts; GO is awaited, or a movement begins."""
    robot, began_ns = trial.robot, trial.now_ns
    trial.go_on(2)
    servos = sum(1 << one.pin for one in robot.servo_set.servos)
    want(trial.chip.pins.directions & servos == servos, "gaps", "servo lines float at the start")
    want(trial.wait(f"pulse {SERVOS - 2}", FRAME_LIMIT_MS), "gaps", "no pulse soon after a reset")
    if trial.has_step:
        trial.listens()
    elif not trial.wait("moved", STARTS_MS):
        trial.check_gaps("gaps")
        want(False, "hang", "never walks what the lines say")
    trial.check_gaps("gaps")
    wanted = banner_text(trial.subject.banner("locomotion")) + "\r"
    want(trial.said.rstrip(">") == wanted, "banner", f"says {trial.said!r}")
    prompts = trial.heard_ns[len(wanted) :]
    slices = [b - a for a, b in pairwise(prompts)]
    want(len(prompts) > 1, "banner", "does not listen")
    least = LOCOMOTION_SLICE_MS * MS
    whole = prompts[-1] - prompts[0] + least
    want(whole >= LISTEN_MS * MS, "banner", f"listens for {whole / MS:.0f} ms")
    want(whole < 2 * LISTEN_MS * MS, "banner", f"listens for {whole / MS:.0f} ms")
    want(min(slices) >= least + BYTE_NS, "banner", "slices too short")
    frames = trial.frames(began_ns, "gait")
    want(set(frames) == {trial.rest}, "gait", "does not stand after the reset")
    _rises(trial)
    trial.check_gaps("gaps")


def _rises(trial: LegsTrial) -> None:
    """No leg begins before the one before it has had its frames; each begins with its centre."""
    starts = sorted(trial.rises[n][0] for n in range(0, SERVOS, 2))
    wanted = trial.robot.servo_set.start_frames
    apart = min(b - a for a, b in pairwise(starts))
    least_ns = wanted * SHORTEST_FRAME_MS * MS
    want(apart >= least_ns, "rise", f"two legs start {apart / MS:.0f} ms apart")
    for rises in trial.rises[::2]:
        then = next((start for start in starts if start > rises[0]), None)
        frames = sum(rise < then for rise in rises) if then else wanted
        want(frames == wanted, "rise", f"{frames} frames before the next leg")
    for swing in range(0, SERVOS, 2):
        both = abs(trial.rises[swing + 1][0] - trial.rises[swing][0])
        want(both < FRAME_LIMIT_MS * MS, "rise", f"servos {swing} and {swing + 1} start apart")
    first = {index: width for _, width, index in sorted(trial.pulses, reverse=True)}
    counts = tuple(trial.counts(first[index]) for index in range(SERVOS))
    want(counts == trial.rest, "rise", f"begins with pulses of {counts}")


def _reset_in_go(trial: LegsTrial) -> None:
    """A chip that starts while GO is said, or finds it on the line, accepts nothing."""
    trial.other.set(0)
    trial.reset()
    trial.rest = standing(trial.robot)
    for _ in range(STARTS_MS // 20):
        trial.go_on(20)
        want(not trial.holds, "handshake", "takes a GO for its own that was said before it started")
    trial.other.set(None)
    trial.go_on(SEEN_MS)
    trial.command(1)
    trial.wait("pulse 6", FRAME_LIMIT_MS)
    walk(trial, 1)


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
