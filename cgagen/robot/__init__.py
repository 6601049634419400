"""A robot: a TOML file turned into a frozen value, or refused in one sentence.

`cgagen/robots/*.toml` are the files that ship. Inside this room, `table` reads keys, `reader` (with
`sensor_tables` and `leg_tables`) turns text into the `values`, `checks` asks whether they make
sense together, and `gait` says which pulses a movement is made of.
"""

from cgagen.robot.reader import ROBOTS_FOLDER, load_arena, load_robot, shipped
from cgagen.robot.values import (
    LEGS,
    SONAR_KINDS,
    SONARS,
    Antenna,
    Arena,
    Gait,
    LampCounts,
    Light,
    Policy,
    Pose,
    Reflex,
    Robot,
    Servo,
    ServoSet,
    SituationCounts,
    Sonar,
    Step,
    StepLine,
)

__all__ = [
    "LEGS",
    "ROBOTS_FOLDER",
    "SONARS",
    "SONAR_KINDS",
    "Antenna",
    "Arena",
    "Gait",
    "LampCounts",
    "Light",
    "Policy",
    "Pose",
    "Reflex",
    "Robot",
    "Servo",
    "ServoSet",
    "SituationCounts",
    "Sonar",
    "Step",
    "StepLine",
    "load_arena",
    "load_robot",
    "shipped",
]
