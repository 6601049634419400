"""A probe of a logic analyser: remembers every change of a wire.

Left out: nothing; it does not load the wire. It keeps the newest `limit` edges.
"""

from itertools import pairwise
from typing import Any, NamedTuple

from cgagen.emulator.clock import Clock
from cgagen.emulator.parts.part import Part
from cgagen.emulator.wires import Wire

LIMIT_EDGES = 100_000


class Edge(NamedTuple):
    """A level, 0, 1 or None for floating, from this time on."""

    time_ns: int
    level: int | None


class Pulse(NamedTuple):
    """A level that was there from one edge to the next."""

    start_ns: int
    width_ns: int
    level: int | None


class Probe(Part):
    """Edges of a wire.

    Attributes:
        count: edges seen, also those no longer kept.
    """

    def __init__(self, name: str, clock: Clock, wire: Wire, limit: int = LIMIT_EDGES) -> None:
        super().__init__(name, clock)
        self.count = 0
        self._limit = limit
        self._edges: list[tuple[int, int | None]] = [(clock.now_ns, wire.level)]
        wire.listen(self._changed)

    @property
    def edges(self) -> tuple[Edge, ...]:
        """What is kept; the first is the level that the probe found."""
        return tuple(Edge(*edge) for edge in self._edges)

    def pulses(self, level: int = 1) -> tuple[Pulse, ...]:
        """Return the pulses of a level that have ended."""
        return tuple(
            Pulse(now.time_ns, then.time_ns - now.time_ns, now.level)
            for now, then in pairwise(self.edges)
            if now.level == level
        )

    def told(self) -> dict[str, Any]:
        """See `Part.told`."""
        return {"edges": self.count}

    def _changed(self, level: int | None) -> None:
        self.count += 1
        if len(self._edges) >= 2 * self._limit:
            del self._edges[: self._limit]
        self._edges.append((self.clock.now_ns, level))
