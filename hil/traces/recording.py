"""Where traces come from: an episode of the simulator, readings of any kind, or a robot at work.

What is asked reading by reading has no time of its own: its readings stand one second apart, so
that the same recording gives the same bytes on every machine. A robot at work has a clock, the
computer's.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import serial
from numpy.typing import NDArray

from cgagen.bench_protocol import END, Banner, parse_banner
from cgagen.counts import NO_ECHO_COUNT, UNLIT_COUNT
from cgagen.errors import IdentityError, RigError, RobotError, UnprovenError
from cgagen.genome import Genome
from cgagen.link.port import PortLock, open_port
from cgagen.robot import Robot
from cgagen.words import Role
from hil.hunt import episode_of
from hil.pursuit_step import stimuli_of
from hil.stimuli import with_values
from hil.subject import Subject
from hil.target import IMAGE, Observation, Stimulus, Target
from hil.telemetry import Told, parse_telemetry
from hil.traces.values import Origin, Sample, Trace, check_decision, sample_of
from sim.numbers import WorldNumbers

STEP_NS = 1_000_000_000
"""Between two readings of what has no clock. Choice."""

SILENCE_S = 30.0
"""How long a robot at work may say nothing. Choice: ten times its longest movement."""

NUMBERS = 256
"""Of lines of telemetry. Ref: PROTOCOL.md."""

MOST_BYTES = 1_000
"""Of a line; what is longer is no line. Choice."""


def origin_of(subject: Subject, target: str, **more: Any) -> Origin:
    """Return the origin of decisions of a subject."""
    robot, genome = subject.robot, subject.genome
    return Origin(
        target, robot.name, robot.role, robot.digest, genome.digest if genome else None, **more
    )


def record_readings(
    subject: Subject,
    target: Target,
    stimuli: Sequence[Stimulus],
    source: dict[str, Any],
    seed: int | None = None,
) -> tuple[Trace, int]:
    """Ask an open target for its decision about each reading.

    Args:
        subject: what decides.
        target: where.
        stimuli: in this order.
        source: for the sidecar: how these readings came about.
        seed: likewise.

    Returns:
        The trace, and how many readings were left out because the target cannot be given them.

    Raises:
        RigError: the target is sick; nothing was recorded.
        UnprovenError: it can be given none of them.
    """
    admits = getattr(target, "admits", None)
    wanted = [one for one in stimuli if admits is None or admits(one)]
    if not wanted:
        raise UnprovenError(
            f"{target.url}: can be given none of the {len(stimuli)} readings; record others"
        )
    samples = tuple(
        sample_of(n * STEP_NS, stimulus, (n + 1) & 0xFFFF, target.decide(stimulus))
        for n, stimulus in enumerate(wanted)
    )
    kind = target.url.partition(":")[0]
    origin = origin_of(subject, kind, images=_images(subject, target), seed=seed, source=source)
    return Trace(target.url, samples, origin), len(stimuli) - len(wanted)


def _images(subject: Subject, target: Target) -> dict[str, str]:
    """Return the digests of what decided; a serial target has compared its chip's on opening."""
    if IMAGE not in target.caps:
        return {}
    if target.url.startswith("serial:"):
        return {"main": subject.images["main"].digest}
    return target.identity().images


def episode_readings(
    genome: Genome, numbers: WorldNumbers, start: NDArray[np.float64], steps: int, role: Role
) -> list[Stimulus]:
    """Return what a robot senses in an episode of the simulator, up to the capture.

    Args:
        genome: the predator's.
        numbers: of the world.
        start: shape (1, 8).
        steps: at most.
        role: whose readings.
    """
    looks = episode_of(genome, numbers, start, steps).looks
    side = 0 if role is Role.PREDATOR else 1
    return [stimuli_of(row)[side] for row in looks.tolist()]


def episode_source(
    role: Role,
    poses: dict[str, tuple[float, float, float]],
    steps: int,
    genome: Genome,
    options: dict[str, Any],
) -> dict[str, Any]:
    """Return how the readings of an episode came about, for the sidecar.

    Args:
        role: whose readings.
        poses: x_units, y_units, heading_deg by robot.
        steps: at most.
        genome: the predator's.
        options: open points of the world that were given.
    """
    told = {name: list(pose) for name, pose in poses.items()}
    row = {"of": str(role), **told, "steps": steps, "genome": genome.digest}
    return {"episode": row | ({"options": options} if options else {})}


def without_decisions(trace: Trace) -> Trace:
    """Return the readings of a trace alone."""
    samples = (Sample(one.time_ns, one.stimulus, one.seq, where=one.where) for one in trace.samples)
    origin = trace.origin and replace(trace.origin, genome=None)
    return Trace(trace.name, tuple(samples), origin)


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
    """

    def __init__(self, subject: Subject, port: str, now_ns: Callable[[], int]) -> None:
        self.samples: list[Sample] = []
        self.lost = self.spoiled = 0
        self._subject = subject
        self._port = port
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
            elif ":" in line:
                self._tell(parse_telemetry(line, self._subject.role))

    def _check(self, banner: Banner) -> None:
        robot, genome = self._subject.robot.name, self._subject.genome_digest
        if (banner.robot, banner.genome) != (robot, genome):
            raise IdentityError(
                f"{self._port}: {banner.robot} with genome {banner.genome} is at work there, not "
                f"{robot} with {genome}; name its genome and robot"
            )
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
        The trace, and what was lost.

    Raises:
        RigError: no such port, nothing came, or it came to an end.
        RobotError: this robot tells nothing.
    """
    robot = subject.robot
    if not robot.telemetry:
        raise RobotError(
            f"{robot.name}: telemetry: is false, so its firmware tells nothing while it is at "
            "work; set it, build and load, or record through its bench hook with --target"
        )
    listener = Listener(subject, port, now_ns)
    lock = PortLock(port)
    lock.take()
    try:
        wire = open_port(port)
        try:
            _listen(listener, wire, port, readings, limit_s)
        except KeyboardInterrupt:
            if not listener.samples:
                raise
        finally:
            wire.close()
    finally:
        lock.release()
    if not listener.samples:
        raise RigError(
            f"{port}: no telemetry in {min(limit_s, SILENCE_S):g} s; switch the robot on, end its "
            "bench mode with a reset, and look at the cable"
        )
    source = {
        "telemetry": {"lost": listener.lost, "spoiled": listener.spoiled},
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
            listener.take(wire.read(max(1, wire.in_waiting)))
        except (OSError, serial.SerialException) as error:
            raise RigError(f"{port}: lost ({error}); look at the cable") from error
        if len(listener.samples) > known:
            heard_s = now_s


def sweep(robot: Robot) -> list[Stimulus]:
    """Return readings in which one sensor after the other goes from near to far, the rest calm."""
    lights = (UNLIT_COUNT, UNLIT_COUNT) if robot.light else ()
    plain = Stimulus((NO_ECHO_COUNT,) * len(robot.sonars), (False, False), lights)
    found = [plain]
    for index, sonar in enumerate(robot.sonars):
        fewest, most = robot.echo_limits_counts(sonar)
        for count in _rising(int(fewest), int(most)):
            found.append(with_values(plain, {index: count}))
    for touched in ((True, False), (True, True), (False, True)):
        found.append(replace(plain, touched=touched))
    if robot.light:
        near, far = robot.light.curve[0][1], robot.light.curve[-1][1]
        for count in _rising(near, far):
            pairs = ((count, UNLIT_COUNT), (UNLIT_COUNT, count), (count, count))
            found += [replace(plain, lights=pair) for pair in pairs]
    return found


def _rising(low: int, high: int) -> list[int]:
    """Return whole numbers from low to high, each twice the one before.

    >>> _rising(10, 50)
    [10, 20, 40, 50]
    """
    found = [low]
    while found[-1] * 2 < high:
        found.append(found[-1] * 2)
    return [*found, high]
