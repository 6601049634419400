"""When things happen: decisions, servo frames, the wire between both Stamps, resets."""

from functools import cache
from itertools import pairwise
from pathlib import Path

import pytest

from cgagen.emulator.parts.servo import Pulses, Servo
from cgagen.robot import Robot
from cgagen.robot.gait import phases_of, pulses_counts
from hil.legs_line import walk
from hil.legs_trial import LegsTrial
from hil.lone import MS, OFF_NS, WORD, Lone, Walk
from hil.subject import Subject, read_subject
from hil.target import Stimulus

FIRMWARE = Path(__file__).parents[1] / "firmware"
ROBOTS = ("predator", "prey")

LONGEST_FRAME_NS = 45 * MS
"""Every servo gets a pulse at least so often, in every state."""

SEEN_MS = 40
"""After that the legs have seen the line high, and may be told; sensing takes longer still."""

PULSIN_COUNTS = RCTIME_COUNTS = 65_536
"""So long a chip waits for an echo that never comes, or for the end of the dark."""


@cache
def subject(name: str) -> Subject:
    return read_subject(FIRMWARE / name)


def nothing(name: str) -> Stimulus:
    """No echo at all, and no light."""
    robot = subject(name).robot
    return Stimulus((0,) * len(robot.sonars), lights=(0, 0) if robot.light else ())


def far(name: str) -> Stimulus:
    """What a robot in the open sees: the longest echo of every sonar."""
    robot = subject(name).robot
    return Stimulus((23_124,) * len(robot.sonars), lights=(0, 0) if robot.light else ())


def pulses(lone: Lone) -> list[Pulses]:
    return [servo.pulses for servo in lone.bench.parts_of(Servo).values()]


def as_asked(walk: Walk | None) -> Walk:
    """A movement that is there, and the one that the lines said."""
    assert walk is not None
    assert walk.made.command == walk.asked, walk.made.reason
    return walk


# -- Deciding ---------------------------------------------------------------------------------


@pytest.mark.hil_req("TIME")
@pytest.mark.parametrize("name", ROBOTS)
def test_the_longest_decision_is_the_sum_of_all_time_outs(name: str) -> None:
    """Every PULSIN waits in vain: that is all that there is to wait for, and a little code."""
    robot = subject(name).robot
    lone = Lone(subject(name))
    lone.show(nothing(name))
    as_asked(lone.walk(2))
    times = [go - rise for rise, go in zip(lone.rise_ns, lone.go_ns, strict=False)]
    lights = len(robot.light.sensors) if robot.light else 0
    waiting_ns = len(robot.sonars) * PULSIN_COUNTS * robot.main.pulsin_unit_ns
    waiting_ns += lights * RCTIME_COUNTS * robot.main.rctime_unit_ns
    assert all(waiting_ns < one < waiting_ns + 60 * MS for one in times), times


@pytest.mark.hil_req("FRAMES")
@pytest.mark.parametrize("name", ROBOTS)
def test_no_frame_is_lost_while_the_main_controller_measures(name: str) -> None:
    """From the banner over a decision without echo to the end of a movement and another one."""
    lone = Lone(subject(name))
    lone.show(nothing(name))
    as_asked(lone.walk(2))
    seen = pulses(lone)
    assert len(seen) == 12
    assert all(one.taken > 60 and one.odd == one.limp == 0 for one in seen)
    assert max(one.longest_period_ns for one in seen) <= LONGEST_FRAME_NS
    assert min(one.shortest_period_ns for one in seen) > 20 * MS
    assert max(one.taken for one in seen) - min(one.taken for one in seen) <= 1
    assert lone.uncommanded == []


@pytest.mark.hil_req("FRAMES")
def test_frames_keep_their_period_within_a_movement() -> None:
    """Between phases the tables are read, which takes half a frame; within one nothing varies."""
    lone = Lone(subject("predator"), mute=True)
    lone.stand()
    lone.run(SEEN_MS)
    lone.go(4)
    walk = as_asked(lone.walk())
    starts = [pulse.start_ns for pulse in walk.train.pulses[0]]
    periods = [then - now for now, then in pairwise(starts)]
    assert max(periods) <= 40 * MS
    # A frame's length is the sum of its pulses and of the code between them: it changes with
    # the pose, never within one.
    robot, step = subject("predator").robot, subject("predator").robot.steps[4]
    at = 1
    for _, frames in phases_of(robot, step):
        inside = periods[at : at + frames - 1]
        assert max(inside) - min(inside) < 1_000, inside
        at += frames


# -- Pulse widths -----------------------------------------------------------------------------


@pytest.mark.hil_req("GAIT")
@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("command", range(8))
def test_every_pulse_of_every_movement_is_the_gaits_in_chip_units(name: str, command: int) -> None:
    robot = subject(name).robot
    lone = Lone(subject(name), mute=True)
    lone.stand()
    lone.run(SEEN_MS)
    lone.go(command)
    walk = as_asked(lone.walk())
    assert walk.asked == command
    rows = lone.player.gait.widths_counts(walk.train)
    assert all(one == int(one) for row in rows for one in row)
    for row, wanted in zip(rows, wanted_counts(robot, command), strict=True):
        assert all(abs(one - other) <= 2 for one, other in zip(row, wanted, strict=True))
        assert all(one % 4 == 0 for one in row)


@pytest.mark.hil_req("GAIT")
@pytest.mark.parametrize("name", ROBOTS)
def test_every_movement_is_whole_after_every_other_and_after_itself(name: str) -> None:
    """All 64 in a row: nothing of a movement is left that could change the next one."""
    one = subject(name)
    trial = LegsTrial(one, one.images["locomotion"])
    assert trial.wait("step 1", 3_000)
    order = each_after_each(8)
    assert len(set(pairwise(order))) == 64
    for command in order[1:]:
        trial.go_on(SEEN_MS)
        trial.command(command)
        walk(trial, command)


def each_after_each(things: int) -> list[int]:
    """The shortest row in which each of some numbers comes after each: a walk along all arrows."""
    row, walked = list[int](), [0] * things
    ahead = [0]
    while ahead:
        last = ahead[-1]
        if walked[last] < things:
            ahead.append(walked[last])
            walked[last] += 1
        else:
            row.append(ahead.pop())
    return row[::-1]


def wanted_counts(robot: Robot, command: int) -> list[tuple[float, ...]]:
    """The frames of a movement from standing, the leading one included."""
    step = robot.steps[command]
    stand = tuple(float(robot.servo_set.centre_counts) for _ in robot.servo_set.servos)
    if step.order == "hold":
        return [stand] * (step.frames + 1)
    rows = [stand]
    for pose, frames in phases_of(robot, step):
        rows += [pulses_counts(robot, step, robot.gait.poses[pose])] * frames
    return rows


# -- The wire between both Stamps -------------------------------------------------------------


@pytest.mark.hil_req("GO")
@pytest.mark.parametrize("phase_ms", range(0, 26, 2))
def test_a_go_at_any_phase_of_a_frame_is_one_movement_and_the_one_asked(phase_ms: int) -> None:
    lone = Lone(subject("predator"), mute=True)
    lone.stand()
    lone.run(SEEN_MS + phase_ms)
    command = 1 + phase_ms // 2 % 7
    lone.go(command)
    assert as_asked(lone.walk()).asked == command
    lone.run(200)
    assert len(lone.walks) == 1
    assert lone.uncommanded == []


@pytest.mark.hil_req("GO")
@pytest.mark.parametrize("hold_ms", [0.02, 0.1, 0.5, 1, 2, 5, 10, 15, 20, 24, 26, 30, 50, 400])
def test_a_go_of_any_length_is_taken_whole_or_not_at_all(hold_ms: float) -> None:
    """The legs look once in a frame of 24 ms: a shorter GO may be missed, never misread."""
    lone = Lone(subject("predator"), mute=True)
    lone.stand()
    lone.run(31)
    lone.go(5, hold_ms)
    walk = lone.walk(limit_ms=2_000)
    if hold_ms >= 26:
        assert walk is not None
    if walk is not None:
        assert as_asked(walk).asked == 5
    lone.run(100)
    assert len(lone.walks) <= 1
    assert lone.uncommanded == []
    assert lone.words["locomotion"].count("*LINES") == 0


@pytest.mark.hil_req("GO")
@pytest.mark.parametrize("early_ms", [0, 5, 10, 15, 20, 24])
def test_a_go_before_the_legs_have_seen_the_line_high_is_left_alone(early_ms: int) -> None:
    """No main controller senses in so short a time; if one did, it would hear a refusal."""
    lone = Lone(subject("predator"), mute=True)
    lone.stand()
    lone.run(early_ms)
    lone.go(6)
    lone.run(100)
    assert lone.line.level == 1 or lone.referee.walks(WORD)
    walk = lone.walk(limit_ms=1_500)
    if walk is not None:
        assert as_asked(walk).asked == 6
    assert lone.uncommanded == []


@pytest.mark.hil_req("GO")
def test_without_go_nothing_moves_whatever_the_lines_say() -> None:
    lone = Lone(subject("predator"), mute=True)
    lone.stand()
    for command in (1, 7, 2, 5, 0):
        for bit in range(3):
            lone.bench.wire(f"{WORD}_command_{bit}").drive("tester", command >> bit & 1)
        lone.run(90)
    assert lone.walks == []
    lone.go(3)
    assert as_asked(lone.walk()).asked == 3
    assert lone.uncommanded == []


@pytest.mark.hil_req("GO")
@pytest.mark.parametrize("late_ms", [0, 3, 7, 11, 16, 22, 600, 1_300])
def test_both_chips_may_be_switched_on_at_different_times(late_ms: int) -> None:
    """Either chip comes late: the first movement and the second are the ones decided."""
    for late in ("main", "locomotion"):
        lone = Lone(subject("predator"))
        lone.show(far("predator"))
        lone.reset(late, late_ms * MS)
        for _ in range(2):
            walk = as_asked(lone.walk())
            lone.run(30)
            assert lone.player.said is not None
            assert lone.player.said.command == walk.asked
        assert lone.uncommanded == []


@pytest.mark.hil_req("GO")
def test_a_go_that_nobody_takes_is_reported_and_said_again() -> None:
    """A locomotion controller that is off drives nothing: the line rises after GO."""
    lone = Lone(subject("predator"))
    lone.show(far("predator"))
    lone.reset("locomotion", OFF_NS)
    lone.run(4_000)
    assert lone.walks == []
    assert lone.player.heard.count("*REFUSED") >= 2
    lone.reset("locomotion")
    as_asked(lone.walk())
    assert lone.uncommanded == []


@pytest.mark.hil_req("GO")
def test_legs_that_never_stand_are_reported() -> None:
    """The step line is shorted to ground: nobody moves, both chips say so."""
    lone = Lone(subject("predator"))
    lone.show(far("predator"))
    lone.line.drive("short", 0)
    lone.run(9_000)
    assert lone.walks == []
    assert "*BUSY" in lone.player.heard
    assert "*LOW" in lone.words["locomotion"]


# -- Resets and brown-outs --------------------------------------------------------------------


def walking(at_ms: float) -> Lone:
    """A predator so long after it accepted its first movement."""
    lone = Lone(subject("predator"))
    lone.show(far("predator"))
    lone.bench.run(first_accepted_ns() + round(at_ms * MS))
    return lone


@cache
def first_accepted_ns() -> int:
    lone = Lone(subject("predator"))
    lone.show(far("predator"))
    return as_asked(lone.walk()).accepted_ns


TIMES_MS = (-900, -200, -40, -10, 2, 60, 130, 400, 900, 1_215, 1_230, 1_300)
"""From boot over sensing, GO and the movement to the next sensing."""


@pytest.mark.hil_req("RESET")
@pytest.mark.parametrize("at_ms", TIMES_MS)
def test_a_reset_of_the_main_controller_moves_nothing(at_ms: float) -> None:
    """The movement under way is finished, and the next one is told."""
    lone = walking(at_ms)
    lone.reset("main")
    for _ in range(2):
        as_asked(lone.walk())
    assert lone.uncommanded == []


@pytest.mark.hil_req("RESET")
@pytest.mark.parametrize("at_ms", TIMES_MS)
def test_a_reset_of_the_locomotion_controller_centres_the_legs_and_no_more(at_ms: float) -> None:
    lone = walking(at_ms)
    before = len(lone.walks)
    lone.reset("locomotion", 5 * MS)
    cut = lone.walks[before:]  # a movement that was under way ends with the reset
    lone.run(10)
    lone.stand()
    stand = round(subject("predator").robot.servo_set.centre_counts * 2_000 / MS, 1)
    centred = [round(one / MS, 1) for one in lone.player.gait.rest]
    assert centred == [stand] * 12
    as_asked(lone.walk())
    as_asked(lone.walk())
    assert all(walk.made.command in (None, walk.asked) for walk in cut)  # all of it, or no other
    assert lone.uncommanded == []


@pytest.mark.hil_req("RESET")
@pytest.mark.parametrize("at_ms", TIMES_MS)
def test_a_brown_out_of_both_is_a_power_up(at_ms: float) -> None:
    lone = walking(at_ms)
    for chip in ("main", "locomotion"):
        lone.reset(chip, 200 * MS)
    before = len(lone.walks)
    as_asked(lone.walk(2))
    assert [walk.made.command for walk in lone.walks[before:]] == [
        walk.asked for walk in lone.walks[before:]
    ]
    assert lone.uncommanded == []


@pytest.mark.hil_req("RESET")
@pytest.mark.parametrize(
    "at_ms", [-3, -2, -1.5, -1, -0.5, -0.1, 0, 0.3, 0.6, 0.9, 1.2, 1.6, 2, 3, 50, 99]
)
def test_a_reset_of_the_main_controller_in_the_middle_of_go(at_ms: float) -> None:
    """Its lines let go and read 000, which is FORWARD; but the step line lets go with them, and
    GO has to outlast the reading of the command.
    """
    lone = walking(at_ms)
    lone.reset("main")
    walk = lone.walk()
    assert walk is not None
    assert walk.made.command == 4
    as_asked(lone.walk())
