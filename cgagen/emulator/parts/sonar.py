"""What every sonar has: something in front of it, an echo, and a way to spoil that.

Which way the sound goes, what it meets and how strong it comes back is not the part's business:
whoever owns the world says how long the echo is.
"""

from typing import Any, NamedTuple, Protocol

from cgagen.emulator.clock import Clock, Timer
from cgagen.emulator.parts.part import Part

US_PER_IN = 73.746
"""One way, at 22 C. Ref: S6."""

DRIFT_STEPS = 7
"""Silences until a drift is through. Choice."""


class Answer(NamedTuple):
    """The echo pulse that a sonar is going to give: a delay from now, and a width."""

    delay_ns: int
    width_ns: int


class Spoiler(Protocol):
    """A fault of a sonar."""

    def spoil(self, answer: Answer) -> Answer | None:
        """Return the answer that comes instead; None for none at all."""
        ...


class Sound(Protocol):
    """What a sonar has to do with the air that it shares with others."""

    strays: int

    def burst(self, sonar: str, begins_ns: int) -> None:
        """Take note of a burst of a sonar, whose echo pulse begins then."""
        ...

    def comes_ns(self, sonar: str, began_ns: int) -> int | None:
        """Return when the next sound of others comes to a sonar that listens since a time."""
        ...


class Sonar(Part):
    """The distance and the faults of a sonar.

    Args:
        name: as the bench calls it.
        clock: the bench's.
        shortest_ns: echo pulse of the nearest target.
        longest_ns: echo pulse of the farthest one.
        silence_ns: pulse when nothing is heard; as long as `longest_ns` unless it is said.

    Attributes:
        drift_ns: by how much the pulse of a silence wanders: its next `DRIFT_STEPS` are each a
            step longer, and then it begins anew.
    """

    CIRCUIT = frozenset({"spoilers", "air"})

    _end: Timer
    """Booked while the echo pulse lasts."""

    def __init__(
        self,
        name: str,
        clock: Clock,
        shortest_ns: int,
        longest_ns: int,
        silence_ns: int | None = None,
    ) -> None:
        super().__init__(name, clock)
        self.triggers = 0
        """Triggers that were answered."""
        self.ignored = 0
        """Triggers that were too short or came too early."""
        self.spoilers: list[Spoiler] = []
        self.air: Sound | None = None
        """That it shares with other sonars; None where it is alone."""
        self._began_ns = 0
        self._own_end_ns = 0
        self._shortest_ns = shortest_ns
        self._longest_ns = longest_ns
        self._silence_ns = longest_ns if silence_ns is None else silence_ns
        self._echo_ns: int | None = None
        self._silences = 0
        self.drift_ns = 0

    def see(self, distance_in: float | None, us_per_in: float = US_PER_IN) -> None:
        """Put a target at a distance, or take it away with None; one too far is not heard."""
        echo_ns = None if distance_in is None else round(2_000 * distance_in * us_per_in)
        self.see_echo(None if echo_ns is None or echo_ns > self._longest_ns else echo_ns)

    def see_echo(self, echo_ns: int | None) -> None:
        """Say how long the next echo pulse is; it keeps within what the part can do.

        Args:
            echo_ns: None where nothing is heard.
        """
        if echo_ns is not None:
            echo_ns = min(max(echo_ns, self._shortest_ns), self._longest_ns)
        self._echo_ns = echo_ns

    def hear_nothing(self, silence_ns: int, drift_ns: int = 0) -> None:
        """Say how long the pulse of a silence is, and by how much it wanders."""
        self._silence_ns, self.drift_ns = silence_ns, drift_ns

    def told(self) -> dict[str, Any]:
        """See `Part.told`."""
        return {"triggers": self.triggers, "ignored": self.ignored}

    def _answer(self, delay_ns: int) -> Answer | None:
        """Return what comes of a trigger now."""
        self.triggers += 1
        answer: Answer | None = Answer(delay_ns, self._width())
        for spoiler in self.spoilers:
            if answer is not None:
                answer = spoiler.spoil(answer)
        if answer is not None and self.air is not None:
            self.air.burst(self.name, self.clock.now_ns + answer.delay_ns)
        return answer

    def _width(self) -> int:
        if self._echo_ns is not None:
            return self._echo_ns
        step, self._silences = self._silences % (DRIFT_STEPS + 1), self._silences + 1
        return self._silence_ns + self.drift_ns * step // DRIFT_STEPS

    def _listen(self, width_ns: int) -> None:
        """The echo pulse begins; it ends with the first sound that comes, whosever it is."""
        self._began_ns = self.clock.now_ns
        self._own_end_ns = self._began_ns + width_ns
        self._end.at(self._own_end_ns)
        self.listen_again()

    def listen_again(self) -> None:
        """Somebody has sent: his sound may come before one's own."""
        booked = self._end.state()
        if self.air is None or booked is None:
            return
        comes_ns = self.air.comes_ns(self.name, self._began_ns)
        if comes_ns is not None:
            self._end.at(min(booked[0], max(comes_ns, self._began_ns + self._shortest_ns)))

    def _heard(self) -> None:
        """The echo pulse has ended."""
        if self.air is not None and self.clock.now_ns < self._own_end_ns:
            self.air.strays += 1


def middle_ns(count: int, unit_ns: int) -> int:
    """Return a duration in the middle of a count, so that no rounding decides what is counted.

    >>> middle_ns(1843, 800)
    1474800
    """
    return count * unit_ns + unit_ns // 2
