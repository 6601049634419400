"""Which pulses a movement is made of: pose by pose, servo by servo.

Ref: S1 II.A for the start and the end of a step (left front leg forward and down). The poses
and their order are in the robot's file.
"""

from typing import NamedTuple

from cgagen.robot.values import LEGS, Pose, Robot, Step

PHASES = 6
"""Poses of one gait cycle: lift, push, lower for one tripod, then for the other. Choice."""


class Phase(NamedTuple):
    """One part of a movement.

    Attributes:
        pose: which pose of the gait the servos go to, 0 to 5.
        frames: how many servo frames they are given for it.
    """

    pose: int
    frames: int


def phases_of(robot: Robot, step: Step) -> tuple[Phase, ...]:
    """Return the six phases of a movement in the order in which they are walked.

    A reverse walk takes the poses of the forward walk backwards in time, so that it ends in the
    same pose: 1 2 3 4 5 6 becomes 5 4 3 2 1 6. Both lift, push and lower, twice.

    Raises:
        ValueError: the movement holds its pose and has no phases.
    """
    if step.order == "hold":
        raise ValueError(f"{step.movement} holds its pose and has no phases")
    walk = [(step.first_phase - 1 + index) % PHASES for index in range(PHASES)]
    if step.order == "reverse":
        walk = [*walk[-2::-1], walk[-1]]
    frames = (robot.gait.lift_frames, step.frames, robot.gait.lower_frames)
    return tuple(Phase(pose, frames[index % 3]) for index, pose in enumerate(walk))


def frames_of(robot: Robot, step: Step) -> int:
    """Return the servo frames of a whole movement."""
    if step.order == "hold":
        return step.frames
    return sum(phase.frames for phase in phases_of(robot, step))


def angles_deg(robot: Robot, step: Step, pose: Pose) -> tuple[float, ...]:
    """Return the twelve joint angles of a pose, in the order of the servos.

    A horizontal angle is positive forward, a vertical one positive up; the leg that stands has
    a vertical angle of 0.
    """
    angles = []
    for leg, up, forward in zip(LEGS, pose.up, pose.forward, strict=True):
        swing = step.left_deg if leg.startswith("L") else step.right_deg
        angles.append(swing if forward else -swing)
        angles.append(robot.gait.lift_deg if up else 0.0)
    return tuple(angles)


def pulses_counts(robot: Robot, step: Step, pose: Pose) -> tuple[float, ...]:
    """Return the twelve pulse widths of a pose in PULSOUT counts, not rounded or limited."""
    servo_set = robot.servo_set
    return tuple(
        servo_set.centre_counts
        + servo.trim_counts
        + servo.direction * angle * servo_set.counts_per_deg
        for servo, angle in zip(servo_set.servos, angles_deg(robot, step, pose), strict=True)
    )
