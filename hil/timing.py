"""How long a robot takes to decide, and how regular its servo frames are: one short walk.

Measured on the emulator with no echo and no light, which is the longest that sensing can take.
"""

from itertools import pairwise
from typing import NamedTuple

from cgagen.bench_protocol import FRAME_LIMIT_MS
from cgagen.emulator.parts.servo import Servo
from cgagen.errors import CgagenError
from cgagen.robot.gait import phases_of
from hil.emulated import stopped
from hil.equivalence import Trial, Verdict, blocked
from hil.lone import MS, Lone, Walk
from hil.stimuli import neutral
from hil.subject import Subject

LONGEST_COUNT = 65_536
"""What PULSIN and RCTIME wait for at most, in their counts."""

CODE_MS = 60
"""What instructions between the waits may take. Choice: twice what they do."""

WALKS = 2


class Timing(NamedTuple):
    """What was measured.

    Attributes:
        decision_ns: the longest time from legs that stand to GO.
        waiting_ns: how much of that PULSIN and RCTIME wait for what never comes, by their counts,
            and the gaps between sonars.
        shortest_frame_ns: between two pulses of one servo, over everything that the robot did.
        longest_frame_ns: likewise.
        jitter_ns: by how much frames differ within one phase of a movement.
        pulses: of all twelve servos.
    """

    decision_ns: int
    waiting_ns: int
    shortest_frame_ns: int
    longest_frame_ns: int
    jitter_ns: int
    pulses: int


def try_timing(subject: Subject) -> tuple[Trial, Timing | None]:
    """Let the robot decide and move twice; FAIL where a frame is late or a pulse is odd.

    A robot without a step line cannot be timed so, and nothing is said then.
    """
    trial = Trial("emulator:timing")
    if subject.robot.link.step_line is None:
        trial.verdict = Verdict.NOT_TRIED
        trial.reason = f"{subject.robot.name} has no step line, by which its decisions are timed"
        return trial, None
    try:
        lone = Lone(subject)
        lone.show(neutral(subject.robot))
        walk = lone.walk(WALKS)
    except CgagenError as error:
        return blocked(trial.target, stopped(subject.where, error)), None
    times = [go - rise for rise, go in zip(lone.rise_ns, lone.go_ns, strict=False)]
    if walk is None or not times:
        trial.verdict = Verdict.FAIL
        trial.reason = f"{subject.where}: the robot has not made {WALKS} movements in time"
        return trial, None
    seen = [servo.pulses for servo in lone.bench.parts_of(Servo).values()]
    timing = Timing(
        max(times),
        _waiting_ns(subject),
        min(one.shortest_period_ns for one in seen),
        max(one.longest_period_ns for one in seen),
        max(_jitter_ns(subject, one) for one in lone.walks),
        sum(one.taken for one in seen),
    )
    trial.tried = {0: len(lone.walks)}
    trial.reason = _trouble(lone, timing, sum(one.odd + one.limp for one in seen))
    trial.agreed = {0: 0 if trial.reason else len(lone.walks)}
    trial.verdict = Verdict.FAIL if trial.reason else Verdict.PASS
    return trial, timing


def _trouble(lone: Lone, timing: Timing, odd: int) -> str:
    """Return what is wrong; "" for nothing."""
    if timing.longest_frame_ns > FRAME_LIMIT_MS * MS:
        return (
            f"a servo waited {timing.longest_frame_ns / MS:.1f} ms for its pulse, and goes limp "
            f"after {FRAME_LIMIT_MS} ms"
        )
    if timing.decision_ns > timing.waiting_ns + CODE_MS * MS:
        return (
            f"a decision took {timing.decision_ns / MS:.1f} ms, of which its sensors can use "
            f"{timing.waiting_ns / MS:.1f}"
        )
    if odd:
        return f"{odd} pulses were too long, too short or too late"
    if lone.uncommanded:
        return f"a servo moved without a command: {lone.uncommanded[0]}"
    wrong = next((one for one in lone.walks if one.made.command != one.asked), None)
    if wrong is not None:
        return f"command {wrong.asked} was asked for: {wrong.made.reason}"
    return ""


def _waiting_ns(subject: Subject) -> int:
    robot = subject.robot
    lights = len(robot.light.sensors) if robot.light else 0
    units_ns = len(robot.sonars) * robot.main.pulsin_unit_ns + lights * robot.main.rctime_unit_ns
    rests = len(robot.sonars) if robot.link.step_line is None else len(robot.sonars) - 1
    return LONGEST_COUNT * units_ns + rests * robot.echo.trigger_gap_ms * MS


def _jitter_ns(subject: Subject, walk: Walk) -> int:
    """Return by how much the frames of one pose differ; 0 for a movement that holds."""
    robot, step = subject.robot, subject.robot.steps[walk.asked]
    starts = [pulse.start_ns for pulse in walk.train.pulses[0]]
    periods = [then - now for now, then in pairwise(starts)]
    if step.order == "hold":
        inside = periods[1:]
        return max(inside) - min(inside) if inside else 0
    at, worst = 1, 0
    for _, frames in phases_of(robot, step):
        inside = periods[at : at + frames - 1]
        worst = max(worst, max(inside) - min(inside) if inside else 0)
        at += frames
    return worst
