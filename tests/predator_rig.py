"""Short names for a rig of the predator, a target at it, and what it is shown."""

from collections.abc import Callable, Iterable

import can

from hil.frames import Frame
from hil.messages import RIG_IDENTITY, pack, unpack
from hil.rig import RigOnBus, SlcanPort
from hil.rig_protocol import Rig
from hil.stimuli import every_state
from hil.target import Stimulus
from tests.rig_cases import Spoiled, Target, ready
from tests.subjects import subject

PREDATOR = "predator"


def readings(number: int = 5) -> list[Stimulus]:
    return list(every_state(subject(PREDATOR).robot).values())[:number]


def rig(role: str = PREDATOR) -> Rig:
    return ready(Rig(subject(role)), role)


def spoilt(spoil: Callable[[Frame], Iterable[Frame | can.Message]]) -> Spoiled:
    return Spoiled(rig(), spoil)


def target(service: RigOnBus | SlcanPort, role: str = PREDATOR) -> Target:
    return Target(service.url, subject(role))


def losing(wanted: int, times: int) -> Callable[[Frame], list[Frame]]:
    """Loses frames of an identifier so many times."""
    left = [times]

    def lose(one: Frame) -> list[Frame]:
        if one.id == wanted and left[0]:
            left[0] -= 1
            return []
        return [one]

    return lose


def spoilt_identity(**changes: int) -> Spoiled:
    def change(one: Frame) -> list[Frame]:
        if one.id != RIG_IDENTITY.id:
            return [one]
        return [Frame(one.id, pack(RIG_IDENTITY, unpack(RIG_IDENTITY, one.data) | changes))]

    return spoilt(change)
