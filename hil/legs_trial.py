"""A locomotion controller on trial: ears on its servos, hands on its lines."""

import math
from collections.abc import Callable
from itertools import pairwise

from cgagen.bench_protocol import FRAME_LIMIT_MS
from cgagen.emulator.chip import Coverage
from cgagen.emulator.parts.signal import Signal
from cgagen.firmware.gait_tables import pulse_step
from cgagen.robot import Robot
from cgagen.robot.gait import phases_of, pulses_counts
from cgagen.stamp.image import Image
from hil.subject import Subject
from hil.trial import MS, Trial, want

SERVOS = 12

LISTENS_MS = 60
"""Longer than from one prompt to the next."""

STARTS_MS = 4_000
"""A locomotion controller has started by then. Choice: half as long again as it takes."""

Frame = tuple[int, ...]
"""Twelve widths in PULSOUT counts."""


def wanted_frames(robot: Robot, command: int, rest: Frame) -> list[Frame]:
    """Return the frames of a movement, each pulse to the nearest that its byte can say."""
    step = robot.steps[command]
    if step.order == "hold":
        return [rest] * step.frames
    frames: list[Frame] = []
    for phase in phases_of(robot, step):
        counts = pulses_counts(robot, step, robot.gait.poses[phase.pose])
        frames += [_nearest(robot, counts)] * phase.frames
    return frames


def standing(robot: Robot) -> Frame:
    """Return the frame of legs down and straight out."""
    servos = robot.servo_set
    return _nearest(robot, tuple(servos.centre_counts + one.trim_counts for one in servos.servos))


def _nearest(robot: Robot, counts: tuple[float, ...]) -> Frame:
    step = pulse_step(robot)
    return tuple(math.floor(count / step + 0.5) * step for count in counts)


class LegsTrial(Trial):
    """A locomotion controller with ears on its servos and hands on its lines."""

    def __init__(self, subject: Subject, image: Image, coverage: Coverage | None = None) -> None:
        super().__init__(subject, "locomotion", image, coverage)
        bench, robot = self.bench, subject.robot
        self.lines = [
            bench.add_part(Signal(f"line_{bit}", bench.clock, bench.wire(f"command_{bit}"), 0))
            for bit in range(3)
        ]
        self.pulses: list[tuple[int, int, int]] = []
        self.rises: list[list[int]] = [[] for _ in range(SERVOS)]
        for index, servo in enumerate(robot.servo_set.servos):
            bench.end(f"locomotion.P{servo.pin}").listen(self._listener(index))
        self._unit_ns = robot.locomotion.pulsout_unit_ns
        line = robot.link.step_line
        self._step_bit = 1 << line.locomotion_pin if line else 0
        self.rest = standing(robot)

    def _listener(self, index: int) -> Callable[[int | None], None]:
        rises, pulses = self.rises[index], self.pulses

        def changed(level: int | None) -> None:
            if level == 1:
                rises.append(self.now_ns)
                self.event(f"pulse {index}")
            elif rises:
                width_ns = self.now_ns - rises[-1]
                pulses.append((rises[-1], width_ns, index))
                if round(width_ns / self._unit_ns) != self.rest[index]:
                    self.event("moved")

        return changed

    @property
    def holds(self) -> bool:
        """Whether the chip itself drives the step line low."""
        pins = self.chip.pins
        return bool(pins.directions & self._step_bit) and not pins.latch & self._step_bit

    def reset(self) -> None:
        """Reset the chip and forget what was before, the pulse that it has cut short too."""
        super().reset()
        self.pulses.clear()
        for rises in self.rises:
            rises.clear()

    def command(self, number: int) -> None:
        """Put a command on the lines."""
        for bit, line in enumerate(self.lines):
            line.set(number >> bit & 1)

    def frames(self, since_ns: int, check: str) -> list[Frame]:
        """Return the frames that began after a time; each is twelve pulses in order."""
        row = [pulse for pulse in sorted(self.pulses) if pulse[0] >= since_ns]
        while row and row[0][2] != 0:
            row.pop(0)
        frames = []
        for at in range(0, len(row) - SERVOS + 1, SERVOS):
            part = row[at : at + SERVOS]
            want([one[2] for one in part] == list(range(SERVOS)), check, "pulses out of turn")
            frames.append(tuple(self.counts(one[1]) for one in part))
        return frames

    def listens(self) -> None:
        """Go on to the end of its listening; it never holds the line, as if it accepted."""
        want(self.wait("byte 62", STARTS_MS), "banner", "no prompt after a reset")
        until_ns = self.now_ns + STARTS_MS * MS
        while self.wait("byte 62", LISTENS_MS):
            want(self.now_ns < until_ns, "banner", "listens for ever")
            want(not self.holds, "handshake", "holds the step line before it was told anything")

    def counts(self, width_ns: int) -> int:
        """Return a pulse's width in PULSOUT counts."""
        return round(width_ns / self._unit_ns)

    def check_gaps(self, check: str) -> None:
        """No servo may wait for longer than the limit."""
        for index, rises in enumerate(self.rises):
            worst = max((b - a for a, b in pairwise([*rises, self.now_ns])), default=0)
            want(bool(rises), check, f"servo {index} has no pulse")
            want(worst <= FRAME_LIMIT_MS * MS, check, f"servo {index}: {worst / MS:.1f} ms")
