"""All checks of a main controller, in the order in which they run: by pins and by words."""

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

from cgagen.bench_protocol import LISTEN_MS, MAIN_SLICE_MS, Fault, banner_text
from cgagen.emulator.chip import Coverage
from cgagen.emulator.parts.sonar import middle_ns
from cgagen.errors import LackingError
from cgagen.firmware.timing import legs_start_ms
from cgagen.stamp.image import Image
from hil.anchors import anchors_of
from hil.main_bench import late_hello, speaks
from hil.main_decides import decisions, genes
from hil.main_hunts import hunts
from hil.main_roams import roams
from hil.main_senses import pulses_of
from hil.main_trial import MainTrial
from hil.main_wanted import Wanted
from hil.stimuli import neutral
from hil.subject import Subject
from hil.trial import BYTE_NS, MS, want

FAST_SLACK_NS, SLOW_SLACK_NS = 1_500_000, 6_000_000
"""What instructions between two waits may take. Choice: a little more than they do."""

RESET_MS = (40, 150, 230)
"""When it is reset after a look began: as it senses, with lines and GO, as it reports. Choice."""


FIRST_LOOK_MS = 2_500
"""From a reset, without the time for the legs. Choice."""


def judge_main(
    subject: Subject, wanted: Wanted, image: Image, coverage: Coverage | None = None
) -> None:
    """Try a main controller.

    Raises:
        FailedCheck: by the first check that finds something.
        LackingError: no check has found anything, and some could not be made.
        CgagenError: what it does is impossible on the bench.
    """
    lacks: list[LackingError] = []

    def new() -> MainTrial:
        return MainTrial(subject, image, coverage)

    trial = new()
    trial.present(wanted.hunts[0][0])
    _start(trial)
    before, seen = trial.bench.snapshot(), len(trial.edges)
    try:
        anchors = anchors_of(image, subject.robot)
        decisions(trial, wanted, anchors)
        trial.bench.restore(before)
        genes(trial, anchors)
    except LackingError as error:
        lacks.append(error)
    trial.bench.restore(before)
    del trial.edges[seen:]
    (hunts if trial.has_step else roams)(trial, wanted)
    lacks += trial.lacks
    trial = new()
    trial.present(neutral(subject.robot))
    speaks(trial, wanted, image)
    lacks += trial.lacks
    late_hello(new())
    if subject.robot.light:
        _start_lit(new())
    _resets(new, wanted)
    if lacks:
        raise lacks[0]


def _charged(trial: MainTrial) -> None:
    """Before the first look, too, a light sensor that is lit was charged for long enough."""
    light = trial.robot.light
    if light is None or trial.shown is None:
        return
    pulses = pulses_of(trial)
    for sensor, count in zip(light.sensors, trial.shown.lights, strict=True):
        if count:
            drain_ns = middle_ns(count, trial.robot.main.rctime_unit_ns)
            high_ns = max(width_ns for _, width_ns in pulses.get(sensor.pin, [(0, 0)])) - drain_ns
            want(high_ns >= light.charge_ms * MS, "sensing", f"{sensor.name}: {high_ns} ns charged")


def _start_lit(trial: MainTrial) -> None:
    """It starts in a room that is too bright, and says so; with one sensor lit it says nothing."""
    plain, near = neutral(trial.robot), trial.robot.situation_counts
    left, right = near.lamp_left.range - 1, near.lamp_right.range - 1
    for lights in ((left, right), (left + 1, right), (left, right + 1), (1, 1), (0, 1), (1, 0)):
        trial.present(replace(plain, lights=lights))
        _start(trial)
        trial.reset()


def legs_ms_of(trial: MainTrial) -> int:
    """Return the time that it gives the legs to rise before it looks; none on three lines."""
    return legs_start_ms(trial.robot) - LISTEN_MS if trial.robot.link.step_line else 0


def _start(trial: MainTrial) -> None:
    """Banner and prompts, with no line touched; then the first look."""
    lines, touched = trial.line_bits | trial.step_bit, list[int]()
    trial.touched = touched.append
    legs_ms = legs_ms_of(trial)
    want(trial.wait("look", FIRST_LOOK_MS + legs_ms), "hang", "never looks at its sensors")
    trial.touched = None
    want(not touched, "handshake", "drives a line on its way to the first look")
    _charged(trial)
    trial.edges[:] = trial.edges[-1:]  # the trigger with which this look has begun
    wanted = banner_text(trial.subject.banner("main")) + "\r"
    if trial.shown_bright:
        wanted += f"*{Fault.BRIGHT}\r"
    want(trial.said.rstrip(">") == wanted, "banner", f"says {trial.said!r}")
    prompts = trial.heard_ns[len(wanted) :]
    ended_ns = trial.now_ns - legs_ms * MS
    slices = [b - a for a, b in pairwise([*prompts, ended_ns])]
    want(len(slices) > 1, "banner", "does not listen")
    least = MAIN_SLICE_MS * MS + BYTE_NS // 2
    slack = FAST_SLACK_NS if trial.fast else SLOW_SLACK_NS
    want(min(slices) >= least, "banner", "slices too short")
    want(max(slices) <= least + BYTE_NS + slack, "banner", "slices too long")
    whole = ended_ns - prompts[0]
    want(whole >= LISTEN_MS * MS, "banner", f"listens for {whole / MS:.0f} ms")
    want(whole - slices[0] < LISTEN_MS * MS + 20 * MS, "banner", f"listens {whole / MS:.0f} ms")
    want(not trial.drives & lines, "handshake", "drives a line before its first decision")


def _resets(new: Callable[[], MainTrial], wanted: Wanted) -> None:
    """A reset lets go of all lines at once, and then it begins as from power-up."""
    trial, (stimulus, right) = new(), wanted.hunts[1]
    lines = trial.line_bits | trial.step_bit
    trial.present(stimulus)
    want(trial.wait("look", FIRST_LOOK_MS + legs_ms_of(trial)), "hang", "never looks")
    for time_ms in RESET_MS:
        trial.go_on(time_ms)
        trial.reset()
        want(not trial.drives & lines, "resets", "keeps a line after a reset")
        _start(trial)
    want(trial.wait_decided(1_500), "resets", "decides nothing after a reset")
    seen = trial.lines()
    want(seen == right.command, "resets", f"{stimulus.text()} after a reset: {seen}")
