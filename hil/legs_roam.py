"""A locomotion controller on three lines: it walks all the time, what they say as a cycle ends.

Between two movements there are frames of the pose in which the last one ended: at least one, and
as many each time, in which it reads the lines and its tables.
"""

from cgagen.bench_protocol import FRAME_LIMIT_MS
from hil.legs_trial import SERVOS, Frame, LegsTrial, wanted_frames
from hil.trial import MS, want

ORDER = (2, 3, 4, 5, 6, 7, 1, 0)
"""Movements in the order in which they are commanded; the first one holds in no robot. Choice."""

MOST_BETWEEN = 3
"""Frames between two movements. Choice: one for reading the lines, one for the tables, one more."""

MIDDLE = SERVOS // 2
"""A servo in the middle of a frame."""

UNSTEADY_MS = 300
"""How long the lines change all the time. Choice: several words of it."""


def strides(trial: LegsTrial) -> None:
    """All movements, one behind the other, each whole and nothing besides.

    Args:
        trial: its first movement, 0, has just begun.
    """
    walked, between = _Walked(trial, 0), 0
    for following in ORDER:
        walked.to_last_frame(following)
        if trial.robot.steps[following].order == "hold":
            walked.holds(following, between)
            continue
        count = walked.to_next(following)
        between = between or count
        want(count == between, "gait", f"{count} frames before movement {following}")
    walked.to_last_frame(4)
    trial.go_on(2 * FRAME_LIMIT_MS)
    walked.compare()


def unsteady_on_the_way(trial: LegsTrial) -> None:
    """Lines that never read the same twice command nothing, and that is said."""
    want(trial.wait("moved", (MOST_BETWEEN + 1) * FRAME_LIMIT_MS), "gait", "never walks 4")
    walked = _Walked(trial, 4)
    walked.to_last_frame(4)
    trial.forget()
    level = 0

    def flip(_chip: object) -> None:
        nonlocal level
        level = 7 - level
        trial.command(level)

    remove = trial.chip.on_instruction(flip)
    began_ns = trial.now_ns
    trial.go_on(UNSTEADY_MS)
    remove()
    trial.command(5)
    want(trial.wait("moved", (MOST_BETWEEN + 2) * FRAME_LIMIT_MS), "gait", "never walks 5")
    words = set(trial.said.split("\r"))
    want(words == {"*LINES", ""}, "faults", f"says {trial.said!r} for unsteady lines")
    seen = trial.frames(began_ns, "gait")
    want(set(seen) == {trial.rest}, "gait", "walks on unsteady lines")
    walked = _Walked(trial, 5)
    walked.to_last_frame(0)
    trial.go_on(FRAME_LIMIT_MS)
    walked.compare()


class _Walked:
    """What is walked from now on, and what has to be.

    Args:
        trial: a movement has just begun.
        command: which.
    """

    def __init__(self, trial: LegsTrial, command: int) -> None:
        self._trial = trial
        self._first = len(trial.rises[0]) - 1
        # Servos of the legs that rise first have had more frames before those of all.
        self._ahead = trial.robot.servo_set.start_frames * (MIDDLE // 2)
        self._began_ns = trial.rises[0][-1]
        self._wanted: list[Frame] = []
        self._names: list[str] = []
        self._add(command, wanted_frames(trial.robot, command, trial.rest))

    def to_last_frame(self, following: int) -> None:
        """Go on to the middle of the movement's last frame; the lines say what follows there.

        Before, they say something else, which must not be heard.
        """
        trial = self._trial
        trial.command(7 - following)
        self._to_frame(len(self._wanted))
        trial.command(following)
        trial.rest = self._wanted[-1]

    def to_next(self, command: int) -> int:
        """Go on to the beginning of a movement; returns the frames between."""
        trial = self._trial
        limit_ms = (MOST_BETWEEN + 1) * FRAME_LIMIT_MS
        want(trial.wait("moved", limit_ms), "gait", f"never walks {command}")
        between = len(trial.rises[0]) - 1 - self._first - len(self._wanted)
        want(1 <= between <= MOST_BETWEEN, "gait", f"{between} frames before movement {command}")
        self._add(None, [trial.rest] * between)
        self._add(command, wanted_frames(trial.robot, command, trial.rest))
        return between

    def holds(self, command: int, between: int) -> None:
        """Note a movement that only holds, and go on to its first frame."""
        self._add(None, [self._trial.rest] * between)
        self._to_frame(len(self._wanted) + 1)
        self._add(command, wanted_frames(self._trial.robot, command, self._trial.rest))

    def compare(self) -> None:
        """Compare all frames with those that are wanted."""
        seen = self._trial.frames(self._began_ns, "gait")
        want(len(seen) >= len(self._wanted), "gait", f"{len(seen)} of {len(self._wanted)} frames")
        for name, one, frame in zip(self._names, self._wanted, seen, strict=False):
            want(frame == one, "gait", f"pulses {name}")

    def _to_frame(self, number: int) -> None:
        """Go on to the middle of a frame, counted from 1."""
        trial, index = self._trial, MIDDLE
        limit_ns = trial.now_ns + (number + MOST_BETWEEN) * FRAME_LIMIT_MS * MS
        wanted = self._first + self._ahead + number
        while len(trial.rises[index]) < wanted and trial.now_ns < limit_ns:
            trial.wait(f"pulse {index}", FRAME_LIMIT_MS)
        want(trial.now_ns < limit_ns, "gaps", "pulses come late")

    def _add(self, command: int | None, frames: list[Frame]) -> None:
        self._wanted += frames
        words = "between two movements" if command is None else f"of movement {command}"
        self._names += [words] * len(frames)
