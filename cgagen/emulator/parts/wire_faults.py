"""Faults of wires and pins: stuck, open, shorted, bridged.

Each fires when a level is not what it would have been without the fault.
"""

from cgagen.emulator.clock import Clock
from cgagen.emulator.parts.fault import Fault
from cgagen.emulator.wires import Wire


class _EndFault(Fault):
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
        self._differs = False
        for wire in {self._rest.name: self._rest, end.name: end}.values():
            wire.listen(lambda _: self._check())
            wire.watch(self._check)

    def _begin(self) -> None:
        self._end_wire.leave()
        self._check()

    def _end(self) -> None:
        self._differs = False
        self._rest.join(self._end_wire)

    def _check(self) -> None:
        """Fire once for every time that the fault begins to matter."""
        if self.on:
            differs = self._matters()
            if differs and not self._differs:
                self._fire()
            self._differs = differs

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
        self._end_wire.leave()
        self._end_wire.force(self._level)
        self._check()

    def _end(self) -> None:
        self._end_wire.force(None)
        super()._end()

    def _matters(self) -> bool:
        mine = self._end_wire.undisturbed
        return self._rest.undisturbed != self._level or mine not in {None, self._level}


class Short(Fault):
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
        self._differs = False
        wire.watch(self._check)

    def _begin(self) -> None:
        for end in self._wire.ends:
            end.force(self._level)
        self._check()

    def _end(self) -> None:
        self._differs = False
        for end in self._wire.ends:
            end.force(None)

    def _check(self) -> None:
        if self.on:
            differs = self._wire.undisturbed != self._level
            if differs and not self._differs:
                self._fire()
            self._differs = differs


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
        self._others = other.ends

    def _begin(self) -> None:
        self._others = self._other.ends
        self._fire()
        self._wire.join(self._other)

    def _end(self) -> None:
        self._other.leave(*(end for end in self._others if end is not self._other))
