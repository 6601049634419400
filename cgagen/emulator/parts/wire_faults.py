"""Faults of wires and pins: stuck, open, shorted, bridged.

Each fires when a level is not what it would have been without the fault.
"""

from abc import ABC, abstractmethod

from cgagen.emulator.clock import Clock
from cgagen.emulator.parts.fault import Fault
from cgagen.emulator.wires import Wire


class _LevelFault(Fault, ABC):
    """A fault that fires once for every time that it begins to matter."""

    def __init__(
        self, name: str, clock: Clock, from_ns: int | None = 0, until_ns: int | None = None
    ) -> None:
        super().__init__(name, clock, from_ns, until_ns)
        self._differs = False

    @abstractmethod
    def _matters(self) -> bool:
        """Say whether a level is not what it would be without the fault."""

    def _check(self) -> None:
        """Look whether it matters now."""
        differs = self.on and self._matters()
        if differs and not self._differs:
            self._fire()
        self._differs = differs


class _EndFault(_LevelFault):
    """A fault that takes one end off its wire.

    Args:
        name: as the bench calls it.
        clock: the bench's.
        end: the pin's or the lead's own end.
        from_ns: see `Fault`.
        until_ns: likewise.
    """

    def __init__(
        self,
        name: str,
        clock: Clock,
        end: Wire,
        from_ns: int | None = 0,
        until_ns: int | None = None,
    ) -> None:
        super().__init__(name, clock, from_ns, until_ns)
        self._end_wire = end
        self._rest = next((wire for wire in end.ends if wire is not end), end)
        for wire in {self._rest.name: self._rest, end.name: end}.values():
            wire.listen(lambda _: self._check())
            wire.watch(self._check)

    def _begin(self) -> None:
        self._end_wire.cut(self.name)
        self._check()

    def _end(self) -> None:
        self._end_wire.mend(self.name)
        self._check()

    def _matters(self) -> bool:
        return self._rest.undisturbed != self._end_wire.undisturbed


class Open(_EndFault):
    """The wire is broken at one end."""


class Stuck(_EndFault):
    """A pin reads one level whatever is on the wire, and nothing comes out of it.

    Args:
        name: as the bench calls it.
        clock: the bench's.
        end: the pin's own end.
        level: 0 or 1.
        from_ns: see `Fault`.
        until_ns: likewise.
    """

    def __init__(
        self,
        name: str,
        clock: Clock,
        end: Wire,
        level: int,
        from_ns: int | None = 0,
        until_ns: int | None = None,
    ) -> None:
        self._level = level
        super().__init__(name, clock, end, from_ns, until_ns)

    def _begin(self) -> None:
        self._end_wire.short(self.name, self._level)
        super()._begin()

    def _end(self) -> None:
        self._end_wire.short(self.name, None)
        super()._end()

    def _matters(self) -> bool:
        mine = self._end_wire.undisturbed
        return self._rest.undisturbed != self._level or mine not in {None, self._level}


class Short(_LevelFault):
    """The wire is shorted to ground (0) or to the supply (1), and nothing burns.

    Args:
        name: as the bench calls it.
        clock: the bench's.
        wire: which one.
        level: 0 or 1.
        from_ns: see `Fault`.
        until_ns: likewise.
    """

    def __init__(
        self,
        name: str,
        clock: Clock,
        wire: Wire,
        level: int,
        from_ns: int | None = 0,
        until_ns: int | None = None,
    ) -> None:
        super().__init__(name, clock, from_ns, until_ns)
        self._wire = wire
        self._level = level
        wire.watch(self._check)

    def _begin(self) -> None:
        self._wire.short(self.name, self._level)
        self._check()

    def _end(self) -> None:
        self._wire.short(self.name, None)
        self._check()

    def _matters(self) -> bool:
        return self._wire.undisturbed != self._level


class Bridge(Fault):
    """Two wires touch. Outputs that then disagree are a short circuit and end the run.

    It fires when it comes.

    Args:
        name: as the bench calls it.
        clock: the bench's.
        wire: one.
        other: the other.
        from_ns: see `Fault`.
        until_ns: likewise.
    """

    def __init__(
        self,
        name: str,
        clock: Clock,
        wire: Wire,
        other: Wire,
        from_ns: int | None = 0,
        until_ns: int | None = None,
    ) -> None:
        super().__init__(name, clock, from_ns, until_ns)
        self._wire = wire
        self._other = other

    def _begin(self) -> None:
        self._fire()
        self._wire.join(self._other)

    def _end(self) -> None:
        self._wire.part(self._other)
