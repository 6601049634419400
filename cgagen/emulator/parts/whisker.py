"""A whisker or antenna: a switch to ground with a pull-up. Ref: S5 and common practice.

Left out: bouncing contacts. A program that looks once per step never sees them.
"""

from cgagen.emulator.clock import Clock
from cgagen.emulator.parts.part import Part
from cgagen.emulator.wires import Strength, Wire


class Whisker(Part):
    """10 kohm to the supply; closed, 220 ohm to ground.

    Args:
        name: as the bench calls it.
        clock: the bench's.
        signal: the wire on the pin.

    >>> wire = Wire("whisker")
    >>> whisker = Whisker("left", Clock(), wire); wire.level
    1
    >>> whisker.touch(True); wire.level
    0
    """

    def __init__(self, name: str, clock: Clock, signal: Wire) -> None:
        super().__init__(name, clock)
        self.touched = False
        self._signal = signal
        self.touch(False)

    def touch(self, touched: bool) -> None:
        """Bend it, or let go of it."""
        self.touched = touched
        if touched:
            self._signal.drive(self.name, 0, Strength.RESISTOR)
        else:
            self._signal.drive(self.name, 1, Strength.PULL)
