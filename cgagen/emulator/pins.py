"""A chip's sixteen pins: an output latch and a direction each, and the wire it is on.

Ref: S2 p. 82 for the registers. Reading gives the level of the wire, also of an output. The
programming port is two wires more: pin 16 is SIN when it is read, and SOUT has a method. On
both, 0 is the mark of an idle line and 1 a space, whatever a baud word says. Ref: S2 p. 419.
"""

from collections import deque
from collections.abc import Callable, Iterator

from cgagen.emulator.wires import Taker, Wire

PINS = 16
ALL_PINS = (1 << PINS) - 1
SIN = 16
"""The pin number of the programming port's input."""


class Pins:
    """The pins of one chip.

    A pin without a wire has one of its own that nobody else drives. `floated` is told, once for
    each pin, when a pin is read that nobody drives or pulls; it then reads 0.

    Args:
        owner: the chip's name on the bench, for contention errors.
        floated: told the pin.

    Attributes:
        owner: see above.
        latch: OUTS.
        directions: DIRS; 1 is output.
        wires: what each pin is on, and SIN as the seventeenth.
        sout: the wire of SOUT.
        tape: a queue that is given every level that is read, or None. With it, an instruction
            under way can be repeated later.
        ghost: where levels come from while such an instruction is repeated; no wire is driven
            then. None for real life.
    """

    __slots__ = (
        "_floated",
        "_floating",
        "_names",
        "directions",
        "ghost",
        "latch",
        "owner",
        "sout",
        "tape",
        "wires",
    )

    def __init__(self, owner: str, floated: Callable[[int], None] = lambda pin: None) -> None:
        self.owner = owner
        self.tape: deque[int] | None = None
        self.ghost: Iterator[int] | None = None
        self.latch = 0
        self.directions = 0
        self._names = [f"{owner}.P{pin}" for pin in range(PINS)]
        self.wires = [Wire(name) for name in self._names]
        self.wires.append(Wire(f"{owner}.SIN", pull=0))
        self.sout = Wire(f"{owner}.SOUT", pull=0)
        self._floating: set[int] = set()
        self._floated = floated

    def connect(self, pin: int, wire: Wire) -> None:
        """Put a pin, or `SIN`, on a wire."""
        self.wires[pin] = wire
        if pin < PINS:
            self._show(1 << pin)

    def set_latch(self, latch: int) -> None:
        """Write OUTS."""
        changed, self.latch = self.latch ^ latch, latch
        self._show(changed & self.directions)

    def set_directions(self, directions: int) -> None:
        """Write DIRS; 1 is output."""
        changed, self.directions = self.directions ^ directions, directions
        self._show(changed)

    def invert(self, pin: int) -> None:
        """Invert the latch of one pin that is an output."""
        self.latch ^= 1 << pin
        if self.ghost is None:
            self.wires[pin].drive(self._names[pin], self.latch >> pin & 1)

    def takers(self, pin: int) -> tuple[Taker, ...] | None:
        """Return who may be told of a whole pulse of a pin; see `Wire.takers`."""
        return self.wires[pin].takers(self._names[pin])

    def restore(self, latch: int, directions: int) -> None:
        """Set OUTS and DIRS in one step; a wire that is driven so already hears nothing."""
        self.latch, self.directions = latch, directions
        self._show(ALL_PINS)

    def send(self, level: int) -> None:
        """Set SOUT: driven for a space, let go of for a mark, as the board's circuit does."""
        if self.ghost is None:
            self.sout.drive(self.sout.name, level or None)

    def level(self, pin: int) -> int:
        """Read one pin, or `SIN`: 0 or 1."""
        if self.ghost is not None:
            return next(self.ghost)
        level = self.peek(pin)
        if self.tape is not None:
            self.tape.append(level)
        return level

    def peek(self, pin: int) -> int:
        """Return what `level` returns, but never on or from tape."""
        level = self.wires[pin].level
        if level is None:
            if pin not in self._floating:
                self._floating.add(pin)
                self._floated(pin)
            return 0
        return level

    def levels(self, mask: int) -> int:
        """Read INS, or a part of it.

        Pins that float read 0. They are reported, but not where all sixteen are read at once:
        a program that does that rarely cares for all of them.

        Args:
            mask: the pins that are wanted, a bit each; what others read means nothing.
        """
        if self.ghost is not None:
            return next(self.ghost)
        word, wanted = 0, mask if mask != ALL_PINS else 0
        for pin in range(PINS):
            bit = 1 << pin
            if self.peek(pin) if wanted & bit else self.wires[pin].level:
                word |= bit
        if self.tape is not None:
            self.tape.append(word)
        return word

    def _show(self, changed: int) -> None:
        """Bring the wires of changed pins up to date."""
        if self.ghost is not None:
            return
        while changed:
            bit = changed & -changed
            changed ^= bit
            pin = bit.bit_length() - 1
            level = (1 if self.latch & bit else 0) if self.directions & bit else None
            self.wires[pin].drive(self._names[pin], level)
