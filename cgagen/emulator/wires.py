"""Wires: names, pulls, drivers, and what level comes of them.

A wire is driven high, driven low, pulled, or floats. Two outputs that disagree are a short
circuit, which on a bench burns a pin; here it is an error that names both. What drives through
a resistor gives way to an output and burns nothing.
"""

from cgagen.emulator.nets import NOBODY, OUTPUT, End, Net, Strength, Taker
from cgagen.errors import ContentionError

__all__ = ["Strength", "Taker", "Wire", "WireState"]

WireState = tuple[int | None, tuple[tuple[str, int], ...], int | None, tuple["Wire", ...]]


class Wire(End):
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

    __slots__ = ()

    _net: Net["Wire"]

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
        before = drivers.get(driver, NOBODY)
        code = NOBODY if level is None else 2 * strength + level
        if code == before:
            return
        # Most wires have one driver that changes its mind again and again: what holds against it
        # is found once, for as long as nobody else moves.
        if net.newest is not self or net.driver != driver:
            net.against(self, driver)
        if code >= OUTPUT and net.rest == code ^ 1:
            raise self._contention(driver, code)
        if code == NOBODY:
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
        if net.special or net.takers is None or self._drivers.get(driver) != OUTPUT:
            return None
        if net.newest is not self or net.driver != driver:
            net.against(self, driver)
        return net.takers if net.rest < OUTPUT else None

    @property
    def output(self) -> int | None:
        """The level that an output gives; None where there is none."""
        code = max((code for wire in self.ends for code in wire._drivers.values()), default=0)
        return code & 1 if code >= OUTPUT else None

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
        _tell_watchers(Net(self.ends + other.ends).ends)
        self._settle()

    def leave(self, *others: "Wire") -> None:
        """Cut this end, with others that stay joined to it, off from the rest."""
        rest = tuple(wire for wire in self.ends if wire is not self and wire not in others)
        mine = (self, *others)
        for group in (mine, rest):
            Net(group)
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
            Net(ends)

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
            name for wire in self.ends for name, code in wire._drivers.items() if code >= OUTPUT
        )


def _tell_watchers(group: tuple[Wire, ...]) -> None:
    for wire in group:
        for watcher in wire._watchers:
            watcher()
