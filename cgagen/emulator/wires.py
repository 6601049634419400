"""Wires: names, pulls, drivers, and what level comes of them.

A wire is driven high, driven low, pulled, or floats. Two outputs that disagree are a short
circuit, which on a bench burns a pin; here it is an error that names both. What drives through
a resistor gives way to an output and burns nothing.
"""

from collections.abc import Mapping
from typing import NamedTuple

from cgagen.emulator.nets import NOBODY, OUTPUT, End, Net, Strength, Taker, joined
from cgagen.errors import ContentionError

__all__ = ["Strength", "Taker", "Wire", "WireState"]

_Joints = tuple[
    Mapping[str, int], Mapping[str, int], tuple["Wire", ...], frozenset[str], tuple["Wire", ...]
]
"""Faults that force a level and that short, links, cuts, and the ends that are joined."""


class WireState(NamedTuple):
    """A wire at one moment, for `Wire.restore`."""

    level: int | None
    drivers: tuple[tuple[str, int], ...]
    joints: _Joints


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
    _links: tuple["Wire", ...]

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
            ContentionError: outputs of both disagree; then nothing has changed.
        """
        self._links += (other,)
        other._links += (self,)
        try:
            _regroup(self)
        except ContentionError:
            self._links, other._links = self._links[:-1], other._links[:-1]
            raise

    def part(self, other: "Wire") -> None:
        """Take one `join` with another back."""
        for one, gone in ((self, other), (other, self)):
            place = one._links.index(gone)
            one._links = one._links[:place] + one._links[place + 1 :]
        _regroup(self, other)

    def cut(self, who: str) -> None:
        """Cut this end off from all that it is joined to, until the same fault mends it."""
        self._cuts |= {who}
        _regroup(*self._links, self)

    def mend(self, who: str) -> None:
        """Take a cut back.

        Raises:
            ContentionError: outputs on both sides disagree; then nothing has changed.
        """
        self._cuts -= {who}
        try:
            _regroup(*self._links, self)
        except ContentionError:
            self._cuts |= {who}
            raise

    def force(self, who: str, level: int | None) -> None:
        """Give this end alone a level whoever drives it; None ends that. The newest fault wins."""
        self._forced = _with(self._forced, who, level)
        self._net.changed()
        self._settle()

    def short(self, who: str, level: int | None) -> None:
        """Likewise for all that this end is joined to."""
        self._shorts = _with(self._shorts, who, level)
        self._net.changed()
        self._settle()

    def state(self) -> WireState:
        """Return drivers, level, joints and faults as a value for `restore`."""
        return WireState(self.level, tuple(self._drivers.items()), self._joints())

    def restore(self, state: WireState) -> None:
        """Go back to a state of this wire; nobody is told. Listeners stay as they are."""
        self.level, drivers, joints = state
        self._drivers = dict(drivers)
        self._net.newest = None
        if joints != self._joints():
            self._forced, self._shorts, self._links, self._cuts, ends = joints
            Net(ends)

    def _joints(self) -> _Joints:
        return self._forced, self._shorts, self._links, self._cuts, self._net.ends

    def _settle(self) -> None:
        """Bring the level up to date."""
        shorts = [level for wire in self.ends for level in wire._shorts.values()]
        level = shorts[-1] if shorts else self.undisturbed
        changed: list[tuple[Wire, int | None]] = []
        for wire in self.ends:
            new = [*wire._forced.values()][-1] if wire._forced else level
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
        return _short_circuit(self.ends, driver, code, other)


def _regroup(*wires: Wire) -> None:
    """Find anew who is joined to each of these, and tell those who watch.

    Raises:
        ContentionError: outputs that are joined disagree; nothing has changed.
    """
    groups: list[tuple[Wire, ...]] = []
    for wire in wires:
        if not any(wire in group for group in groups):
            groups.append(joined(wire))
    for group in groups:
        outputs = [one for wire in group for one in wire._drivers.items() if one[1] >= OUTPUT]
        for name, code in outputs:
            if code != outputs[0][1]:
                raise _short_circuit(group, *outputs[0], name)
    for group in groups:
        Net(group)
    for group in groups:
        _tell_watchers(group)
        group[0]._settle()


def _with(levels: Mapping[str, int], who: str, level: int | None) -> Mapping[str, int]:
    """Return the levels of faults after one of them has changed its mind."""
    rest = {one: held for one, held in levels.items() if one != who}
    return rest if level is None else {**rest, who: level}


def _short_circuit(group: tuple[Wire, ...], driver: str, code: int, other: str) -> ContentionError:
    return ContentionError(
        f"{group[0].name}: {driver} drives {code & 1}, {other} drives {code & 1 ^ 1}; "
        "take one of them off the wire, or put a resistor between"
    )


def _tell_watchers(group: tuple[Wire, ...]) -> None:
    for wire in group:
        for watcher in wire._watchers:
            watcher()
