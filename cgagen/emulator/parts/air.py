"""The air between sonars: what comes back of a burst is heard by whoever listens.

A sonar's echo ends with the first that comes back; what stands behind or beside the target sends
more, and later. A sonar that listens then takes it for its own. An air is the room of one robot's
sonars, or of several robots'.

Left out: directions, loudness, and that a sonar's own echo is heard by the others, too: whoever
asks one sonar at a time has heard it before.
"""

from collections.abc import Sequence
from typing import Any

from cgagen.emulator.clock import Clock
from cgagen.emulator.parts.part import Part
from cgagen.emulator.parts.sonar import US_PER_IN, Sonar


class Air(Part):
    """What the bursts of its sonars come back from, besides each one's own target.

    Args:
        name: as the bench calls it.
        clock: the bench's.
        sonars: that hear one another.

    Attributes:
        strays: echoes that another's burst has ended.
    """

    CIRCUIT = frozenset({"_sonars"})

    def __init__(self, name: str, clock: Clock, sonars: Sequence[Sonar]) -> None:
        super().__init__(name, clock)
        self.strays = 0
        self._late_ns: tuple[int, ...] = ()
        self._bursts: tuple[tuple[int, str], ...] = ()
        self._sonars = tuple(sonars)
        for sonar in sonars:
            sonar.air = self

    def told(self) -> dict[str, Any]:
        """See `Part.told`."""
        return {"strays": self.strays} if self.strays else {}

    def see(self, *distances_in: float) -> None:
        """Put walls at these distances, for every burst; none for an open field."""
        self.see_echoes(*(round(2_000 * one * US_PER_IN) for one in distances_in))

    def see_echoes(self, *late_ns: int) -> None:
        """Say likewise how long after its burst the sound comes back."""
        self._late_ns = tuple(sorted(late_ns))

    def burst(self, sonar: str, begins_ns: int) -> None:
        """A sonar is going to send, and begins its own echo pulse then."""
        if not self._late_ns:
            return
        gone_ns = self.clock.now_ns - self._late_ns[-1]
        kept = tuple(one for one in self._bursts if one[0] >= gone_ns)
        self._bursts = (*kept, (begins_ns, sonar))
        for one in self._sonars:
            one.listen_again()

    def comes_ns(self, sonar: str, began_ns: int) -> int | None:
        """Return when the next sound comes to a sonar that has listened since a time.

        What its own burst brings back is no stray: its own echo says that.
        """
        now_ns = self.clock.now_ns
        mine = (began_ns, sonar)
        return min(
            (
                burst[0] + late_ns
                for burst in self._bursts
                if burst != mine
                for late_ns in self._late_ns
                if burst[0] + late_ns >= now_ns
            ),
            default=None,
        )
