"""What the tests of traces share."""

from typing import Any

import can

from cgagen.robot import load_robot
from hil.simulated import SimulatedTarget
from hil.stimuli import every_state
from hil.subject import Subject
from hil.target import Stimulus
from hil.traces import Sample, Trace
from hil.traces.candump import parse_log
from hil.traces.questions import frames_of_samples, samples_of
from hil.traces.recording import record_readings
from hil.traces.storage import trace_bytes
from hil.traces.vectors import header_of
from tests.subjects import subject

PREDATOR = load_robot("servobot-predator")
PREY = load_robot("servobot-prey")
HEAD = header_of(PREDATOR)
CALM = "0,0,0,0,0,0,0"


def predator() -> Subject:
    return subject("predator")


def simulated(subject: Subject, stimuli: list[Stimulus]) -> Trace:
    return record_readings(subject, SimulatedTarget(subject), stimuli, {"test": 1})[0]


def some(subject: Subject, count: int = 6) -> Trace:
    return simulated(subject, list(every_state(subject.robot).values())[:count])


def log_of(trace: Trace, robot: Any = PREDATOR) -> str:
    return trace_bytes(trace, robot, ".log").decode()


def parsed(text: str, robot: Any = PREDATOR) -> tuple[tuple[Sample, ...], int]:
    return samples_of(parse_log(text, "a.log"), "a.log", robot)


def messages(trace: Trace, epoch_s: float = 0.0, channel: Any = "can0") -> list[can.Message]:
    """Return a trace as python-can's messages; they are extended unless one says otherwise."""
    return [
        can.Message(
            timestamp=epoch_s + time_us / 1e6,
            arbitration_id=frame.id,
            is_extended_id=False,
            is_rx=frame.id >= 0x200,
            channel=channel,
            data=frame.data,
        )
        for time_us, frame in frames_of_samples(trace.samples, PREDATOR)
    ]
