"""The robots behind an emulated rig: from a reading to CAN frames, pins, the program, and back.

The same as on a physical rig, but for the rig itself: the true driver of serial CAN adapters on a
pty, and python-can's virtual bus.
"""

import os
from collections.abc import Callable, Iterator, Sequence

import pytest

from hil.canbus import CanTarget
from hil.equivalence import Trial
from hil.messages import Fault
from hil.rig import RigOnBus, SlcanPort
from hil.rig_protocol import Rig
from hil.simulated import SimulatedTarget
from hil.stimuli import between, every_state, neutral, sonar_limits, thresholds, with_values
from hil.subject import Subject
from hil.target import Stimulus, Target

pytestmark = pytest.mark.hil_req("RIG")

Check = Callable[[Target, Sequence[Stimulus]], Trial]


@pytest.fixture(scope="module")
def rig(hil_subject: Subject) -> Iterator[Rig]:
    one = Rig(hil_subject)
    one.open()
    yield one
    one.close()


@pytest.fixture
def on_a_bus(rig: Rig, hil_subject: Subject) -> Iterator[CanTarget]:
    with RigOnBus(rig, f"rig-{os.getpid()}") as bus:
        target = CanTarget(bus.url, hil_subject)
        target.open()
        yield target
        target.close()
    assert bus.failure is None


def test_every_state_on_a_virtual_bus(
    on_a_bus: CanTarget, hil_subject: Subject, hil_check: Check
) -> None:
    reached = every_state(hil_subject.robot)
    trial = hil_check(on_a_bus, list(reached.values()))
    assert set(trial.agreed) == set(reached)
    assert (trial.stale, trial.left_out, on_a_bus.unheard) == (0, 0, 0)


def test_thresholds_through_a_serial_adapter(
    rig: Rig, hil_subject: Subject, hil_check: Check
) -> None:
    readings = list(thresholds(hil_subject.robot))[::4]
    with SlcanPort(rig, "pty") as port:
        target = CanTarget(port.url, hil_subject)
        target.open()
        trial = hil_check(target, readings)
        target.close()
    assert trial.decisions == len(readings)
    assert port.failure is None


def test_a_sonar_that_falls_silent_on_the_rig(on_a_bus: CanTarget, hil_subject: Subject) -> None:
    """What it saw is not seen; the fault has fired, and is gone with the next question."""
    robot = hil_subject.robot
    plain = neutral(robot)
    near = with_values(plain, {0: between(sonar_limits(robot)[0])[0]})
    oracle = SimulatedTarget(hil_subject)
    for stimulus, fault, seen in (
        (near, Fault.NO_ECHO_0, plain),
        (near, Fault.NONE, near),
        (plain, Fault.NO_ECHO_0, plain),
    ):
        assert on_a_bus.decide(stimulus, fault).command == oracle.decide(seen).command
        assert on_a_bus.fired is {(near, True): True, (plain, True): False}.get(
            (stimulus, fault != Fault.NONE)
        )


def test_the_servos_are_seen_on_the_bus(on_a_bus: CanTarget, hil_subject: Subject) -> None:
    on_a_bus.decide(neutral(hil_subject.robot))
    robot = hil_subject.robot
    unit_ns, servos = robot.locomotion.pulsout_unit_ns, robot.servo_set
    for pulses in on_a_bus.servos(10):
        assert all(width % unit_ns == 0 for width in pulses)
        assert all(servos.min_counts <= width // unit_ns <= servos.max_counts for width in pulses)
