"""Rigs for the tests of the CAN target: whole ones, and such that spoil what they say or hear."""

import os
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from itertools import count

import can

from cgagen.emulator.bench import BenchState
from hil.canbus import CanTarget
from hil.frames import Frame, frame
from hil.messages import RIG_CMD, RIG_STATUS, Op, State, unpack
from hil.rig import RigOnBus
from hil.rig_protocol import Rig
from hil.rig_robot import RigRobot
from hil.stimuli import neutral
from hil.subject import Subject
from hil.target import Stimulus
from tests.subjects import subject

_NAMES = count(1)


def channel() -> str:
    """A name of a virtual bus that nobody else has."""
    return f"test-{os.getpid()}-{next(_NAMES)}"


def opened(rig: Rig) -> Rig:
    rig.open()
    return rig


class WarmRobot(RigRobot):
    """Is switched on once; later it goes back to the moment to which that has led."""

    def open(self) -> None:
        if self._on is None:
            super().open()
            self._on = self.bench.snapshot()
        self.bench.restore(self._on)

    def close(self) -> None:
        """The next test has it."""

    _on: BenchState | None = None


@cache
def _robot(role: str) -> RigRobot:
    return WarmRobot(subject(role))


def ready(rig: Rig, role: str = "predator") -> Rig:
    """The rig, open, with a robot that all tests share."""
    rig.robot = _robot(role)
    return opened(rig)


def nothing(role: str) -> Stimulus:
    return neutral(subject(role).robot)


class Spoiled(RigOnBus):
    """Says something else than the rig does.

    Args:
        spoil: given a frame of the rig; returns what comes on the bus instead.
    """

    def __init__(
        self, rig: Rig, spoil: Callable[[Frame], Iterable[Frame | can.Message]] = lambda one: [one]
    ) -> None:
        super().__init__(rig, channel())
        self.spoil = spoil

    def send(self, one: Frame) -> None:
        for other in self.spoil(one):
            if isinstance(other, can.Message):
                self._bus.send(other)
            else:
                super().send(other)


class Hearing(Rig):
    """Hears something else than what is said.

    Args:
        hear: given a frame of the host; returns what the rig hears instead.
    """

    def __init__(self, one: Subject, hear: Callable[[Frame], Iterable[Frame]]) -> None:
        super().__init__(one)
        self.hear = hear

    def receive(self, given: Frame) -> Iterator[Frame]:
        for other in self.hear(given):
            yield from super().receive(other)


class Target(CanTarget):
    """In a `with`."""

    def __enter__(self) -> "Target":
        self.open()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def command(op: int, seq: int = 1, argument: int = 0) -> Frame:
    return frame(RIG_CMD, OP=op, SEQ=seq, ARG=argument)


@cache
def _shared() -> Rig:
    return opened(Rig(subject("predator")))


def greeted() -> Rig:
    """One rig for all tests that leave it as it was, greeted anew."""
    one = _shared()
    if unpack(RIG_STATUS, one.heartbeat().data)["STATE"] in (State.OFF, State.FAULT):
        list(one.receive(command(Op.POWER_ON)))
    list(one.receive(command(Op.HELLO)))
    return one
