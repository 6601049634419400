"""How long the locomotion controller takes, and what that forbids.

No maker's table of instruction times exists. The model is the emulator's (`cgagen.emulator.timing`,
FIDELITY.md): an instruction of the BS2 takes 18.6 us and 8.05 us for every bit of its token, other
chips in proportion to their published instruction rates; tolerance +-10 %.
"""

from dataclasses import dataclass

from cgagen.bench_protocol import BAUD, FRAME_LIMIT_MS, GO_MS, LOCOMOTION_SLICE_MS, REQUEST_BYTES
from cgagen.errors import RobotError
from cgagen.firmware.gait_tables import GaitTables, gait_tables
from cgagen.robot.gait import frames_of
from cgagen.robot.values import LEGS, Robot

SPEED = {"BS2": 1.0, "BS2e": 1.0, "BS2pe": 1.5, "BS2sx": 2.5, "BS2p": 3.0}
"""Instructions per time, relative to a BS2. Ref: S2 p. 5: 4000, 4000, 6000, 10000, 12000 /s."""

FRAME_CODE_MS = 5.0
"""Twelve PULSOUTs of a byte times a constant, without the pulses themselves.

Like the three below: measured, by the model from the token bits of the generated program, along
the longest way from the last pulse of one frame to the first of the next. A test watches it.
"""

LISTEN_CODE_MS = 1.9
"""A prompt and a SERIN."""

DUMP_CODE_MS = 10.3
"""Four bytes of a dump, read and sent."""

POSE_CODE_MS = 14.8
"""The tables of a movement's first pose."""

CHARACTER_MS = 10 * 1000 / BAUD
"""Start bit, eight data bits, stop bit."""

RISE_FRAME_MS = 30
"""A frame in which legs rise: 24 to 26 ms on the emulator, and some more. Choice."""

BANNER_AND_LISTEN_MS = 1_500
"""Banner and listening: 1.1 s on the emulator, and some more. Choice."""

TELEMETRY_MS = 80
"""A line of telemetry, at most: 75 characters and what is between them."""

FAST_CODE, SOONER = 0.8, 0.9
"""Instructions may be so much faster than the model has them; and what is over before so much of
the shortest movement was cut short. Choice."""

GO_MARGIN = 1.5
"""A movement must be on when the main controller looks, GO_MS after GO. Choice."""


@dataclass(frozen=True, slots=True)
class FrameTimes:
    """The longest times between two pulses of a servo, in ms, by what the chip does meanwhile."""

    listening_ms: float
    dumping_ms: float
    changing_pose_ms: float

    @property
    def longest_ms(self) -> float:
        """The longest of them."""
        return max(self.listening_ms, self.dumping_ms, self.changing_pose_ms)


def frame_times(robot: Robot, tables: GaitTables | None = None) -> FrameTimes:
    """Return the longest gaps between two pulses of a servo.

    It is heard between frames only while the robot stands: centred, or as a movement ends.
    """
    tables = tables or gait_tables(robot)
    speed = SPEED[robot.locomotion.model]
    unit_ms = robot.locomotion.pulsout_unit_ns * tables.pulse_step / 1e6
    poses = [
        (swing, lift)
        for table in tables.swings
        for swing, lift in zip(table.rows, tables.lifts, strict=True)
    ]
    stands = [(tables.stand_swing, tables.stand_lift)]
    stands += [(swing, lift) for swing, lift in poses if lift == tables.stand_lift]
    standing_ms = max(sum(swing) + sum(lift) for swing, lift in stands) * unit_ms
    walking_ms = max(sum(swing) + sum(lift) for swing, lift in [*poses, *stands]) * unit_ms
    frame_ms = FRAME_CODE_MS / speed
    return FrameTimes(
        standing_ms
        + frame_ms
        + LISTEN_CODE_MS / speed
        + LOCOMOTION_SLICE_MS
        + (1 + REQUEST_BYTES) * CHARACTER_MS,
        standing_ms + frame_ms + DUMP_CODE_MS / speed + 8 * CHARACTER_MS,
        walking_ms + frame_ms + POSE_CODE_MS / speed,
    )


def step_timeout_ms(robot: Robot) -> int:
    """Return how long the main controller waits for the legs before it reports them.

    A quarter longer than the longest movement at the longest frame allowed, in tenths of a
    second, and never less than a locomotion controller's start takes.

    >>> from cgagen.robot import load_robot
    >>> step_timeout_ms(load_robot("servobot-predator"))
    2600
    """
    longest_ms = max(frames_of(robot, step) for step in robot.steps) * FRAME_LIMIT_MS * 1.25
    return max(2000, 100 * -int(-longest_ms // 100))


def legs_start_ms(robot: Robot) -> int:
    """Return how long a locomotion controller takes from its reset until it takes a GO.

    >>> from cgagen.robot import load_robot
    >>> legs_start_ms(load_robot("servobot-predator"))
    2940
    """
    return len(LEGS) * robot.servo_set.start_frames * RISE_FRAME_MS + BANNER_AND_LISTEN_MS


def least_step_ms(robot: Robot) -> int:
    """Return what the main controller waits at least for the end of a movement, with margin.

    That is the shortest movement without the time of GO and of a line of telemetry; what is over
    sooner was cut short by a reset. 0 where that is too little to tell.
    """
    shortest_ms = min(frames_of(robot, step) for step in robot.steps) * shortest_frame_ms(robot)
    return max(0, int(shortest_ms * SOONER) - GO_MS - TELEMETRY_MS)


def shortest_frame_ms(robot: Robot) -> float:
    """Return how long the shortest frame of any pose takes at least."""
    tables = gait_tables(robot)
    unit_ms = robot.locomotion.pulsout_unit_ns * tables.pulse_step / 1e6
    stand = [(tables.stand_swing, tables.stand_lift)]
    rows = [
        (swing, lift)
        for table in tables.swings
        for swing, lift in zip(table.rows, tables.lifts, strict=True)
    ]
    pulses_ms = min(sum(swing) + sum(lift) for swing, lift in [*rows, *stand]) * unit_ms
    return pulses_ms + FRAME_CODE_MS / SPEED[robot.locomotion.model] * FAST_CODE


def check_timing(robot: Robot) -> None:
    """Refuse a robot whose servos would go limp, or whose movements are shorter than GO.

    Raises:
        RobotError: what is too long or too short, and what to change.
    """
    longest_ms = frame_times(robot).longest_ms
    if longest_ms > FRAME_LIMIT_MS:
        raise RobotError(
            f"{robot.name}: [servo]: a servo would wait {longest_ms:.0f} ms for its next pulse, "
            f"and {FRAME_LIMIT_MS} ms is allowed; use shorter pulses, smaller trims or a faster "
            "[locomotion] model"
        )
    if robot.link.step_line is None:
        return
    shortest_frame_ms = (
        len(robot.servo_set.servos)
        * robot.servo_set.min_counts
        * robot.locomotion.pulsout_unit_ns
        / 1e6
    )
    for step in robot.steps:
        takes_ms = frames_of(robot, step) * shortest_frame_ms
        if takes_ms < GO_MS * GO_MARGIN:
            least = -int(-GO_MS * GO_MARGIN // shortest_frame_ms)
            key = "hold_frames" if step.order == "hold" else "push_frames"
            raise RobotError(
                f"{robot.name}: [movement.{step.movement}] {key}: the movement may be over after "
                f"{takes_ms:.0f} ms, while the main controller still says GO; give the whole "
                f"movement at least {least} frames"
            )
