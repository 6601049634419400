"""What all parts have in common: a name, a clock, and a state that can be put back."""

import copy
from typing import Any, ClassVar

from cgagen.emulator.clock import Action, Booking, Clock, Timer

_DATA = (int, float, str, bytes, bytearray, tuple, frozenset, list, dict, type(None))

_FIXED = frozenset({int, bool, float, str, bytes, type(None)})

PartState = tuple[dict[str, Any], tuple[Booking | None, ...], tuple[str, ...]]
"""Data, bookings, and which of the data could be changed in place, so that a copy is given."""


class Part:
    """A circuit on wires.

    Everything that a part keeps in plain attributes (numbers, texts, tuples, lists and
    dictionaries of such) is its state, and everything that it books it books through `timer`;
    so a bench can go back to an earlier moment. All else is its circuit and stays, and so do the
    attributes that a class names in `CIRCUIT`.

    Args:
        name: as the bench calls it.
        clock: the bench's.
    """

    CIRCUIT: ClassVar[frozenset[str]] = frozenset()

    def __init__(self, name: str, clock: Clock) -> None:
        self.name = name
        self.clock = clock
        self._timers: tuple[Timer, ...] = ()

    def timer(self, action: Action) -> Timer:
        """Return a timer that belongs to this part."""
        made = Timer(self.clock, action)
        self._timers += (made,)
        return made

    def told(self) -> dict[str, Any]:
        """Return what it has seen, by names for JSON; nothing where that is no news."""
        return {}

    def state(self) -> PartState:
        """Return what `restore` needs, as a value of its own."""
        data = {
            key: copy.deepcopy(value)
            for key, value in vars(self).items()
            if key != "_timers" and key not in self.CIRCUIT and not _is_circuit(value)
        }
        loose = tuple(key for key, value in data.items() if type(value) not in _FIXED)
        return data, tuple(timer.state() for timer in self._timers), loose

    def restore(self, state: PartState) -> None:
        """Go back to a state; the clock has been restored before."""
        data, bookings, loose = state
        mine = vars(self)
        mine.update(data)
        for key in loose:
            mine[key] = copy.deepcopy(data[key])
        for timer, booking in zip(self._timers, bookings, strict=True):
            timer.restore(booking)

    def bookings(self) -> list[Booking]:
        """Return what this part has booked now."""
        states = (timer.state() for timer in self._timers)
        return [state for state in states if state is not None]


def _is_circuit(value: object) -> bool:
    """Say whether a tuple, list or dictionary holds wires, parts and the like, not data."""
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, tuple | list | frozenset):
        return any(_is_circuit(one) for one in value)
    return not isinstance(value, _DATA)
