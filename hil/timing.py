"""How long a robot takes to decide, and how regular its servo frames are: one short walk.

Measured on the emulator with no echo and no light, which is the longest that sensing can take. On
a step line a decision is timed from legs that stand to GO; on three lines from the first trigger
to the lines that are driven, and from one look to the next.
"""

from itertools import pairwise
from typing import NamedTuple

from cgagen.bench_protocol import FRAME_LIMIT_MS
from cgagen.emulator.bench import Bench
from cgagen.emulator.parts.servo import Servo
from cgagen.errors import CgagenError
from cgagen.robot.gait import phases_of
from hil.emulated import stopped
from hil.equivalence import Trial, Verdict, blocked
from hil.free import Free
from hil.gait_reader import LEADING_FRAMES
from hil.lone import MS, Lone
from hil.stimuli import neutral
from hil.stride import LEADING_FRAMES as BETWEEN_FRAMES
from hil.subject import Subject
from hil.trial import BYTE_NS

LONGEST_COUNT = 65_536
"""What PULSIN and RCTIME wait for at most, in their counts."""

CODE_MS = 60
"""What instructions between the waits may take. Choice: twice what they do."""

ROUND_CODE_MS = 2 * CODE_MS
"""Likewise on three lines from one look to the next, with a line of telemetry. Choice."""

WALKS, LIMIT_MS = 2, 20_000
"""Movements that are looked at, and how long they may take. Choice: with frames of twice the limit,
so that late frames are told and not only that nothing comes."""


class Timing(NamedTuple):
    """What was measured.

    Attributes:
        decision_ns: the longest time from legs that stand to GO, or from a look to its answer.
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
    """Let the robot decide and move twice; FAIL where a frame is late or a pulse is odd."""
    trial = Trial("emulator:timing")
    measure = _on_step_line if subject.robot.link.step_line else _on_three_lines
    try:
        seen = measure(subject)
    except CgagenError as error:
        return blocked(trial.target, stopped(subject.where, error)), None
    if seen is None:
        trial.verdict = Verdict.FAIL
        trial.reason = f"{subject.where}: the robot has not made {WALKS} movements in time"
        return trial, None
    trial.tried = {0: seen.walks}
    trial.reason = _trouble(seen)
    trial.agreed = {0: 0 if trial.reason else seen.walks}
    trial.verdict = Verdict.FAIL if trial.reason else Verdict.PASS
    return trial, seen.timing


class _Seen(NamedTuple):
    """What was seen of a walk.

    Attributes:
        timing: figures.
        walks: movements.
        rounds_ns: the longest time from a look to the next, without what was said meanwhile; 0
            where legs are waited for.
        odd: pulses that were too long, too short or too late.
        moved: what was wrong with a movement; "" for nothing.
    """

    timing: Timing
    walks: int
    rounds_ns: int
    odd: int
    moved: str


def _on_step_line(subject: Subject) -> _Seen | None:
    """Let the robot decide and move; None where it does not."""
    lone = Lone(subject)
    lone.show(neutral(subject.robot))
    walk = lone.walk(WALKS, LIMIT_MS)
    times = [go - rise for rise, go in zip(lone.rise_ns, lone.go_ns, strict=False)]
    if walk is None or not times:
        return None
    starts = [(one.asked, [pulse.start_ns for pulse in one.train.pulses[0]]) for one in lone.walks]
    jitter_ns = max(_jitter_ns(subject, *one, LEADING_FRAMES) for one in starts)
    wrong = next((one for one in lone.walks if one.made.command != one.asked), None)
    moved = f"command {wrong.asked} was asked for: {wrong.made.reason}" if wrong else ""
    if lone.uncommanded:
        moved = f"a servo moved without a command: {lone.uncommanded[0]}"
    return _seen(subject, lone.bench, max(times), jitter_ns, len(lone.walks), 0, moved)


def _on_three_lines(subject: Subject) -> _Seen | None:
    """Let the robot look, tell and walk in its own time; None where it does not."""
    free = Free(subject)
    free.show(neutral(subject.robot))
    if not free.walk(WALKS + 1, LIMIT_MS) or not free.told_ns or len(free.looks_ns) < WALKS:
        return None
    rounds = zip(pairwise(free.looks_ns), pairwise(free.bytes_said), strict=True)
    rounds_ns = max(end - began - BYTE_NS * (more - said) for (began, end), (said, more) in rounds)
    jitters_ns = [
        _jitter_ns(subject, command, list(one.starts_ns[-one.reading.frames :]), BETWEEN_FRAMES)
        for one in free.made
        if (command := one.reading.command) is not None
    ]
    wrong = next((one for one in free.made if one.reading.command not in one.said), None)
    moved = ""
    if wrong is not None:
        said = " or ".join(map(str, sorted(wrong.said)))
        seen = wrong.reading.reason or f"{wrong.reading.command} was walked"
        moved = f"the lines said {said}: {seen}"
    decision_ns = free.told_ns[0] - free.looks_ns[0]
    figures = decision_ns, max(jitters_ns, default=0), len(free.made), rounds_ns
    return _seen(subject, free.bench, *figures, moved)


def _seen(
    subject: Subject,
    bench: Bench,
    decision_ns: int,
    jitter_ns: int,
    walks: int,
    rounds_ns: int,
    moved: str,
) -> _Seen:
    """Return what was seen, with what the servos have counted."""
    seen = [servo.pulses for servo in bench.parts_of(Servo).values()]
    timing = Timing(
        decision_ns,
        _waiting_ns(subject),
        min(one.shortest_period_ns for one in seen),
        max(one.longest_period_ns for one in seen),
        jitter_ns,
        sum(one.taken for one in seen),
    )
    return _Seen(timing, walks, rounds_ns, sum(one.odd + one.limp for one in seen), moved)


def _trouble(seen: _Seen) -> str:
    """Return what is wrong; "" for nothing."""
    timing = seen.timing
    if timing.longest_frame_ns > FRAME_LIMIT_MS * MS:
        return (
            f"a servo waited {timing.longest_frame_ns / MS:.1f} ms for its pulse, and goes limp "
            f"after {FRAME_LIMIT_MS} ms"
        )
    for what, time_ns, code_ms in (
        ("a decision", timing.decision_ns, CODE_MS),
        ("a look, its decision and its report", seen.rounds_ns, ROUND_CODE_MS),
    ):
        if time_ns > timing.waiting_ns + code_ms * MS:
            return (
                f"{what} took {time_ns / MS:.1f} ms, of which its sensors can use "
                f"{timing.waiting_ns / MS:.1f}"
            )
    if seen.odd:
        return f"{seen.odd} pulses were too long, too short or too late"
    return seen.moved


def _waiting_ns(subject: Subject) -> int:
    robot = subject.robot
    lights = len(robot.light.sensors) if robot.light else 0
    units_ns = len(robot.sonars) * robot.main.pulsin_unit_ns + lights * robot.main.rctime_unit_ns
    rests = len(robot.sonars) if robot.link.step_line is None else len(robot.sonars) - 1
    return LONGEST_COUNT * units_ns + rests * robot.echo.trigger_gap_ms * MS


def _jitter_ns(subject: Subject, command: int, starts: list[int], leading: int) -> int:
    """Return by how much the frames of one pose differ; 0 for a movement that holds."""
    robot, step = subject.robot, subject.robot.steps[command]
    periods = [then - now for now, then in pairwise(starts)]
    if step.order == "hold":
        inside = periods[leading:]
        return max(inside) - min(inside) if inside else 0
    at, worst = leading, 0
    for _, frames in phases_of(robot, step):
        inside = periods[at : at + frames - 1]
        worst = max(worst, max(inside) - min(inside) if inside else 0)
        at += frames
    return worst
