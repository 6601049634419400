"""Faults: what goes wrong on purpose, and whether it did.

A fault is a part. It is on from the beginning, from a time on, or when it is switched; it counts
how often it made a difference, so that a test that survives a fault knows that there was one.
"""

from collections.abc import Callable, Mapping
from typing import Any

from cgagen.emulator.clock import Clock
from cgagen.emulator.parts.part import Part


class Fault(Part):
    """A fault that can be switched on and off.

    Args:
        name: as the bench calls it.
        clock: the bench's.
        from_ns: when it comes; None for when `switch` says so.
        until_ns: when it goes; None for never.

    Attributes:
        on: whether it is there now.
        fired: how often it made a difference.
        first_ns: when it did for the first time; None for not yet.
    """

    def __init__(
        self, name: str, clock: Clock, from_ns: int | None = 0, until_ns: int | None = None
    ) -> None:
        super().__init__(name, clock)
        self.on = False
        self.fired = 0
        self.first_ns: int | None = None
        self._comes = self.timer(lambda: self.switch(True))
        self._goes = self.timer(lambda: self.switch(False))
        if from_ns is not None:
            self._comes.at(max(from_ns, clock.now_ns))
        if until_ns is not None:
            self._goes.at(until_ns)

    def switch(self, on: bool) -> None:
        """Make it come or go."""
        if on != self.on:
            self.on = on
            if on:
                self._begin()
            else:
                self._end()

    def told(self) -> dict[str, Any]:
        """See `Part.told`."""
        return {"fired": self.fired, "first_ns": self.first_ns}

    def _begin(self) -> None:
        """Do what the fault does when it comes."""

    def _end(self) -> None:
        """Undo it."""

    def _fire(self) -> None:
        self.fired += 1
        if self.first_ns is None:
            self.first_ns = self.clock.now_ns


class BrownOut(Fault):
    """The supply of some chips breaks down: they are off while it lasts, and start anew.

    Args:
        name: as the bench calls it.
        clock: the bench's.
        power: called for each of its chips with False and, at the end, with True.
        from_ns: when.
        until_ns: until when; None for as long as nobody switches it off.
    """

    def __init__(
        self,
        name: str,
        clock: Clock,
        power: Callable[[bool], None],
        from_ns: int | None = None,
        until_ns: int | None = None,
    ) -> None:
        self._power = power
        super().__init__(name, clock, from_ns, until_ns)

    def _begin(self) -> None:
        self._fire()
        self._power(False)

    def _end(self) -> None:
        self._power(True)


def fault_notes(faults: Mapping[str, Fault]) -> list[str]:
    """Return a sentence for each: whether it has made a difference, how often, and since when.

    >>> fault_notes({"silence": Fault("silence", Clock())})
    ['fault silence: made no difference in this run']
    """
    notes = []
    for name, fault in faults.items():
        if fault.first_ns is None:
            notes.append(f"fault {name}: made no difference in this run")
        else:
            times = "once" if fault.fired == 1 else f"{fault.fired} times, first"
            notes.append(f"fault {name}: made a difference {times} at {fault.first_ns / 1e9:.6f} s")
    return notes
