"""A generator: holds a wire at a level, or plays levels at given times.

Left out: nothing; it is an output like a chip's, or one behind a resistor.
"""

from collections.abc import Sequence

from cgagen.emulator.clock import Clock
from cgagen.emulator.parts.part import Part
from cgagen.emulator.wires import Strength, Wire


class Signal(Part):
    """Levels for a wire.

    Args:
        name: as the bench calls it.
        clock: the bench's.
        wire: what it drives.
        level: what it holds from the beginning; None to let go.
        changes: (time in ns, level), the times rising.
        strength: how firmly.
    """

    def __init__(
        self,
        name: str,
        clock: Clock,
        wire: Wire,
        level: int | None = None,
        changes: Sequence[tuple[int, int | None]] = (),
        strength: Strength = Strength.OUTPUT,
    ) -> None:
        super().__init__(name, clock)
        self._wire = wire
        self._strength = strength
        self._left: list[tuple[int, int | None]] = list(changes)
        self._next = self.timer(self._play)
        self.set(level)
        self._book()

    def set(self, level: int | None) -> None:
        """Hold a level from now on; None to let go."""
        self._wire.drive(self.name, level, self._strength)

    def _book(self) -> None:
        if self._left:
            self._next.at(self._left[0][0])

    def _play(self) -> None:
        _, level = self._left.pop(0)
        self.set(level)
        self._book()
