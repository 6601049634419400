"""What every sonar has: something in front of it, an echo, and a way to spoil that.

Which way the sound goes, what it meets and how strong it comes back is not the part's business:
whoever owns the world says how long the echo is.
"""

from typing import Any, NamedTuple, Protocol

from cgagen.emulator.clock import Clock
from cgagen.emulator.parts.part import Part

US_PER_IN = 73.746
"""One way, at 22 C. Ref: S6."""


class Answer(NamedTuple):
    """The echo pulse that a sonar is going to give: a delay from now, and a width."""

    delay_ns: int
    width_ns: int


class Spoiler(Protocol):
    """A fault of a sonar."""

    def spoil(self, answer: Answer) -> Answer | None:
        """Return the answer that comes instead; None for none at all."""
        ...


class Sonar(Part):
    """The distance and the faults of a sonar.

    Args:
        name: as the bench calls it.
        clock: the bench's.
        shortest_ns: echo pulse of the nearest target.
        longest_ns: echo pulse without a target.
    """

    CIRCUIT = frozenset({"spoilers"})

    def __init__(self, name: str, clock: Clock, shortest_ns: int, longest_ns: int) -> None:
        super().__init__(name, clock)
        self.triggers = 0
        """Triggers that were answered."""
        self.ignored = 0
        """Triggers that were too short or came too early."""
        self.spoilers: list[Spoiler] = []
        self._shortest_ns = shortest_ns
        self._longest_ns = longest_ns
        self._echo_ns = longest_ns

    def see(self, distance_in: float | None, us_per_in: float = US_PER_IN) -> None:
        """Put a target at a distance, or take it away with None."""
        if distance_in is None:
            self.see_echo(None)
        else:
            self.see_echo(round(2_000 * distance_in * us_per_in))

    def see_echo(self, echo_ns: int | None) -> None:
        """Say how long the next echo pulse is; it keeps within what the part can do."""
        wanted = self._longest_ns if echo_ns is None else echo_ns
        self._echo_ns = min(max(wanted, self._shortest_ns), self._longest_ns)

    def told(self) -> dict[str, Any]:
        """See `Part.told`."""
        return {"triggers": self.triggers, "ignored": self.ignored}

    def _answer(self, delay_ns: int) -> Answer | None:
        """Return what comes of a trigger now."""
        self.triggers += 1
        answer: Answer | None = Answer(delay_ns, self._echo_ns)
        for spoiler in self.spoilers:
            if answer is not None:
                answer = spoiler.spoil(answer)
        return answer


def middle_ns(count: int, unit_ns: int) -> int:
    """Return a duration in the middle of a count, so that no rounding decides what is counted.

    >>> middle_ns(1843, 800)
    1474800
    """
    return count * unit_ns + unit_ns // 2
