"""The gait as the locomotion controller stores it: one byte a pulse, shared where equal.

A byte times `pulse_step` is a PULSOUT count: one multiplication on the chip, and rounded to the
nearest step here. On a BS2 the step is 4 counts, 8 us or 0.8 degrees, which is the dead band of a
hobby servo (Ref: S10). Horizontal pulses depend on a movement's two swings and on the pose,
vertical ones on the pose alone; so a movement, its reverse and its like share one swing table.
"""

import math
from dataclasses import dataclass

from cgagen.robot.gait import PHASES, pulses_counts
from cgagen.robot.values import LEGS, Pose, Robot, Step

BYTE_MAX = 255

Row = tuple[int, ...]
"""Six bytes, one a leg, in the order of `LEGS`."""


@dataclass(frozen=True, slots=True)
class SwingTable:
    """Horizontal pulses of the six poses for one pair of swings."""

    label: str
    left_deg: float
    right_deg: float
    rows: tuple[Row, ...]


@dataclass(frozen=True, slots=True)
class Move:
    """How one movement walks the poses.

    Attributes:
        step: the movement.
        table: label of its swing table; of any where the pose is held.
        first_pose: row that it begins with, 0 to 5.
        turn: added to the row, modulo 6, for the next one: 1, or 5 in reverse; 0 holds the pose.
        frames: of a push, or of the hold.
    """

    step: Step
    table: str
    first_pose: int
    turn: int
    frames: int


@dataclass(frozen=True, slots=True)
class GaitTables:
    """Everything that the DATA of a locomotion controller holds, before it becomes text."""

    pulse_step: int
    swings: tuple[SwingTable, ...]
    lifts: tuple[Row, ...]
    stand_swing: Row
    stand_lift: Row
    moves: tuple[Move, ...]


def pulse_step(robot: Robot) -> int:
    """Return the PULSOUT counts of one step of a pulse byte: the least that reaches the longest.

    >>> from cgagen.robot import load_robot
    >>> pulse_step(load_robot("servobot-prey"))
    4
    """
    return math.ceil(robot.servo_set.max_counts / BYTE_MAX)


def pulse_byte(robot: Robot, counts: float) -> int:
    """Return the byte whose pulse is nearest to `counts` and within the servos' limits."""
    step, limits = pulse_step(robot), robot.servo_set
    rounded = math.floor(counts / step + 0.5)
    return max(math.ceil(limits.min_counts / step), min(limits.max_counts // step, rounded))


def walk_of(step: Step) -> tuple[int, int]:
    """Return the first pose, 0 to 5, and what leads from each to the next, modulo 6.

    A reverse walk is 5 4 3 2 1 6 where the forward walk is 1 2 3 4 5 6, so it begins one before
    the last and goes down by one, which is up by five.
    """
    if step.order == "hold":
        return 0, 0
    first = step.first_phase - 1
    return (first, 1) if step.order == "forward" else ((first + PHASES - 2) % PHASES, PHASES - 1)


def gait_tables(robot: Robot) -> GaitTables:
    """Return the tables of a robot, movements in the order of their commands."""
    labels: dict[tuple[float, float], str] = {}
    swings: list[SwingTable] = []
    for step in robot.steps:
        swing = (step.left_deg, step.right_deg)
        if step.order == "hold" or swing in labels:
            continue
        labels[swing] = f"Swing{chr(ord('A') + len(labels))}"
        rows = tuple(_bytes(robot, step, pose)[0::2] for pose in robot.gait.poses)
        swings.append(SwingTable(labels[swing], *swing, rows))
    any_table = swings[0].label if swings else "Lifts"
    standing = Pose(up=(False,) * len(LEGS), forward=(True,) * len(LEGS))
    still = Step(robot.steps[0].movement, 0, 0, 0, "hold", 0, 0.0, 0.0, 1)
    stand = _bytes(robot, still, standing)
    return GaitTables(
        pulse_step=pulse_step(robot),
        swings=tuple(swings),
        lifts=tuple(_bytes(robot, still, pose)[1::2] for pose in robot.gait.poses),
        stand_swing=stand[0::2],
        stand_lift=stand[1::2],
        moves=tuple(
            Move(
                step,
                labels.get((step.left_deg, step.right_deg), any_table)
                if step.order != "hold"
                else any_table,
                *walk_of(step),
                step.frames,
            )
            for step in robot.steps
        ),
    )


def _bytes(robot: Robot, step: Step, pose: Pose) -> tuple[int, ...]:
    return tuple(pulse_byte(robot, counts) for counts in pulses_counts(robot, step, pose))
