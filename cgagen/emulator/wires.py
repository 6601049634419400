"""Wires: a name, a pull and at most one opinion.

A wire is driven high, driven low, pulled, or floats. Two drivers that disagree are a short
circuit, which on a bench burns a pin; here it is an error that names both.
"""

from collections.abc import Callable

from cgagen.errors import ContentionError

Listener = Callable[[int | None], None]
"""Told the new level of a wire: 0, 1, or None where it floats."""


class Wire:
    """One wire.

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

    __slots__ = ("_drivers", "_listeners", "level", "name", "pull")

    def __init__(self, name: str, pull: int | None = None) -> None:
        self.name = name
        self.pull = pull
        self.level = pull
        self._drivers: dict[str, int] = {}
        self._listeners: list[Listener] = []

    def drive(self, driver: str, level: int | None) -> None:
        """Drive the wire, or let go of it.

        Args:
            driver: who, for example "main.P3".
            level: 0, 1, or None to let go.

        Raises:
            ContentionError: another driver holds the other level.
        """
        if level is None:
            self._drivers.pop(driver, None)
        else:
            for other, held in self._drivers.items():
                if held != level and other != driver:
                    raise ContentionError(
                        f"{self.name}: {driver} drives {level}, {other} drives {held}; "
                        "take one of them off the wire, or put a resistor between"
                    )
            self._drivers[driver] = level
        new = next(iter(self._drivers.values())) if self._drivers else self.pull
        if new != self.level:
            self.level = new
            for listener in tuple(self._listeners):
                listener(new)

    def listen(self, listener: Listener) -> Callable[[], None]:
        """Tell `listener` every change; returns how to stop that."""
        self._listeners.append(listener)
        return lambda: self._listeners.remove(listener)

    @property
    def drivers(self) -> tuple[str, ...]:
        """Who drives it now."""
        return tuple(self._drivers)
