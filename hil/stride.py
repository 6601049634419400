"""Movements of a robot without a step line, which walks all the time: one behind the other.

Nothing says when a movement begins or ends. The locomotion controller sends a frame while it
reads the command lines and one while it reads its tables; then comes the movement, frame by
frame, and at its end the next two. Whatever it says on its port, it says before these two.
"""

from collections.abc import Callable

from cgagen.emulator.bench import Bench
from hil.gait_reader import GaitReader, Reading

LEADING_FRAMES = 2
"""Of the pose before, between two movements."""


class Stride:
    """Reads a robot's servos and says what it has made, as soon as it has.

    Args:
        gait: its servos.
        bench: with the robot.
        chip: name of its locomotion controller.
        made: told each movement at the end of its last frame; without a command, frames that
            are no movement's.
    """

    def __init__(
        self, gait: GaitReader, bench: Bench, chip: str, made: Callable[[Reading], None]
    ) -> None:
        self._gait = gait
        self._made = made
        gait.framed = self._framed
        bench.host(chip).heard = lambda _byte: self._spoke()

    def _spoke(self) -> None:
        """It stands and says something: what it has sent was no part of a movement."""
        train = self._gait.take()
        trouble = self._gait.rested(train)
        if trouble:
            self._made(Reading(None, max(train.counts()), trouble))

    def _framed(self) -> None:
        frames = self._gait.frames_so_far()
        alive = self._gait.beginnings(frames, LEADING_FRAMES)
        if not alive:
            self._made(self._gait.read(self._gait.take()))
        elif len(alive) == 1 and alive[0].frames == len(frames):
            self._gait.rest = frames[-1]
            self._gait.take()
            self._made(alive[0])
