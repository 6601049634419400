"""Sensors that cannot be right, from one decision after another: told, and never decided about."""

from collections.abc import Iterator

from cgagen.counts import NO_ECHO_COUNT, UNLIT_COUNT
from cgagen.robot import Robot
from cgagen.telemetry import Telemetry

SILENT_AFTER = 3
"""Decisions in a row without an echo pulse at all, which is what a sonar gives that sees nothing,
too, only longer. Choice."""

STUCK_AFTER = 12
"""Decisions in a row with the very same count, while others' change: sound that really goes and
comes back differs by some counts each time. Choice; a hunt in the simulator has 4 at most."""

LIT_AFTER = 12
"""Decisions in a row with both light sensors lit: a robot that turns looks away. Choice."""


class Suspects:
    """Counts what looks wrong, and says each of it once until it has been otherwise.

    Args:
        robot: whose telemetry it is.

    >>> from cgagen.robot import load_robot
    >>> suspects = Suspects(load_robot("servobot-predator"))
    >>> said = Telemetry(0, (2000, 0, 3000), (False, False), (0, 0), 0, 4)
    >>> [note for _ in range(4) for note in suspects.add(said)]
    ['sonar right has given no echo pulse 3 times: it is dead, or its wires are; it counts as free']
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._longest = [int(robot.echo_limits_counts(sonar)[1]) for sonar in robot.sonars]
        self._last: tuple[int, ...] = ()
        self._silent = [0] * len(robot.sonars)
        self._same = [0] * len(robot.sonars)
        self._moved = [False] * len(robot.sonars)
        self._lit = 0

    def add(self, said: Telemetry) -> Iterator[str]:
        """Note a decision; yields what has become clear with it."""
        before, self._last = self._last, said.sonars
        for index, (sonar, count) in enumerate(zip(self._robot.sonars, said.sonars, strict=True)):
            name = sonar.name.replace("_", " ")
            self._silent[index] = self._silent[index] + 1 if count == NO_ECHO_COUNT else 0
            if self._silent[index] == SILENT_AFTER:
                yield (
                    f"sonar {name} has given no echo pulse {SILENT_AFTER} times: it is dead, or "
                    "its wires are; it counts as free"
                )
            if not before or count != before[index] or not 0 < count < self._longest[index]:
                self._same[index], self._moved[index] = 1, False
                continue
            self._same[index] += 1
            self._moved[index] |= said.sonars != before
            if self._same[index] >= STUCK_AFTER and self._moved[index]:
                yield (
                    f"sonar {name} has counted {count} {self._same[index]} times while others "
                    "changed: it is stuck, and taken for an obstacle"
                )
                self._same[index] -= 1 << 30
        yield from self._lights(said)

    def _lights(self, said: Telemetry) -> Iterator[str]:
        if self._robot.light is None or self._robot.limits is None:
            return
        counts = self._robot.situation_counts
        ranges = (counts.lamp_left.range, counts.lamp_right.range)
        lit = all(UNLIT_COUNT < n < most for n, most in zip(said.lights, ranges, strict=True))
        self._lit = self._lit + 1 if lit else 0
        if self._lit == LIT_AFTER:
            masked = ", and all sonars are masked" if self._robot.limits.masking else ""
            yield (
                f"both light sensors have been lit {LIT_AFTER} times in a row{masked}: unless the "
                "lamp is ahead the room is too bright for their limits"
            )
