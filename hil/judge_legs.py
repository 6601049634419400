"""Checks of a locomotion controller: pulses, handshake, bench words, by the robot's file."""

import math
from collections.abc import Callable
from itertools import pairwise

from cgagen.bench_protocol import (
    FRAME_LIMIT_MS,
    LISTEN_MS,
    LOCOMOTION_SLICE_MS,
    Banner,
    banner_text,
    dump_request,
    parse_dump,
)
from cgagen.emulator.chip import Coverage
from cgagen.emulator.parts.signal import Signal
from cgagen.firmware.gait_tables import pulse_step
from cgagen.robot import Robot
from cgagen.robot.gait import phases_of, pulses_counts
from cgagen.stamp.image import Image
from hil.subject import Subject
from hil.trial import BYTE_NS, MS, Trial, want

IDLE_FRAMES = 250
"""Frames without GO before `*IDLE`, and with a low line before `*LOW`. Ref: PROTOCOL.md."""

GO_MS = 100
SERVOS = 12
ORDER = (1, 2, 3, 4, 5, 6, 7, 0)
"""Movements in the order in which they are commanded."""

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
        self._step_bit = 1 << (line.locomotion_pin if line else 0)
        self.rest = standing(robot)

    def _listener(self, index: int) -> Callable[[int | None], None]:
        rises, pulses = self.rises[index], self.pulses

        def changed(level: int | None) -> None:
            if level == 1:
                rises.append(self.now_ns)
                self.event(f"pulse {index}")
            elif rises:
                pulses.append((rises[-1], self.now_ns - rises[-1], index))

        return changed

    @property
    def holds(self) -> bool:
        """Whether the chip itself drives the step line low."""
        pins = self.chip.pins
        return bool(pins.directions & self._step_bit) and not pins.latch & self._step_bit

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
            frames.append(tuple(round(one[1] / self._unit_ns) for one in part))
        return frames

    def check_gaps(self, check: str) -> None:
        """No servo may wait for longer than the limit."""
        for index, rises in enumerate(self.rises):
            worst = max((b - a for a, b in pairwise([*rises, self.now_ns])), default=0)
            want(bool(rises), check, f"servo {index} has no pulse")
            want(worst <= FRAME_LIMIT_MS * MS, check, f"servo {index}: {worst / MS:.1f} ms")


def judge_legs(subject: Subject, image: Image, coverage: Coverage | None = None) -> None:
    """Try a locomotion controller.

    Raises:
        FailedCheck: by the first check that finds something.
        CgagenError: what it does is impossible on the bench.
    """
    trial = LegsTrial(subject, image, coverage)
    _start(trial)
    _gait(trial)
    _line_kept_low(trial)
    _unsteady_lines(trial)
    _taken_back(trial)
    _idle(trial)
    trial.check_gaps("gaps")
    trial = LegsTrial(subject, image, coverage)
    _bench(trial, image)
    trial.check_gaps("gaps")
    _late_hello(LegsTrial(subject, image, coverage))


def _start(trial: LegsTrial) -> None:
    """Banner, prompts, standing still with the line held low; then the line is let go."""
    robot, subject = trial.robot, trial.subject
    trial.go_on(2)
    servos = sum(1 << one.pin for one in robot.servo_set.servos)
    want(trial.chip.pins.directions & servos == servos, "gaps", "servo lines float at the start")
    want(trial.holds, "handshake", "the step line is not held low after a reset")
    want(trial.wait("pulse 0", FRAME_LIMIT_MS), "gaps", "no pulse soon after a reset")
    want(trial.wait("step 1", 1_500), "handshake", "the step line is never let go")
    digest = subject.sources["locomotion"].split("Source:  ")[1][:8]
    wanted = banner_text(Banner(1, "locomotion", robot.name, subject.genome_digest, digest)) + "\r"
    want(trial.said.rstrip(">") == wanted, "banner", f"says {trial.said!r}")
    prompts = trial.heard_ns[len(wanted) :]
    slices = [b - a for a, b in pairwise([*prompts, trial.now_ns])]
    want(len(prompts) > 1, "banner", "does not listen")
    whole = trial.now_ns - prompts[0]
    want(whole >= LISTEN_MS * MS, "banner", f"listens for {whole / MS:.0f} ms")
    want(whole < 2 * LISTEN_MS * MS, "banner", f"listens for {whole / MS:.0f} ms")
    want(min(slices) >= LOCOMOTION_SLICE_MS * MS + BYTE_NS, "banner", "slices too short")
    frames = trial.frames(0, "gait")
    want(set(frames) == {trial.rest}, "gait", "does not stand after the reset")
    trial.check_gaps("gaps")


def _gait(trial: LegsTrial) -> None:
    """All movements on the lines' command, each whole and nothing besides."""
    trial.go_on(150)
    for command in ORDER:
        began_ns = trial.now_ns
        trial.go_on(80)
        want(not trial.holds, "handshake", "holds the step line without GO")
        idle = trial.frames(began_ns, "gait")
        want(set(idle) == {trial.rest}, "gait", f"moves without GO before {command}")
        trial.command(command)
        trial.wait("pulse 6", 60)
        walk(trial, command)
    trial.check_gaps("gaps")


def walk(trial: LegsTrial, command: int) -> None:
    """Say GO in the middle of a frame; one movement has to follow."""
    frames = wanted_frames(trial.robot, command, trial.rest)
    went_ns = trial.now_ns
    trial.other.set(0)
    trial.go_on(GO_MS)
    want(trial.holds, "handshake", f"does not take GO for {command}")
    trial.other.set(None)
    trial.command(7 - command)
    want(trial.wait("step 1", len(frames) * 45), "handshake", f"never ends movement {command}")
    seen = trial.frames(went_ns, "gait")
    trial.command(command)
    want(seen[:1] == [trial.rest], "gait", f"first frame of movement {command}")
    want(len(seen) == len(frames) + 1, "gait", f"{len(seen)} frames in movement {command}")
    want(seen[1:] == frames, "gait", f"pulses of movement {command}")
    trial.rest = frames[-1]


def _line_kept_low(trial: LegsTrial) -> None:
    """Whoever keeps the line low after a movement says no second GO, and is reported."""
    trial.command(3)
    trial.go_on(100)
    trial.wait("pulse 6", 60)
    trial.other.set(0)
    frames = wanted_frames(trial.robot, 3, trial.rest)
    limit_ns = trial.now_ns + len(frames) * 45 * MS
    trial.go_on(60)
    while trial.holds and trial.now_ns < limit_ns:
        trial.go_on(5)
    want(not trial.holds, "handshake", "never ends the movement")
    trial.rest = frames[-1]
    _counted(trial, "*LOW\r")
    trial.go_on(200)
    want(not trial.holds, "handshake", "takes a low line that never rose for GO")
    trial.other.set(None)
    trial.go_on(100)
    trial.wait("pulse 6", 60)
    walk(trial, 3)


def _counted(trial: LegsTrial, fault: str) -> None:
    """A fault is reported after the frames that PROTOCOL.md says, and nothing moves."""
    began_ns = trial.now_ns
    trial.forget()
    want(trial.wait("byte 13", 9_000), "faults", f"no {fault!r}")
    want(trial.said == fault, "faults", f"says {trial.said!r} for {fault!r}")
    frames = trial.frames(began_ns, "gait")
    want(set(frames) == {trial.rest}, "gait", f"moves before {fault!r}")
    off = abs(len(frames) - IDLE_FRAMES)
    want(off <= 1, "faults", f"{fault!r} after {len(frames)} frames")


def _unsteady_lines(trial: LegsTrial) -> None:
    """Lines that never read the same twice command nothing."""
    level, start = 0, trial.now_ns

    def flip(_chip: object) -> None:
        nonlocal level
        level = 7 - level
        trial.command(level)

    trial.go_on(100)
    trial.forget()
    trial.wait("pulse 11", 60)
    remove = trial.chip.on_instruction(flip)
    trial.other.set(0)
    trial.go_on(20)
    remove()
    trial.other.set(None)
    trial.wait("byte 13", 100)
    want(trial.said == "*LINES\r", "faults", f"says {trial.said!r} for unsteady lines")
    trial.go_on(200)
    want(not trial.holds, "handshake", "keeps the line after unsteady lines")
    want(set(trial.frames(start, "gait")) == {trial.rest}, "gait", "walks on unsteady lines")
    trial.command(4)
    trial.wait("pulse 6", 60)
    walk(trial, 4)


def _taken_back(trial: LegsTrial) -> None:
    """A main controller that resets lets go of GO and of the command, at any instant.

    Then nothing is walked, or the movement that GO was for: never the 0 that the lines read.
    """
    frames = wanted_frames(trial.robot, 2, trial.rest)
    for fifths_ms in range(40):
        trial.command(2)
        trial.go_on(60)
        trial.forget()
        trial.wait("pulse 11", 60)
        start = trial.now_ns
        trial.other.set(0)
        trial.go_on(1 + fifths_ms / 5)
        trial.other.set(None)
        trial.command(0)
        trial.go_on(60)
        if trial.holds:
            break
        want(set(trial.frames(start, "gait")) <= {trial.rest}, "gait", "walks without a GO")
    want(trial.holds, "handshake", "never takes GO")
    want(trial.wait("step 1", len(frames) * 45), "handshake", "never ends the movement")
    seen = trial.frames(start, "gait")
    want(seen[-len(frames) :] == frames, "gait", "walks what the lines say after a reset")
    trial.rest = frames[-1]


def _idle(trial: LegsTrial) -> None:
    """Without GO it says so from time to time, and goes on waiting."""
    _counted(trial, "*IDLE\r")
    trial.command(5)
    trial.wait("pulse 6", 60)
    walk(trial, 5)


# -- Bench mode -------------------------------------------------------------------------------


def _bench(trial: LegsTrial, image: Image) -> None:
    _said(trial, "?Hab", "!Hab")
    want(trial.holds, "handshake", "lets the step line go in bench mode")
    for request, command in (("?M0a", 0), ("?M0a", None), ("?M0a", None), ("?M7b", 7)):
        _bench_movement(trial, request, command)
    for request in ("?M8b", "?M/x", "?Zab", "?D/0", "?D0p", "?D10", "?Qab"):
        _said(trial, request, f"!E{request[2:]}")
    _bench_movement(trial, "?M7b", None)
    _bench_dump(trial, image)
    _bench_movement(trial, "?M7b", None)
    _said(trial, "?Hcd", "!Hcd")
    _bench_movement(trial, "?M7b", 7)
    _said(trial, "?C99", "!C99")
    trial.rest = standing(trial.robot)
    trial.go_on(100)
    _bench_movement(trial, "?M7b", None)
    began_ns = trial.now_ns
    trial.go_on(100)
    want(set(trial.frames(began_ns, "gait")) == {trial.rest}, "bench", "does not centre")
    _ignored(trial)
    want(not trial.step.level, "handshake", "lets the step line go in bench mode")
    _said(trial, "?Xzz", "!Xzz")
    want(trial.step.level == 1 or trial.wait("step 1", 100), "handshake", "keeps it after leaving")
    trial.go_on(100)
    trial.command(2)
    trial.wait("pulse 6", 60)
    walk(trial, 2)


def _late_hello(trial: LegsTrial) -> None:
    """A hello is heard in every slice of the listening, the last that there has to be, too."""
    began_ns = None
    while began_ns is None or trial.now_ns - began_ns < (LISTEN_MS - 40) * MS:
        want(trial.wait("byte 62", 1_500), "bench", "no prompt")
        began_ns = began_ns or trial.now_ns
    _said(trial, "?Hzz", "!Hzz")


def _said(trial: LegsTrial, request: str, answer: str) -> None:
    said = trial.ask(request)
    want(said == f"{request}{answer}\r", "bench", f"{request} is answered {said!r}")


def _bench_movement(trial: LegsTrial, request: str, command: int | None) -> None:
    _said(trial, request, f"!{request[1:]}")
    began_ns = trial.now_ns
    want(trial.wait("byte 62", 2_500), "bench", f"no prompt behind {request}")
    seen = trial.frames(began_ns, "bench")
    if command is None:
        want(set(seen) <= {trial.rest}, "bench", f"{request} is walked twice")
        return
    frames = wanted_frames(trial.robot, command, trial.rest)
    extra = len(seen) - len(frames)
    want(1 <= extra <= 3, "bench", f"{request}: {len(seen)} frames")
    at = 1
    want(seen[:at] == [trial.rest], "bench", f"{request}: the first frame")
    trial.rest = frames[-1]
    want(seen[at:] == [*frames, *[trial.rest] * (extra - at)], "bench", f"{request}: pulses")


def _bench_dump(trial: LegsTrial, image: Image) -> None:
    for first, last in ((0, 63), (2016, 2047)):
        request = dump_request(first, last)
        said = trial.ask(request, limit_ms=3_000)
        lines = [parse_dump(line) for line in said.split("\r")]
        found = [line for line in lines if line]
        want([line[0] for line in found] == list(range(first, last, 16)), "dump", "addresses")
        data = b"".join(line[1] for line in found)
        want(data == image.eeprom[first : last + 1], "dump", "bytes")
        want(said.endswith(f"\r!{request[1:]}\r"), "dump", "no end")


def _ignored(trial: LegsTrial) -> None:
    """What is no request is not answered."""
    trial.wait("byte 62", 500)
    trial.go_on(2)
    trial.forget()
    trial.host.send(b"!C77")
    trial.go_on(150)
    want("!" not in trial.said.removeprefix("!C77"), "bench", f"answers {trial.said!r}")
