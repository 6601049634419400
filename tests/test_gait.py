"""Poses, frames and pulses of the eight movements."""

from dataclasses import replace

import pytest

from cgagen.robot import LEGS, Robot, load_robot
from cgagen.robot.gait import angles_deg, frames_of, phases_of, pulses_counts
from cgagen.robot.values import Step
from cgagen.words import Movement
from tests.pursuit import content, robot_from

PREDATOR, PREY = load_robot("servobot-predator"), load_robot("servobot-prey")

FORWARD_MASKS = (0x56A, 0x555, 0x015, 0xA95, 0xAAA, 0x02A)
"""Bits 11 to 6: lifted; bits 5 to 0: forward; legs LF LM LR RF RM RR."""

WALKS = {
    (1, "forward"): (0x56A, 0x555, 0x015, 0xA95, 0xAAA, 0x02A),
    (1, "reverse"): (0xAAA, 0xA95, 0x015, 0x555, 0x56A, 0x02A),
    (4, "forward"): (0xA95, 0xAAA, 0x02A, 0x56A, 0x555, 0x015),
    (4, "reverse"): (0x555, 0x56A, 0x02A, 0xAAA, 0xA95, 0x015),
}

MOVES = [
    (robot, step) for robot in (PREDATOR, PREY) for step in robot.steps if step.order != "hold"
]


def mask(robot: Robot, pose: int) -> int:
    flags = robot.gait.poses[pose]
    return int("".join(str(int(flag)) for flag in (*flags.up, *flags.forward)), 2)


def named(value: object) -> str:
    return value.movement if isinstance(value, Step) else getattr(value, "name", "")


def test_the_poses_are_those_of_a_tripod() -> None:
    for robot in (PREDATOR, PREY):
        assert tuple(mask(robot, pose) for pose in range(6)) == FORWARD_MASKS
        for pose in robot.gait.poses:
            lifted = {leg for leg, up in zip(LEGS, pose.up, strict=True) if up}
            assert lifted in (set(), {"LF", "RM", "LR"}, {"LM", "RF", "RR"})


@pytest.mark.parametrize(("robot", "step"), MOVES, ids=named)
def test_the_order_of_the_poses(robot: Robot, step: Step) -> None:
    walked = tuple(mask(robot, phase.pose) for phase in phases_of(robot, step))
    assert walked == WALKS[step.first_phase, step.order]


@pytest.mark.parametrize(
    ("movement", "order", "first", "left_deg", "right_deg", "frames"),
    [
        (Movement.FORWARD, "forward", 1, 11.5, 11.5, 32),
        (Movement.BACKWARD, "reverse", 1, 10, 10, 32),
        (Movement.RIGHT_FORWARD, "forward", 1, 27, -19, 46),
        (Movement.LEFT_FORWARD, "forward", 4, -19, 27, 46),
        (Movement.ROTATE_RIGHT, "forward", 1, 27, -27, 46),
        (Movement.ROTATE_LEFT, "reverse", 1, 27, -27, 46),
        (Movement.BACKUP_RIGHT, "reverse", 1, 27, -19, 46),
        (Movement.BACKUP_LEFT, "reverse", 4, -19, 27, 46),
    ],
)
def test_the_predators_gaits(
    movement: Movement, order: str, first: int, left_deg: float, right_deg: float, frames: int
) -> None:
    step = next(step for step in PREDATOR.steps if step.movement is movement)
    row = (step.order, step.first_phase, step.left_deg, step.right_deg)
    assert row == (order, first, left_deg, right_deg)
    assert frames_of(PREDATOR, step) == frames


def test_the_preys_gaits_differ_in_two() -> None:
    forward, wait = PREY.steps[0], PREY.steps[1]
    assert (forward.left_deg, forward.right_deg, frames_of(PREY, forward)) == (7.75, 7.75, 32)
    assert (wait.movement, wait.order, frames_of(PREY, wait)) == (Movement.WAIT, "hold", 32)
    for ours, theirs in zip(PREY.steps[2:], PREDATOR.steps[2:], strict=True):
        assert ours.movement is theirs.movement
        assert frames_of(PREY, ours) == frames_of(PREDATOR, theirs) == 46


def test_a_wait_has_no_phases() -> None:
    with pytest.raises(ValueError, match="WAIT"):
        phases_of(PREY, PREY.steps[1])


@pytest.mark.parametrize(("robot", "step"), MOVES, ids=named)
def test_each_phase_gets_its_frames(robot: Robot, step: Step) -> None:
    """Lift, push, lower, twice, forward or in reverse."""
    frames = [phase.frames for phase in phases_of(robot, step)]
    assert frames == [6, step.frames, 6, 6, step.frames, 6]
    uneven = replace(robot, gait=replace(robot.gait, lift_frames=5, lower_frames=9))
    before = uneven.gait.poses[phases_of(uneven, step)[-1].pose].up
    for phase in phases_of(uneven, step):
        up = uneven.gait.poses[phase.pose].up
        wanted = 5 if sum(up) > sum(before) else 9 if sum(up) < sum(before) else step.frames
        assert phase.frames == wanted
        before = up


@pytest.mark.parametrize(("robot", "step"), MOVES, ids=named)
def test_a_movement_ends_with_the_left_front_leg_forward_and_down(robot: Robot, step: Step) -> None:
    """Ref: S1 section II.A. The next movement starts from there."""
    last = robot.gait.poses[phases_of(robot, step)[-1].pose]
    assert not any(last.up)
    angles = angles_deg(robot, step, last)
    assert angles[0] > 0  # forward
    assert angles[1] == 0  # down
    assert angles[0] == abs(step.left_deg)


@pytest.mark.parametrize(("robot", "step"), MOVES, ids=named)
def test_legs_swing_only_while_their_tripod_is_up_or_pushes(robot: Robot, step: Step) -> None:
    """While legs are lifted or lowered nothing moves along the ground."""
    before = robot.gait.poses[phases_of(robot, step)[-1].pose]
    for number, phase in enumerate(phases_of(robot, step)):
        pose = robot.gait.poses[phase.pose]
        if number % 3 == 1:
            assert pose.up == before.up
            assert all(a != b for a, b in zip(pose.forward, before.forward, strict=True))
        else:
            assert pose.forward == before.forward
            assert pose.up != before.up
        before = pose


@pytest.mark.parametrize(("robot", "step"), MOVES, ids=named)
def test_the_legs_push_where_the_table_says(robot: Robot, step: Step) -> None:
    """Standing legs that swing back push the body on; more on the right turns it left."""
    push = {"L": 0.0, "R": 0.0}
    before = robot.gait.poses[phases_of(robot, step)[-1].pose]
    for phase in phases_of(robot, step):
        pose = robot.gait.poses[phase.pose]
        pairs = zip(angles_deg(robot, step, before), angles_deg(robot, step, pose), strict=True)
        swings = [after - angle for angle, after in pairs][::2]
        for leg, up, swing in zip(LEGS, pose.up, swings, strict=True):
            push[leg[0]] -= 0.0 if up else swing
        before = pose
    along, turn = push["L"] + push["R"], push["R"] - push["L"]
    assert along == 0 or (along > 0) == (step.along_units > 0)
    assert turn == 0 or (turn > 0) == (step.turn_deg > 0)
    assert (along == 0) == (abs(step.along_units) < 0.2)
    assert (turn == 0) == (abs(step.turn_deg) < 5)


@pytest.mark.parametrize(
    ("order", "other"),
    [(Movement.FORWARD, Movement.BACKWARD), (Movement.RIGHT_FORWARD, Movement.BACKUP_RIGHT),
     (Movement.LEFT_FORWARD, Movement.BACKUP_LEFT)],
)  # fmt: skip
def test_backing_is_the_same_walk_backwards_in_time(order: Movement, other: Movement) -> None:
    by_movement = {step.movement: step for step in PREDATOR.steps}
    there = [phase.pose for phase in phases_of(PREDATOR, by_movement[order])]
    back = [phase.pose for phase in phases_of(PREDATOR, by_movement[other])]
    assert [there[-1], *back] == [there[-1], *there][::-1]


def test_pulses_of_the_worked_poses() -> None:
    forward = PREDATOR.steps[0]
    first, last = PREDATOR.gait.poses[0], PREDATOR.gait.poses[5]
    # LF LM LR on the left, RF RM RR mirrored; horizontal, vertical.
    swing = 11.5 * 5
    assert pulses_counts(PREDATOR, forward, last) == (
        750 + swing, 750, 750 - swing, 750, 750 + swing, 750,
        750 + swing, 750, 750 - swing, 750, 750 + swing, 750,
    )  # fmt: skip
    lifted = pulses_counts(PREDATOR, forward, first)[1::2]
    assert lifted == (750, 900, 750, 600, 750, 600)


def test_trim_and_direction_are_of_each_servo() -> None:
    changed = content("servobot-predator")
    changed["servo"]["trim_counts"]["LM"] = [7, -11]
    changed["servo"]["direction"]["RR"] = [1, 1]
    robot = robot_from(changed)
    step, pose = robot.steps[0], robot.gait.poses[0]
    plain, trimmed = pulses_counts(PREDATOR, step, pose), pulses_counts(robot, step, pose)
    moved = [b - a for a, b in zip(plain, trimmed, strict=True)]
    assert moved[2:4] == [7, -11]
    assert moved[10:] == [2 * (trimmed[10] - 750), 300]
    assert moved[:2] + moved[4:10] == [0] * 8


@pytest.mark.parametrize(("robot", "step"), MOVES, ids=named)
def test_no_pulse_leaves_the_servos_limits(robot: Robot, step: Step) -> None:
    for pose in robot.gait.poses:
        widths = pulses_counts(robot, step, pose)
        assert len(widths) == 12
        assert 500 <= min(widths) <= max(widths) <= 1000
