"""The referee: a bench part on both step lines that makes one step of both robots one step.

It holds nothing before the first movements: until then nobody moves, and all see the same world.

A robot's finished step is not seen by its main controller before the other robot's is finished,
too: the referee holds the line low from the moment in which the locomotion controller accepts a
movement, and lets go of both lines at one time. All lines are open-drain, so it stands in nobody's
way. Robots that are told nothing by it run free: then it watches only.
"""

from collections.abc import Callable, Mapping

from cgagen.emulator.clock import Clock
from cgagen.emulator.parts.part import Part
from cgagen.emulator.wires import Wire

Told = Callable[[str], None]


class Referee(Part):
    """Holds steps until all are finished.

    Args:
        name: as the bench calls it.
        clock: the bench's.
        lines: step line by robot.
        drivers: who drives it low at the robot's locomotion controller, by robot.
        holds: whether it holds the lines, or watches only.

    Attributes:
        steps: how often it has let all go on.
        early: longest time that a finished robot was held, in ns.
        accepted: called with a robot whose locomotion controller accepts a movement,
        finished: and with one whose legs stand again, at the time when they do,
        released: and when all are let go, just before.
    """

    CIRCUIT = frozenset({"accepted", "finished", "released"})

    def __init__(
        self,
        name: str,
        clock: Clock,
        lines: Mapping[str, Wire],
        drivers: Mapping[str, str],
        holds: bool = True,
    ) -> None:
        super().__init__(name, clock)
        self.steps = 0
        self.early_ns = 0
        self.accepted: Told = _nothing
        self.finished: Told = _nothing
        self.released: Callable[[], None] = lambda: None
        self._holds = holds
        self._lines = tuple(lines.items())
        self._walks = dict.fromkeys(lines, False)
        self._done_ns: dict[str, int] = {}
        self._release = self.timer(self._let_go)
        self._hold = self.timer(self._take_hold)
        for robot, line in lines.items():
            line.watch(
                lambda robot=robot, line=line, driver=drivers[robot]: self._look(  # type: ignore[misc]
                    robot, driver in line.drivers
                )
            )

    def walks(self, robot: str) -> bool:
        """Say whether a robot's locomotion controller holds its line now."""
        return self._walks[robot]

    def _look(self, robot: str, walks: bool) -> None:
        if walks == self._walks[robot]:
            return
        self._walks[robot] = walks
        if walks:
            self._done_ns.pop(robot, None)
            self._hold.after(0)
            self.accepted(robot)
            return
        self._done_ns[robot] = self.clock.now_ns
        self.finished(robot)
        if len(self._done_ns) == len(self._walks):
            self.early_ns = max(self.early_ns, self.clock.now_ns - min(self._done_ns.values()))
            self._release.after(0)

    def _take_hold(self) -> None:
        if self._holds:
            for robot, line in self._lines:
                if self._walks[robot]:
                    line.drive(self.name, 0)

    def _let_go(self) -> None:
        self._done_ns.clear()
        self.steps += 1
        self.released()
        for _, line in self._lines:
            line.drive(self.name, None)


def _nothing(_robot: str) -> None:
    pass
