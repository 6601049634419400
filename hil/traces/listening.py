"""A robot at work, listened to: its telemetry as a trace, with the times of the computer."""

import time
from collections.abc import Callable

import serial

from cgagen.bench_protocol import END, FAULT, TELEMETRY, Banner, Fault, parse_banner
from cgagen.errors import IdentityError, RigError, RobotError
from cgagen.link.port import locked_port
from cgagen.link.why import LOST
from cgagen.monitor.decode import FAULTS
from hil.subject import Subject
from hil.target import Observation
from hil.telemetry import Told, parse_telemetry
from hil.traces.recording import origin_of
from hil.traces.values import Sample, Trace, check_decision, sample_of

SILENCE_S = 30.0
"""How long a robot at work may say nothing. Choice: ten times its longest movement."""

NUMBERS = 256
"""Of lines of telemetry. Ref: PROTOCOL.md."""

MOST_BYTES = 1_000
"""Of a line; what is longer is no line. Choice."""


class Listener:
    """Puts a robot's telemetry together to a trace.

    Args:
        subject: who is to be at work.
        port: for messages.
        now_ns: of the computer.

    Attributes:
        samples: what was heard.
        lost: lines that are missing by their numbers.
        spoiled: lines of telemetry that cannot be read.
        greeted: whether a banner of the right programs was heard; without one they are known by
            the user's word alone.
        fault: what it complained of last; None for nothing.
        gone: why the port came to an early end; "" where it did not.
        port: for messages.
    """

    def __init__(self, subject: Subject, port: str, now_ns: Callable[[], int]) -> None:
        self.samples: list[Sample] = []
        self.lost = self.spoiled = 0
        self.greeted = False
        self.fault: Fault | None = None
        self.gone = ""
        self.port = port
        self._subject = subject
        self._now_ns = now_ns
        self._first_ns: int | None = None
        self._last: int | None = None
        self._line = ""

    def take(self, data: bytes) -> None:
        """Take what came.

        Raises:
            IdentityError: a banner of other programs.
        """
        for letter in data.decode("latin-1"):
            if letter != END:
                self._line = (self._line + letter)[-MOST_BYTES:]
                continue
            line, self._line = self._line, ""
            banner = parse_banner(line)
            if banner is not None:
                self._check(banner)
            elif TELEMETRY in line:
                self._tell(parse_telemetry(line, self._subject.role))
            else:
                word = line.rpartition(FAULT)[2]
                self.fault = Fault(word) if word in Fault.__members__ else self.fault

    def why_nothing(self, limit_s: float) -> str:
        """Return why no sample was heard in so many seconds, as far as that can be told."""
        if self.gone:
            return self.gone
        if self.spoiled:
            return (
                f"{self.port}: {self.spoiled} lines of telemetry came and none is a "
                f"{self._subject.robot.name}'s; name the genome or the robot that is at work there"
            )
        fault = f" (fault {self.fault}: {FAULTS[self.fault]})" if self.fault else ""
        return (
            f"{self.port}: no telemetry in {limit_s:g} s{fault}; switch the robot on, reset both "
            "its controllers, which ends their bench mode, and look at the cable"
        )

    def _check(self, banner: Banner) -> None:
        robot, genome = self._subject.plain_name, self._subject.genome_digest
        if (banner.robot, banner.genome) != (robot, genome):
            raise IdentityError(
                f"{self.port}: {banner.robot} with genome {banner.genome} is at work there, not "
                f"{robot} with {genome}; name its genome and robot"
            )
        self.greeted = True
        self._last = None  # after a reset the lines count from 0 again

    def _tell(self, told: Told | None) -> None:
        if told is None or check_decision(self._subject.role, told.state, told.command):
            self.spoiled += 1
            return
        if self._last is not None:
            self.lost += (told.number - self._last - 1) % NUMBERS
        self._last = told.number
        now_ns = self._now_ns()
        self._first_ns = now_ns if self._first_ns is None else self._first_ns
        seen = Observation(0, told.command, told.state)
        seq = (len(self.samples) + 1) & 0xFFFF
        self.samples.append(sample_of(now_ns - self._first_ns, told.stimulus, seq, seen))


def record_telemetry(
    subject: Subject,
    port: str,
    readings: int,
    limit_s: float,
    now_ns: Callable[[], int] = time.monotonic_ns,
) -> tuple[Trace, Listener]:
    """Listen to a robot at work; nothing is sent, and nothing is reset. Ctrl-C ends it, too.

    Args:
        subject: who is to be at work.
        port: device path, or a URL of pyserial's.
        readings: how many are wanted.
        limit_s: how long to listen at most.
        now_ns: the computer's clock.

    Returns:
        The trace, and what was lost; all of it where the port came to an end.

    Raises:
        RigError: no such port, or nothing came.
        RobotError: this robot tells nothing.
    """
    robot = subject.robot
    if not robot.telemetry:
        raise RobotError(
            f"{robot.name}: telemetry: is false, so its firmware tells nothing while it is at "
            "work; set it, build and load, or record through its bench hook with --target"
        )
    listener = Listener(subject, port, now_ns)
    with locked_port(port) as wire:
        try:
            _listen(listener, wire, port, readings, limit_s)
        except KeyboardInterrupt:
            if not listener.samples:
                raise
    if not listener.samples:
        raise RigError(listener.why_nothing(min(limit_s, SILENCE_S)))
    source = {
        "telemetry": {
            "lost": listener.lost,
            "spoiled": listener.spoiled,
            "banner": listener.greeted,
        },
    }
    origin = origin_of(subject, "serial", clock="host", source=source)
    return Trace(port, tuple(listener.samples), origin), listener


def _listen(
    listener: Listener, wire: serial.SerialBase, port: str, readings: int, limit_s: float
) -> None:
    began_s = heard_s = time.monotonic()
    while len(listener.samples) < readings:
        now_s = time.monotonic()
        if now_s - began_s > limit_s or now_s - heard_s > SILENCE_S:
            return
        known = len(listener.samples)
        try:
            data = wire.read(max(1, wire.in_waiting))
        except LOST as error:
            listener.gone = f"{port}: lost ({error}); look at the cable"
            return
        listener.take(data)
        if len(listener.samples) > known:
            heard_s = now_s
