"""When things happen: decisions, servo frames, movements."""

from itertools import pairwise

import pytest

from cgagen.emulator.parts.servo import Pulses, Servo
from cgagen.robot import Robot
from cgagen.robot.gait import phases_of, pulses_counts
from hil.legs_line import walk
from hil.legs_trial import LegsTrial
from hil.lone import MS, Lone
from hil.lone_cases import SEEN_MS, as_asked, subject
from hil.stimuli import neutral

ROBOTS = ("predator", "prey")
LONGEST_FRAME_NS = 45 * MS
"""Every servo gets a pulse at least so often, in every state."""


PULSIN_COUNTS = RCTIME_COUNTS = 65_536
"""So long a chip waits for an echo that never comes, or for the end of the dark."""


def pulses(lone: Lone) -> list[Pulses]:
    return [servo.pulses for servo in lone.bench.parts_of(Servo).values()]


# -- Deciding ---------------------------------------------------------------------------------


@pytest.mark.hil_req("TIME")
@pytest.mark.parametrize("name", ROBOTS)
def test_the_longest_decision_is_the_sum_of_all_time_outs(name: str) -> None:
    """Every PULSIN waits in vain: that is all that there is to wait for, and a little code."""
    robot = subject(name).robot
    lone = Lone(subject(name))
    lone.show(neutral(subject(name).robot))
    as_asked(lone.walk(2))
    times = [go - rise for rise, go in zip(lone.rise_ns, lone.go_ns, strict=False)]
    lights = len(robot.light.sensors) if robot.light else 0
    waiting_ns = len(robot.sonars) * PULSIN_COUNTS * robot.main.pulsin_unit_ns
    waiting_ns += lights * RCTIME_COUNTS * robot.main.rctime_unit_ns
    waiting_ns += (len(robot.sonars) - 1) * robot.echo.trigger_gap_ms * MS  # a 0 has taken no time
    assert all(waiting_ns < one < waiting_ns + 60 * MS for one in times), times


@pytest.mark.hil_req("FRAMES")
@pytest.mark.parametrize("name", ROBOTS)
def test_no_frame_is_lost_while_the_main_controller_measures(name: str) -> None:
    """From the banner over a decision without echo to the end of a movement and another one."""
    lone = Lone(subject(name))
    lone.show(neutral(subject(name).robot))
    as_asked(lone.walk(2))
    seen = pulses(lone)
    assert len(seen) == 12
    assert all(one.taken > 60 and one.odd == one.limp == 0 for one in seen)
    assert max(one.longest_period_ns for one in seen) <= LONGEST_FRAME_NS
    assert min(one.shortest_period_ns for one in seen) > 20 * MS
    later = subject(name).robot.servo_set.start_frames  # frames that each leg starts behind another
    legs = [(one.taken, two.taken) for one, two in zip(seen[::2], seen[1::2], strict=True)]
    assert all(abs(swing - lift) <= 1 for swing, lift in legs)
    taken = [swing - legs[0][0] for swing, _ in legs]
    assert all(abs(one - later * n) <= 1 for n, one in enumerate(taken)), taken
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
    trial.listens()
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
