"""What the tests of traces share."""

from pathlib import Path
from typing import Any

from cgagen.robot import load_robot
from hil.simulated import SimulatedTarget
from hil.stimuli import every_state
from hil.subject import Subject
from hil.target import Stimulus
from hil.traces import Trace
from hil.traces.recording import record_readings
from hil.traces.storage import trace_bytes
from hil.traces.vectors import header_of

FIRMWARE = Path(__file__).parent.parent / "firmware"
PREDATOR = load_robot("servobot-predator")
PREY = load_robot("servobot-prey")
HEAD = header_of(PREDATOR)
CALM = "0,0,0,0,0,0,0"


def simulated(subject: Subject, stimuli: list[Stimulus]) -> Trace:
    return record_readings(subject, SimulatedTarget(subject), stimuli, {"test": 1})[0]


def some(subject: Subject, count: int = 6) -> Trace:
    return simulated(subject, list(every_state(subject.robot).values())[:count])


def log_of(trace: Trace, robot: Any = PREDATOR) -> str:
    return trace_bytes(trace, robot, ".log").decode()
