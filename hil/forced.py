"""A robot's sensors on a bench, which answer with what they are told and not with what is there."""

from collections.abc import Sequence

from cgagen.emulator.bench import Bench
from cgagen.emulator.parts.air import Air
from cgagen.emulator.parts.photocell import Photocell
from cgagen.emulator.parts.sonar import Answer, Sonar, middle_ns
from cgagen.emulator.parts.whisker import Whisker
from cgagen.robot import Robot
from hil.target import Stimulus

LATE_NS = tuple(range(1_000_000, 20_500_000, 500_000))
"""When a burst comes back to those that listen, behind its first echo: in a room with walls at all
distances up to 11 ft. Choice; beyond, a sonar hears nothing (S6)."""


class Forced:
    """Makes a sonar answer with just the count that is wanted, or not at all.

    Attributes:
        width_ns: of the echo; None for no echo.
    """

    def __init__(self) -> None:
        self.width_ns: int | None = None

    def spoil(self, answer: Answer) -> Answer | None:
        """Return the wanted answer."""
        return None if self.width_ns is None else answer._replace(width_ns=self.width_ns)


class ForcedSensors:
    """All that a robot senses: its echoes, contacts and RC times.

    Args:
        robot: whose.
        bench: that it is on.
        word: before the names of its parts there, such as "prey_".
    """

    def __init__(self, robot: Robot, bench: Bench, word: str = "") -> None:
        self._main = robot.main
        self._echoes = [Forced() for _ in robot.sonars]
        sonars = bench.parts_of(Sonar)
        for sonar, forced in zip(robot.sonars, self._echoes, strict=True):
            sonars[f"{word}sonar_{sonar.name}"].spoilers.insert(0, forced)
        lights = robot.light.sensors if robot.light else ()
        bench.part(f"{word}air", Air).see_echoes(*LATE_NS)
        self._whiskers = [
            bench.part(f"{word}antenna_{one.name}", Whisker) for one in robot.antennas
        ]
        self._cells = [bench.part(f"{word}light_{one.name}", Photocell) for one in lights]

    def show(self, stimulus: Stimulus) -> None:
        """Put this before them, each in the middle of its count; 0 is no echo, and dark."""
        echo_ns, drain_ns = self._main.pulsin_unit_ns, self._main.rctime_unit_ns
        self.show_ns(
            [middle_ns(one, echo_ns) if one else None for one in stimulus.sonars],
            stimulus.touched,
            [middle_ns(one, drain_ns) if one else None for one in stimulus.lights],
        )

    def show_ns(
        self,
        echoes_ns: Sequence[int | None],
        touched: Sequence[bool],
        drains_ns: Sequence[int | None],
    ) -> None:
        """Put echoes and RC times before them as they are; None for no echo, and for dark."""
        for forced, echo_ns in zip(self._echoes, echoes_ns, strict=True):
            forced.width_ns = echo_ns
        for whisker, bent in zip(self._whiskers, touched, strict=True):
            whisker.touch(bent)
        for cell, drain_ns in zip(self._cells, drains_ns, strict=True):
            cell.drain(drain_ns)
