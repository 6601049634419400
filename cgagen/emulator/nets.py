"""Ends of wires, and what is known of those that are joined; for `cgagen.emulator.wires`.

An end has drivers and a resistor, and others listen to it. A net is made anew whenever ends are
joined or cut.
"""

from collections.abc import Callable, Mapping
from enum import IntEnum
from typing import Any, Generic, TypeVar

Listener = Callable[[int | None], None]
"""Told the new level of a wire: 0, 1, or None where it floats."""

Taker = Callable[[int], None]
"""Told at the end of a high pulse when it began, in place of two changes."""

Watcher = Callable[[], None]
"""Told that somebody drives, changes or lets go, also where the level stays."""


class Strength(IntEnum):
    """How firmly a level is held; the firmest decides.

    Two of one strength below `OUTPUT` that disagree make a divider of equal resistors: half the
    supply, which is above the threshold of 1.4 V and reads 1. Ref: S4 (COUNT) for the threshold.
    """

    PULL = 0
    """Through some 10 kohm."""
    RESISTOR = 1
    """Through some hundred ohm: an output wins, and nothing burns."""
    OUTPUT = 2


OUTPUT = 2 * Strength.OUTPUT
"""The least code of an output: twice the strength, plus the level."""
NOBODY = -1


class End:
    """One end of a wire; see `cgagen.emulator.wires.Wire`."""

    __slots__ = (
        "_cuts",
        "_drivers",
        "_forced",
        "_links",
        "_listeners",
        "_net",
        "_pull",
        "_shorts",
        "_takers",
        "_watchers",
        "level",
        "name",
    )

    def __init__(self, name: str, pull: int | None = None) -> None:
        self.name = name
        self.level = pull
        self._pull = pull
        # 2 * strength + level: the greatest decides, and its last bit is the level.
        self._drivers: dict[str, int] = {}
        # Faults by name, the newest last: a level of this end alone, one of its whole net.
        self._forced: Mapping[str, int] = {}
        self._shorts: Mapping[str, int] = {}
        # Ends that this one is soldered to, and the faults that have cut it off from them.
        self._links: tuple[Any, ...] = ()
        self._cuts: frozenset[str] = frozenset()
        self._listeners: tuple[Listener, ...] = ()
        self._takers: dict[Listener, Taker] = {}
        self._watchers: tuple[Watcher, ...] = ()
        self._net: Net[Any] = Net((self,))

    @property
    def pull(self) -> int | None:
        """Level that a resistor gives it while nobody drives it; None for no resistor."""
        return self._pull

    @pull.setter
    def pull(self, level: int | None) -> None:
        self._pull = level
        self._net.changed()

    def listen(self, listener: Listener, taker: Taker | None = None) -> Callable[[], None]:
        """Tell `listener` every change; returns how to stop that.

        Where a listener changes the level in turn, those after it hear only the newest level.

        Args:
            listener: see above.
            taker: given by listeners that touch no wire and book nothing: may be told of a whole
                pulse instead of its two edges, where nothing else happens in between.
        """
        if taker is not None:
            self._takers[listener] = taker
        self._listeners += (listener,)
        self._net.changed()

        def stop() -> None:
            left = list(self._listeners)
            left.remove(listener)
            if listener not in left:
                self._takers.pop(listener, None)
            self._listeners = tuple(left)
            self._net.changed()

        return stop

    def watch(self, watcher: Watcher) -> None:
        """Tell `watcher` whenever somebody drives or lets go, before the level follows.

        For circuits that an output charges: letting go of a charged capacitor changes no level.
        """
        self._watchers += (watcher,)
        self._net.changed()

    def _tell(self, level: int | None) -> None:
        """Tell the listeners of this end, while it keeps that level."""
        for listener in self._listeners:
            if self.level != level:
                break
            listener(level)


EndT = TypeVar("EndT", bound=End)


class Net(Generic[EndT]):
    """Ends that are joined, and what holds for all of them until one of them changes.

    Making one takes its ends out of their former nets.

    Attributes:
        ends: see above.
        newest: the end whose driver moved last; None after any other change.
        driver: that driver.
        rest: the firmest of all other drivers and pulls.
        special: somebody watches, or a level is forced.
        heard: ends that have listeners.
        takers: of all listeners; None where one has none.
    """

    __slots__ = ("driver", "ends", "heard", "newest", "rest", "special", "takers")

    def __init__(self, ends: tuple[EndT, ...]) -> None:
        self.ends = ends
        self.driver, self.rest = "", NOBODY
        for wire in ends:
            wire._net = self
        self.changed()

    def changed(self) -> None:
        """Forget what was known."""
        self.newest: EndT | None = None
        self.special = any(wire._watchers or wire._forced or wire._shorts for wire in self.ends)
        self.heard = tuple(wire for wire in self.ends if wire._listeners)
        takers = [wire._takers.get(one) for wire in self.heard for one in wire._listeners]
        self.takers = None if None in takers else tuple(filter(None, takers))

    def against(self, newest: EndT, driver: str) -> None:
        """Find what holds against a driver."""
        rest = NOBODY
        for wire in self.ends:
            for name, held in wire._drivers.items():
                if held > rest and (wire is not newest or name != driver):
                    rest = held
            pull = wire._pull
            if pull is not None and pull > rest:
                rest = pull
        self.newest, self.driver, self.rest = newest, driver, rest


def joined(end: EndT) -> tuple[EndT, ...]:
    """Return an end and all that it is soldered to, directly or not, as far as nothing is cut."""
    found = [end]
    for one in found:
        for other in () if one._cuts else one._links:
            if not other._cuts and other not in found:
                found.append(other)
    return tuple(found)
