"""Polled inputs and outputs of BS2p and BS2pe: what the chip does between two instructions.

Ref: S2 p. 313 to 337 (POLLIN, POLLMODE, POLLOUT, POLLRUN, POLLWAIT), p. 93 for the bytes of the
scratch pad that show it. Not documented, so our choice: a poll takes no time of its own.
"""

from dataclasses import dataclass, field

from cgagen.emulator.pins import PINS, Pins

_ACTIONS = {2: (True, False), 3: (False, True), 4: (True, True)}
"""Mode: whether polled outputs (and POLLWAIT) act, and whether POLLRUN does."""


@dataclass(slots=True)
class Polling:
    """What a chip polls.

    Attributes:
        inputs: the level that a pin is looked at for.
        outputs: the level that a pin gets when any input has its own.
        mode: 0 to 4, as POLLMODE set it.
        latching: an output that has acted keeps its level.
        latched: that has happened.
        slot: what POLLRUN runs.
        seen: pins that had their level since POLLMODE, a bit each.
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

    def watch(self, pin: int, level: int, pins: Pins) -> None:
        """Carry out POLLIN: the pin becomes an input."""
        pins.set_directions(pins.directions & ~(1 << pin))
        self.inputs = {**self.inputs, pin: level}

    def drive(self, pin: int, level: int, pins: Pins) -> None:
        """Carry out POLLOUT: the pin becomes an output at the other level."""
        self.outputs = {**self.outputs, pin: level}
        _set(pins, pin, 1 - level)
        pins.set_directions(pins.directions | 1 << pin)

    def poll(self, pins: Pins) -> int | None:
        """Look at the inputs, set the outputs; returns the slot to run, if any."""
        hits = 0
        for pin, level in self.inputs.items():
            if pins.level(pin) == level:
                hits |= 1 << pin
        self.triggered = hits != 0
        self.seen |= hits
        acts, runs = _ACTIONS[self.mode]
        if acts and self.inputs and not self.latched:
            for pin, level in self.outputs.items():
                _set(pins, pin, level if hits else 1 - level)
            self.latched = self.latching and hits != 0
        if runs and hits:
            self.mode -= 2 if self.mode == 4 else 0
            self.mode = 1 if self.mode == 3 else self.mode
            return self.slot
        return None

    def status(self) -> tuple[int, int, int, int, int]:
        """Return the bytes 128, 129, 132, 133 and 135 of the scratch pad."""
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
        return self.seen & 0xFF, self.seen >> PINS // 2, mode, self.slot, flags


def _set(pins: Pins, pin: int, level: int) -> None:
    pins.set_latch(pins.latch & ~(1 << pin) | level << pin)
