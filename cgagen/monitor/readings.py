"""What the sensors of a robot at work have counted, from its telemetry."""

import time
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

from cgagen.bench_protocol import plain
from cgagen.errors import IdentityError, RigError
from cgagen.monitor.decode import Decoder, Line
from cgagen.monitor.listen import Listener, Port
from cgagen.monitor.suspects import Suspects
from cgagen.robot import Robot
from cgagen.robot.values import SIDES
from cgagen.telemetry import Telemetry

LIGHT_PREFIX = "light_"
"""Before the name of a light sensor, as in the tables of `cgagen calibrate`."""

SILENCE_S = 8.0
"""How long a robot at work may be silent: a gait cycle takes less than half of it. Choice."""


class Seen(NamedTuple):
    """One sensor over some decisions: the lowest, mean and highest count, and how many."""

    low: int
    mean: float
    high: int
    readings: int


def sensor_names(robot: Robot) -> tuple[str, ...]:
    """Return the sensors that count, in the order of telemetry.

    >>> from cgagen.robot import load_robot
    >>> sensor_names(load_robot("servobot-predator"))
    ('front', 'right', 'left', 'light_left', 'light_right')
    """
    lights = robot.light.sensors if robot.light else ()
    return (
        *(sonar.name for sonar in robot.sonars),
        *(LIGHT_PREFIX + sensor.name for sensor in lights),
    )


class Readings:
    """Readings of one robot, decision by decision.

    Args:
        robot: whose telemetry it is.

    Attributes:
        names: of the sensors that count.
        decisions: how many.
        touched: in how many of them, by antenna.
        notes: sensors that cannot be right, in sentences.
    """

    def __init__(self, robot: Robot) -> None:
        self.names = sensor_names(robot)
        self.decisions = 0
        self.touched = dict.fromkeys(SIDES, 0)
        self.notes: list[str] = []
        self._suspects = Suspects(robot)
        self._counts: dict[str, list[int]] = {name: [] for name in self.names}

    def add(self, said: Telemetry) -> None:
        """Note one decision."""
        self.decisions += 1
        self.notes += self._suspects.add(said)
        for name, count in zip(self.names, (*said.sonars, *said.lights), strict=True):
            self._counts[name].append(count)
        for side, bent in zip(SIDES, said.touched, strict=True):
            self.touched[side] += bent

    def counts(self, name: str) -> Sequence[int]:
        """Return all counts of one sensor."""
        return self._counts[name]

    def seen(self, name: str) -> Seen:
        """Return what one sensor has counted, of at least one decision."""
        counts = self._counts[name]
        return Seen(min(counts), sum(counts) / len(counts), max(counts), len(counts))


def decisions(
    name: str, port: Port, decoder: Decoder, now_s: Callable[[], float] = time.monotonic
) -> Iterator[tuple[Line, Telemetry]]:
    """Yield the lines of telemetry of a robot at work, and what they say, without end.

    Args:
        name: what messages call the port.
        port: open.
        decoder: of this robot's lines.
        now_s: a clock.

    Raises:
        RigError: the port is gone, or there is no telemetry.
        IdentityError: a robot was named, and the banner names another one.
    """
    heard = bytearray()
    listener = Listener(name, port, [heard.extend], lambda _sentence: None, now_s)
    last_s, fault = now_s(), ""
    while now_s() - last_s < SILENCE_S:
        listener.turn(b"")
        lines = list(decoder.lines(bytes(heard)))
        heard.clear()
        for line in lines:
            if line.said is not None:
                yield line, line.said
                last_s = now_s()
            elif line.data["kind"] == "fault":
                fault = f" ({line.text})"
            elif line.data["kind"] == "banner" and decoder.named:
                refuse_other_robot(name, line.data["robot"], decoder.robot)
    raise RigError(
        f"{name}: no telemetry in {SILENCE_S:g} s{fault}; reset the main controller (--reset), "
        "reset the locomotion controller or switch it off, and look whether the robot file says "
        "telemetry = true"
    )


def refuse_other_robot(port: str, banner: str, robot: Robot) -> None:
    """Refuse a robot that was named, where the banner of the one at hand names another.

    Args:
        port: what messages call the port.
        banner: the robot's name in the banner.
        robot: that was named.

    Raises:
        IdentityError: they are not the same.
    """
    if banner != plain(robot.name):
        raise IdentityError(
            f"{port}: the banner names {banner}, and the robot that was named is {robot.name}; "
            "leave --robot out or name the file of that robot, or flash this one's build"
        )
