"""Polled inputs and outputs of BS2p and BS2pe: what the chip does between two instructions.

Ref: S2 p. 313 to 337 (POLLIN, POLLMODE, POLLOUT, POLLRUN, POLLWAIT), p. 93 for the bytes of the
scratch pad that show it. Not documented, so our choice: a poll takes no time of its own.
"""

from dataclasses import dataclass, field

from cgagen.emulator.pins import PINS, Pins

Groups = tuple[Pins, Pins]
"""Main and auxiliary pins of a chip. A place is a pin of the first, or 16 more for the second."""

_ACTIONS = {2: (True, False), 3: (False, True), 4: (True, True)}
"""Mode: whether polled outputs (and POLLWAIT) act, and whether POLLRUN does."""


@dataclass(slots=True)
class Polling:
    """What a chip polls.

    Attributes:
        inputs: the level that a place is looked at for.
        outputs: the level that a place gets when any input has its own.
        mode: 0 to 4, as POLLMODE set it.
        latching: an output that has acted keeps its level.
        latched: that has happened.
        slot: what POLLRUN runs.
        seen: places that had their level since POLLMODE, a bit each.
        triggered: at the last poll an input had its level.
    """

    inputs: dict[int, int] = field(default_factory=dict)
    outputs: dict[int, int] = field(default_factory=dict)
    mode: int = 0
    latching: bool = False
    latched: bool = False
    slot: int = 0
    seen: int = 0
    triggered: bool = False

    @property
    def active(self) -> bool:
        """Whether anything is to be done between instructions."""
        return self.mode in _ACTIONS

    @property
    def waits(self) -> bool:
        """Whether POLLWAIT does anything."""
        return _ACTIONS.get(self.mode, (False, False))[0] and bool(self.inputs)

    def copy(self) -> "Polling":
        """Return a copy that is on its own."""
        flags = self.latching, self.latched, self.slot, self.seen, self.triggered
        return Polling(self.inputs, self.outputs, self.mode, *flags)

    def set_mode(self, mode: int) -> None:
        """Carry out POLLMODE."""
        low = mode & 7
        if low in (0, 5, 7):
            self.inputs = {}
        if low in (0, 6, 7):
            self.outputs = {}
        if low < 5:
            self.mode = low
            self.latching = bool(mode & 8)
            self.latched = self.triggered = False
            self.seen = 0

    def watch(self, place: int, level: int, groups: Groups) -> None:
        """Carry out POLLIN: the pin becomes an input."""
        pins, pin = groups[place // PINS], place % PINS
        pins.set_directions(pins.directions & ~(1 << pin))
        self.inputs = {**self.inputs, place: level}

    def drive(self, place: int, level: int, groups: Groups) -> None:
        """Carry out POLLOUT: the pin becomes an output at the other level."""
        self.outputs = {**self.outputs, place: level}
        _set(groups, place, 1 - level)
        pins = groups[place // PINS]
        pins.set_directions(pins.directions | 1 << place % PINS)

    def hits(self, groups: Groups) -> int:
        """Look at the inputs; returns those that have their level, a bit each."""
        return sum(
            1 << place
            for place, level in self.inputs.items()
            if groups[place // PINS].level(place % PINS) == level
        )

    def poll(self, groups: Groups) -> int | None:
        """Look at the inputs, set the outputs; returns the slot to run, if any."""
        hits = self.hits(groups)
        self.triggered = hits != 0
        self.seen |= hits
        acts, runs = _ACTIONS[self.mode]
        if acts and self.inputs and not self.latched:
            for place, level in self.outputs.items():
                _set(groups, place, level if hits else 1 - level)
            self.latched = self.latching and hits != 0
        if runs and hits:
            self.mode -= 2 if self.mode == 4 else 0
            self.mode = 1 if self.mode == 3 else self.mode
            return self.slot
        return None

    def status(self) -> tuple[bytes, int, int, int]:
        """Return the bytes 128 to 131, 132, 133 and 135 of the scratch pad."""
        acts, runs = _ACTIONS.get(self.mode, (False, False))
        bits = (
            acts and bool(self.outputs),
            bool(self.inputs),
            runs,
            self.latching,
            self.triggered,
            self.latched,
            self.seen != 0,
            self.active,
        )
        flags = sum(1 << place for place, bit in enumerate(bits) if bit)
        mode = self.mode | (8 if self.latching else 0)
        return self.seen.to_bytes(4, "little"), mode, self.slot, flags


def _set(groups: Groups, place: int, level: int) -> None:
    pins, pin = groups[place // PINS], place % PINS
    pins.set_latch(pins.latch & ~(1 << pin) | level << pin)
