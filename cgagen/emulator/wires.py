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
        "_group",
        "_listeners",
        "_watchers",
        "level",
        "name",
        "pull",
    )

    def __init__(self, name: str, pull: int | None = None) -> None:
        self.name = name
        self.pull = pull
        self.level = pull
        # 2 * strength + level: the greatest decides, and its last bit is the level.
        self._drivers: dict[str, int] = {}
        self._forced: int | None = None
        self._group: tuple[Wire, ...] = (self,)
        self._listeners: list[Listener] = []
        self._watchers: list[Watcher] = []

    def drive(self, driver: str, level: int | None, strength: Strength = Strength.OUTPUT) -> None:
        """Drive the wire, or let go of it.

        Args:
            driver: who, for example "main.P3".
            level: 0, 1, or None to let go.
            strength: an output, or something behind a resistor.

        Raises:
            ContentionError: another output holds the other level.
        """
        drivers = self._drivers
        before = drivers.get(driver, _NOBODY)
        code = _NOBODY if level is None else 2 * strength + level
        if code == before:
            return
        if code == _NOBODY:
            del drivers[driver]
        else:
            drivers[driver] = code
        firmest, enemy, watched = _NOBODY, code ^ 1 if code >= _OUTPUT else _NOBODY, False
        for wire in self._group:
            for held in wire._drivers.values():
                if held > firmest:  # noqa: PLR1730  the innermost loop of all
                    firmest = held
                if held == enemy:
                    self._refuse_contention(driver, before)
            pull = wire.pull
            if pull is not None and pull > firmest:
                firmest = pull
            if wire._watchers:
                watched = True
        if watched:
            _tell(self._group)
            self._settle()
        else:
            self._spread(firmest & 1 if firmest >= 0 else None)

    def listen(self, listener: Listener) -> Callable[[], None]:
        """Tell `listener` every change; returns how to stop that.

        Where a listener changes the level in turn, those after it hear only the newest level.
        """
        self._listeners.append(listener)
        return lambda: self._listeners.remove(listener)

    def watch(self, watcher: Watcher) -> None:
        """Tell `watcher` whenever somebody drives or lets go, before the level follows.

        For circuits that an output charges: letting go of a charged capacitor changes no level.
        """
        self._watchers.append(watcher)

    @property
    def output(self) -> int | None:
        """The level that an output gives; None where there is none."""
        code = max((code for wire in self._group for code in wire._drivers.values()), default=0)
        return code & 1 if code >= _OUTPUT else None

    @property
    def undisturbed(self) -> int | None:
        """The level without anything forced on it."""
        codes = [code for wire in self._group for code in wire._drivers.values()]
        codes += [wire.pull for wire in self._group if wire.pull is not None]
        return max(codes) & 1 if codes else None

    @property
    def drivers(self) -> tuple[str, ...]:
        """Who drives it now."""
        return tuple(name for wire in self._group for name in wire._drivers)

    @property
    def ends(self) -> tuple["Wire", ...]:
        """All that are joined with this one, itself included."""
        return self._group

    def join(self, other: "Wire") -> None:
        """Make one wire of this and another, each with what it is joined to.

        Raises:
            ContentionError: outputs of both disagree.
        """
        if other in self._group:
            return
        mine, theirs = self.output, other.output
        if mine is not None and theirs is not None and mine != theirs:
            raise ContentionError(
                f"{self.name}: {self._output_name()} drives {mine}, {other._output_name()} drives "
                f"{theirs}; take one of them off the wire, or put a resistor between"
            )
        group = self._group + other._group
        for wire in group:
            wire._group = group
        _tell(group)
        self._settle()

    def leave(self, *others: "Wire") -> None:
        """Cut this end, with others that stay joined to it, off from the rest."""
        rest = tuple(wire for wire in self._group if wire is not self and wire not in others)
        mine = (self, *others)
        for group in (mine, rest):
            for wire in group:
                wire._group = group
        _tell((*mine, *rest))
        self._settle()
        for wire in rest[:1]:
            wire._settle()

    def force(self, level: int | None) -> None:
        """Give this end a level whoever drives it; None ends that. For faults alone."""
        self._forced = level
        self._settle()

    def state(self) -> WireState:
        """Return drivers, level and joints as a value for `restore`."""
        return self.level, tuple(self._drivers.items()), self._forced, self._group

    def restore(self, state: WireState) -> None:
        """Go back to a state of this wire; nobody is told. Listeners stay as they are."""
        self.level, drivers, self._forced, self._group = state
        self._drivers = dict(drivers)

    def _settle(self) -> None:
        """Bring the level up to date."""
        self._spread(self.undisturbed)

    def _spread(self, level: int | None) -> None:
        """Give all ends their level, before anybody hears of it."""
        changed = []
        for wire in self._group:
            new = level if wire._forced is None else wire._forced
            if new != wire.level:
                wire.level = new
                if wire._listeners:
                    changed.append((wire, new))
        for wire, new in changed:
            for listener in tuple(wire._listeners):
                if wire.level != new:
                    break
                listener(new)

    def _refuse_contention(self, driver: str, before: int) -> None:
        """Make the driver what it was, and raise, where somebody else is against it."""
        code = self._drivers[driver]
        for wire in self._group:
            for other, held in wire._drivers.items():
                if held == code ^ 1 and other != driver:
                    if before == _NOBODY:
                        del self._drivers[driver]
                    else:
                        self._drivers[driver] = before
                    raise ContentionError(
                        f"{self._group[0].name}: {driver} drives {code & 1}, {other} drives "
                        f"{held & 1}; take one of them off the wire, or put a resistor between"
                    )

    def _output_name(self) -> str:
        return next(
            name for wire in self._group for name, code in wire._drivers.items() if code >= _OUTPUT
        )


_OUTPUT = 2 * Strength.OUTPUT
_NOBODY = -1


def _tell(group: tuple[Wire, ...]) -> None:
    for wire in group:
        for watcher in tuple(wire._watchers):
            watcher()
