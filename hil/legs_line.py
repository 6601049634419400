"""A locomotion controller and its lines: GO, movements, and what is no GO."""

from cgagen.bench_protocol import FRAME_LIMIT_MS, GO_MS
from hil.legs_trial import LegsTrial, wanted_frames
from hil.trial import MS, want

IDLE_FRAMES = 250
"""Frames without GO before `*IDLE`, and with a low line before `*LOW`. Ref: PROTOCOL.md."""

ORDER = (1, 2, 3, 4, 5, 6, 7, 0)
"""Movements in the order in which they are commanded."""


def gait(trial: LegsTrial) -> None:
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
    say_go(trial, command)
    trial.command(7 - command)
    want(
        trial.wait("step 1", len(frames) * FRAME_LIMIT_MS),
        "handshake",
        f"never ends movement {command}",
    )
    seen = trial.frames(went_ns, "gait")
    trial.command(command)
    want(seen[:1] == [trial.rest], "gait", f"first frame of movement {command}")
    want(len(seen) == len(frames) + 1, "gait", f"{len(seen)} frames in movement {command}")
    want(seen[1:] == frames, "gait", f"pulses of movement {command}")
    trial.rest = frames[-1]


def say_go(trial: LegsTrial, command: int) -> None:
    """Say GO for a command, which has to be taken."""
    trial.command(command)
    trial.other.set(0)
    trial.go_on(GO_MS)
    want(trial.holds, "handshake", f"does not take GO for {command}")
    trial.other.set(None)


def line_kept_low(trial: LegsTrial) -> None:
    """Whoever keeps the line low after a movement says no second GO, and is reported."""
    trial.command(3)
    trial.go_on(100)
    trial.wait("pulse 6", 60)
    trial.other.set(0)
    frames = wanted_frames(trial.robot, 3, trial.rest)
    limit_ns = trial.now_ns + len(frames) * FRAME_LIMIT_MS * MS
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
    want(trial.wait("byte 13", IDLE_FRAMES * FRAME_LIMIT_MS), "faults", f"no {fault!r}")
    want(trial.said == fault, "faults", f"says {trial.said!r} for {fault!r}")
    frames = trial.frames(began_ns, "gait")
    want(set(frames) == {trial.rest}, "gait", f"moves before {fault!r}")
    off = abs(len(frames) - IDLE_FRAMES)
    want(off <= 1, "faults", f"{fault!r} after {len(frames)} frames")


def unsteady_lines(trial: LegsTrial) -> None:
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
    trial.wait("byte 13", 100)
    want(trial.said == "*LINES\r", "faults", f"says {trial.said!r} for unsteady lines")
    trial.go_on(200)
    want(not trial.holds, "handshake", "takes a GO that it has refused")
    trial.other.set(None)
    trial.go_on(200)
    want(set(trial.frames(start, "gait")) == {trial.rest}, "gait", "walks on unsteady lines")
    trial.command(4)
    trial.wait("pulse 6", 60)
    walk(trial, 4)


def taken_back(trial: LegsTrial) -> None:
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
    want(trial.wait("step 1", len(frames) * FRAME_LIMIT_MS), "handshake", "never ends the movement")
    seen = trial.frames(start, "gait")
    want(seen[-len(frames) :] == frames, "gait", "walks what the lines say after a reset")
    trial.rest = frames[-1]


def idle(trial: LegsTrial) -> None:
    """Without GO it says so from time to time, and goes on waiting."""
    _counted(trial, "*IDLE\r")
    trial.command(5)
    trial.wait("pulse 6", 60)
    walk(trial, 5)
