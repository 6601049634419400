"""A chip's sixteen pins: an output latch and a direction each, and the wire it is on.

Ref: S2 p. 82 for the registers. Reading gives the level of the wire, also of an output.
"""

from collections.abc import Callable

from cgagen.emulator.wires import Wire

PINS = 16


class Pins:
    """The pins of one chip.

    A pin without a wire has one of its own that nobody else drives. `floated` is told, once for
    each pin, when a pin is read that nobody drives or pulls; it then reads 0.

    Args:
        owner: the chip's name on the bench, for contention errors.
        floated: told the pin.
    """

    __slots__ = ("_floated", "_floating", "_names", "directions", "latch", "wires")

    def __init__(self, owner: str, floated: Callable[[int], None] = lambda pin: None) -> None:
        self.latch = 0
        self.directions = 0
        self._names = [f"{owner}.P{pin}" for pin in range(PINS)]
        self.wires = [Wire(name) for name in self._names]
        self._floating: set[int] = set()
        self._floated = floated

    def connect(self, pin: int, wire: Wire) -> None:
        """Put a pin on a wire."""
        self.wires[pin] = wire
        self._show(1 << pin)

    def set_latch(self, latch: int) -> None:
        """Write OUTS."""
        changed, self.latch = self.latch ^ latch, latch
        self._show(changed & self.directions)

    def set_directions(self, directions: int) -> None:
        """Write DIRS; 1 is output."""
        changed, self.directions = self.directions ^ directions, directions
        self._show(changed)

    def level(self, pin: int) -> int:
        """Read one pin: 0 or 1."""
        level = self.wires[pin].level
        if level is None:
            if pin not in self._floating:
                self._floating.add(pin)
                self._floated(pin)
            return 0
        return level

    def levels(self) -> int:
        """Read INS.

        Pins that float read 0 and are not reported: a program that reads all sixteen at once
        rarely cares for all of them.
        """
        word = 0
        for pin, wire in enumerate(self.wires):
            if wire.level:
                word |= 1 << pin
        return word

    def _show(self, changed: int) -> None:
        """Bring the wires of changed pins up to date."""
        pin = 0
        while changed:
            if changed & 1:
                output = self.directions >> pin & 1
                self.wires[pin].drive(self._names[pin], self.latch >> pin & 1 if output else None)
            changed >>= 1
            pin += 1
