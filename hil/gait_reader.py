"""Which movement a robot makes, read from the pulses of its twelve servos and from nothing else.

A frame is one pulse for each servo, in whatever order. A movement is a list of frames; what they
have to be is reckoned from the robot's gait in degrees, not from the firmware's tables.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from cgagen.bench_protocol import FRAME_LIMIT_MS
from cgagen.emulator.bench import Bench
from cgagen.robot import Robot
from cgagen.robot.gait import phases_of, pulses_counts

FOREVER_NS = 1 << 62
LONGEST_FRAME_NS = FRAME_LIMIT_MS * 1_000_000

Frame = tuple[int, ...]
"""Widths in ns, in the order of the robot's servos."""

LEADING_FRAMES = 1
"""The frame of the pose before, while the tables of the next one are read."""

DEAD_BAND_NS = 8_000
"""A servo does not move for less. Ref: S10. Pulses are wanted within half of it."""


class Pulse(NamedTuple):
    """One pulse on a servo's wire."""

    start_ns: int
    width_ns: int


class Reading(NamedTuple):
    """What was read out of some frames.

    Attributes:
        command: the movement; None for none that is in the robot's table.
        frames: how many frames there were.
        reason: why there is no command; empty where there is one.
    """

    command: int | None
    frames: int
    reason: str = ""


class GaitReader:
    """Listens to the servos of a robot, which begins with its legs down and straight out.

    Args:
        robot: whose gait it is.
        bench: with the servos.
        word: before the names of the robot's parts.

    Attributes:
        servos: their names, in the robot's order.
        rest: the pose that the last movement ended in.
        framed: called whenever all servos have had equally many pulses; None for nobody.
    """

    def __init__(self, robot: Robot, bench: Bench, word: str = "") -> None:
        self.servos = [f"{one.leg}_{one.joint}" for one in robot.servo_set.servos]
        self._unit_ns = robot.locomotion.pulsout_unit_ns
        self._robot = robot
        self._clock = bench.clock
        self._rose_ns: list[int | None] = [None] * len(self.servos)
        self._trains: list[list[Pulse]] = [[] for _ in self.servos]
        self.rest = self._standing()
        self.framed: Callable[[], None] | None = None
        self._gait = [self._frames_of(command) for command in range(len(robot.steps))]
        for index, servo in enumerate(self.servos):
            bench.end(f"{word}servo_{servo}.signal").listen(
                lambda level, index=index: self._changed(index, level)  # type: ignore[misc]
            )

    def take(self) -> "Train":
        """Return what the servos were sent since the last call."""
        train = Train(tuple(tuple(pulses) for pulses in self._trains))
        for pulses in self._trains:
            pulses.clear()
        return train

    def rested(self, train: "Train") -> str:
        """Look at a train that should hold the pose; say what is wrong, or nothing."""
        for frame in train.whole_frames():
            if not _near(frame, self.rest):
                return f"moves without being told: {self._where(frame, self.rest)}"
        return ""

    def read(self, train: "Train") -> Reading:
        """Say which movement a train is; what follows then rests in its last pose."""
        frames = train.frames()
        if frames is None:
            counts = train.counts()
            odd = [f"{self.servos[n]} {one}" for n, one in enumerate(counts) if one != max(counts)]
            words = ", ".join(odd) or "pulses out of turn"
            return Reading(None, max(counts), f"of {max(counts)} frames: {words}")
        found = [n for n in range(len(self._gait)) if self._is(n, frames)]
        if len(found) == 1:
            self.rest = frames[-1]
            return Reading(found[0], len(frames))
        return Reading(None, len(frames), self._nearest(frames))

    def find(self, train: "Train") -> Reading:
        """Say which movement is in a train that stands before it and behind it, however long.

        A movement that holds its pose cannot be told from standing so long. What follows rests in
        the last pose.
        """
        frames = train.frames()
        if frames is None:
            return self.read(train)
        found = [n for n in range(len(self._gait)) if self._holds(n, frames)]
        moved = [n for n in found if self._gait[n]] or found
        if len(moved) == 1:
            self.rest = frames[-1]
            return Reading(moved[0], len(frames))
        return Reading(None, len(frames), self._nearest(frames))

    def widths_counts(self, train: "Train") -> list[tuple[float, ...]]:
        """Return whole frames in PULSOUT counts."""
        return [tuple(one / self._unit_ns for one in frame) for frame in train.whole_frames()]

    def wanted(self, command: int, leading: int = LEADING_FRAMES) -> list[Frame]:
        """Return the frames of a movement that begins from the present pose."""
        frames = self._gait[command] or [self.rest] * self._robot.steps[command].frames
        return [self.rest] * leading + frames

    def frames_so_far(self) -> list[Frame]:
        """Return the frames since the last `take`, which leaves them here."""
        rows = zip(*self._trains, strict=True)
        return [tuple(one.width_ns for one in row) for row in rows]

    def beginnings(self, frames: Sequence[Frame], leading: int) -> list[Reading]:
        """Return the movements that begin with these frames, each with all frames that it has."""
        found = []
        for command in range(len(self._gait)):
            wanted = self.wanted(command, leading)
            if len(frames) <= len(wanted) and all(map(_near, frames, wanted)):
                found.append(Reading(command, len(wanted)))
        return found

    def _is(self, command: int, frames: Sequence[Frame]) -> bool:
        wanted = self.wanted(command)
        return len(wanted) == len(frames) and all(map(_near, frames, wanted))

    def _holds(self, command: int, frames: Sequence[Frame]) -> bool:
        wanted = self.wanted(command)
        return any(
            all(_near(one, self.rest) for one in frames[:at])
            and all(map(_near, frames[at:], wanted))
            and all(_near(one, wanted[-1]) for one in frames[at + len(wanted) :])
            for at in range(len(frames) - len(wanted) + 1)
        )

    def _nearest(self, frames: Sequence[Frame]) -> str:
        """Say where the movement that fits longest is left."""
        best, depth = "", -1
        for command in range(len(self._gait)):
            wanted = self.wanted(command)
            fits = [_near(one, other) for one, other in zip(frames, wanted, strict=False)]
            at = fits.index(False) if False in fits else len(fits)
            if at > depth:
                depth, name = at, self._robot.steps[command].movement
                best = f"{len(frames)} frames, {name} has {len(wanted)}"
                if at < len(fits):
                    best = f"not {name} from frame {at + 1} on: " + self._where(
                        frames[at], wanted[at]
                    )
        return best

    def _where(self, frame: Frame, wanted: Frame) -> str:
        pairs = zip(self.servos, frame, wanted, strict=True)
        return ", ".join(
            f"{name} {one / 1_000:g} us for {other / 1_000:g}"
            for name, one, other in pairs
            if not _near((one,), (other,))
        )

    def _changed(self, index: int, level: int | None) -> None:
        if level == 1:
            self._rose_ns[index] = self._clock.now_ns
            return
        began_ns, self._rose_ns[index] = self._rose_ns[index], None
        if began_ns is None:
            return
        self._trains[index].append(Pulse(began_ns, self._clock.now_ns - began_ns))
        if self.framed is not None and len({len(train) for train in self._trains}) == 1:
            self.framed()

    def _frames_of(self, command: int) -> list[Frame]:
        """Return the frames of a movement; none for one that holds its pose."""
        robot, step = self._robot, self._robot.steps[command]
        if step.order == "hold":
            return []
        frames: list[Frame] = []
        for pose, count in phases_of(robot, step):
            frames += [self._frame(pulses_counts(robot, step, robot.gait.poses[pose]))] * count
        return frames

    def _standing(self) -> Frame:
        servo_set = self._robot.servo_set
        trims = [servo.trim_counts for servo in servo_set.servos]
        return self._frame([servo_set.centre_counts + trim for trim in trims])

    def _frame(self, counts: Sequence[float]) -> Frame:
        return tuple(round(one * self._unit_ns) for one in counts)


@dataclass(frozen=True, slots=True)
class Train:
    """The pulses of twelve servos over some time."""

    pulses: tuple[tuple[Pulse, ...], ...]

    def counts(self) -> list[int]:
        """Return how many pulses each servo had."""
        return [len(one) for one in self.pulses]

    def cut(self, times_ns: Sequence[int]) -> list["Train"]:
        """Return what lies between these times, and behind the last.

        A frame belongs where the first of its pulses begins. One that a reset has broken off leaves
        some servos with a pulse more than others; the last one is left out where it is not whole.
        """
        pulsed = sorted((one for one in self.pulses if one), key=lambda one: one[0].start_ns)
        all_ns = pulsed[-1][0].start_ns if pulsed else 0
        whole_ns = all_ns - LONGEST_FRAME_NS  # legs that rise have fewer pulses in a frame
        first = next((one for one in pulsed if one[0].start_ns > whole_ns), ())
        begins = [
            next((pulse.start_ns for pulse in first if pulse.start_ns >= time_ns), FOREVER_NS)
            for time_ns in times_ns
        ]
        trains = [
            Train(
                tuple(
                    tuple(pulse for pulse in one if begin_ns <= pulse.start_ns < end_ns)
                    for one in self.pulses
                )
            )
            for begin_ns, end_ns in zip(begins, [*begins[1:], FOREVER_NS], strict=True)
        ]
        last = trains[-1]
        whole = min(last.counts())
        return [*trains[:-1], Train(tuple(one[:whole] for one in last.pulses))]

    def frames(self) -> list[Frame] | None:
        """Return the frames; None where a servo lacks a pulse or has one too many."""
        if len(set(self.counts())) != 1:
            return None
        rows = list(zip(*self.pulses, strict=True))
        ends = [max(one.start_ns for one in row) for row in rows]
        starts = [min(one.start_ns for one in row) for row in rows]
        if any(end > start for end, start in zip(ends, starts[1:], strict=False)):
            return None
        return [tuple(one.width_ns for one in row) for row in rows]

    def whole_frames(self) -> list[Frame]:
        """Return as many frames as every servo has pulses for, the last ones."""
        count = min(self.counts())
        rows = zip(*(one[len(one) - count :] for one in self.pulses), strict=True)
        return [tuple(one.width_ns for one in row) for row in rows]


def _near(frame: Frame, wanted: Frame) -> bool:
    return all(
        abs(one - other) <= DEAD_BAND_NS // 2 for one, other in zip(frame, wanted, strict=True)
    )
