"""Wires: names, pulls, drivers, and what level comes of them.

A wire is driven high, driven low, pulled, or floats. Two outputs that disagree are a short
circuit, which on a bench burns a pin; here it is an error that names both. What drives through
a resistor gives way to an output and burns nothing.
"""

from collections.abc import Callable
from enum import IntEnum

from cgagen.errors import ContentionError

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


WireState = tuple[int | None, tuple[tuple[str, int], ...], int | None, tuple["Wire", ...]]


class Wire:
    """One wire, or one end of a wire that can be cut: ends that are joined have one level.

    Attributes:
        name: as the bench calls it, for example "step".
        pull: level that a resistor gives it while nobody drives it; None for no resistor.
        level: 0, 1, or None while it floats.

    >>> wire = Wire("step", pull=1)
    >>> wire.drive("legs.P15", 0); wire.level
    0
    >>> wire.drive("legs.P15", None); wire.level
    1
    """

    __slots__ = (
        "_drivers",
        "_forced",
        "_listeners",
        "_net",
        "_pull",
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
        self._forced: int | None = None
        self._listeners: tuple[Listener, ...] = ()
        self._takers: dict[Listener, Taker] = {}
        self._watchers: tuple[Watcher, ...] = ()
        self._net = _Net((self,))

    @property
    def pull(self) -> int | None:
        """Level that a resistor gives it while nobody drives it; None for no resistor."""
        return self._pull

    @pull.setter
    def pull(self, level: int | None) -> None:
        self._pull = level
        self._net.changed()

    def drive(self, driver: str, level: int | None, strength: Strength = Strength.OUTPUT) -> None:
        """Drive the wire, or let go of it.

        Args:
            driver: who, for example "main.P3".
            level: 0, 1, or None to let go.
            strength: an output, or something behind a resistor.

        Raises:
            ContentionError: another output holds the other level.
        """
        drivers, net = self._drivers, self._net
        before = drivers.get(driver, _NOBODY)
        code = _NOBODY if level is None else 2 * strength + level
        if code == before:
            return
        # Most wires have one driver that changes its mind again and again: what holds against it
        # is found once, for as long as nobody else moves.
        if net.newest is not self or net.driver != driver:
            net.against(self, driver)
        if code >= _OUTPUT and net.rest == code ^ 1:
            raise self._contention(driver, code)
        if code == _NOBODY:
            del drivers[driver]
        else:
            drivers[driver] = code
        if net.special:
            _tell_watchers(net.ends)
            self._settle()
            return
        firmest = code if code > net.rest else net.rest
        new = firmest & 1 if firmest >= 0 else None
        if new != self.level:
            for wire in net.ends:
                wire.level = new
            for wire in net.heard:
                for listener in wire._listeners:  # as `_tell`, without a call
                    if wire.level != new:
                        break
                    listener(new)

    def takers(self, driver: str) -> tuple[Taker, ...] | None:
        """Return whom to tell of a whole pulse of a driver, instead of raising and lowering.

        None where that would not be the same: the driver is not alone in giving this wire its
        level, which is low, or somebody listens who wants to hear of both edges.
        """
        net = self._net
        if net.special or net.takers is None or self._drivers.get(driver) != _OUTPUT:
            return None
        if net.newest is not self or net.driver != driver:
            net.against(self, driver)
        return net.takers if net.rest < _OUTPUT else None

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

    @property
    def output(self) -> int | None:
        """The level that an output gives; None where there is none."""
        code = max((code for wire in self.ends for code in wire._drivers.values()), default=0)
        return code & 1 if code >= _OUTPUT else None

    @property
    def undisturbed(self) -> int | None:
        """The level without anything forced on it."""
        codes = [code for wire in self.ends for code in wire._drivers.values()]
        codes += [wire._pull for wire in self.ends if wire._pull is not None]
        return max(codes) & 1 if codes else None

    @property
    def drivers(self) -> tuple[str, ...]:
        """Who drives it now."""
        return tuple(name for wire in self.ends for name in wire._drivers)

    @property
    def ends(self) -> tuple["Wire", ...]:
        """All that are joined with this one, itself included."""
        return self._net.ends

    def join(self, other: "Wire") -> None:
        """Make one wire of this and another, each with what it is joined to.

        Raises:
            ContentionError: outputs of both disagree.
        """
        if other in self.ends:
            return
        mine, theirs = self.output, other.output
        if mine is not None and theirs is not None and mine != theirs:
            raise ContentionError(
                f"{self.name}: {self._output_name()} drives {mine}, {other._output_name()} drives "
                f"{theirs}; take one of them off the wire, or put a resistor between"
            )
        _tell_watchers(_Net(self.ends + other.ends).ends)
        self._settle()

    def leave(self, *others: "Wire") -> None:
        """Cut this end, with others that stay joined to it, off from the rest."""
        rest = tuple(wire for wire in self.ends if wire is not self and wire not in others)
        mine = (self, *others)
        for group in (mine, rest):
            _Net(group)
        _tell_watchers((*mine, *rest))
        self._settle()
        for wire in rest[:1]:
            wire._settle()

    def force(self, level: int | None) -> None:
        """Give this end a level whoever drives it; None ends that. For faults alone."""
        self._forced = level
        self._net.changed()
        self._settle()

    def state(self) -> WireState:
        """Return drivers, level and joints as a value for `restore`."""
        return self.level, tuple(self._drivers.items()), self._forced, self.ends

    def restore(self, state: WireState) -> None:
        """Go back to a state of this wire; nobody is told. Listeners stay as they are."""
        self.level, drivers, forced, ends = state
        self._drivers = dict(drivers)
        self._net.newest = None
        if forced != self._forced or ends is not self._net.ends:
            self._forced = forced
            _Net(ends)

    def _settle(self) -> None:
        """Bring the level up to date."""
        level = self.undisturbed
        changed: list[tuple[Wire, int | None]] = []
        for wire in self.ends:
            new = level if wire._forced is None else wire._forced
            if new != wire.level:
                wire.level = new
                changed.append((wire, new))
        for wire, new in changed:
            wire._tell(new)

    def _tell(self, level: int | None) -> None:
        """Tell the listeners of this end, while it keeps that level."""
        for listener in self._listeners:
            if self.level != level:
                break
            listener(level)

    def _contention(self, driver: str, code: int) -> ContentionError:
        """Return the error: a driver is against an output of another."""
        other = next(
            name
            for wire in self.ends
            for name, held in wire._drivers.items()
            if held == code ^ 1 and name != driver
        )
        return ContentionError(
            f"{self.ends[0].name}: {driver} drives {code & 1}, {other} drives {code & 1 ^ 1}; "
            "take one of them off the wire, or put a resistor between"
        )

    def _output_name(self) -> str:
        return next(
            name for wire in self.ends for name, code in wire._drivers.items() if code >= _OUTPUT
        )


class _Net:
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

    def __init__(self, ends: tuple[Wire, ...]) -> None:
        self.ends = ends
        self.driver, self.rest = "", _NOBODY
        for wire in ends:
            wire._net = self
        self.changed()

    def changed(self) -> None:
        """Forget what was known."""
        self.newest: Wire | None = None
        self.special = any(wire._watchers or wire._forced is not None for wire in self.ends)
        self.heard = tuple(wire for wire in self.ends if wire._listeners)
        takers = [wire._takers.get(one) for wire in self.heard for one in wire._listeners]
        self.takers = None if None in takers else tuple(filter(None, takers))

    def against(self, newest: Wire, driver: str) -> None:
        """Find what holds against a driver."""
        rest = _NOBODY
        for wire in self.ends:
            for name, held in wire._drivers.items():
                if held > rest and (wire is not newest or name != driver):
                    rest = held
            pull = wire._pull
            if pull is not None and pull > rest:
                rest = pull
        self.newest, self.driver, self.rest = newest, driver, rest


_OUTPUT = 2 * Strength.OUTPUT
_NOBODY = -1


def _tell_watchers(group: tuple[Wire, ...]) -> None:
    for wire in group:
        for watcher in wire._watchers:
            watcher()
