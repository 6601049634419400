"""A hobby servo: the width of a pulse is an angle. Ref: S10 for pulses and the 50 ms.

It turns towards the angle of the last pulse at its speed, holds it, and goes limp when pulses
stay away.

Left out: load, overshoot, dead band, current, and the way a servo sags when it is limp.
"""

from typing import Any, NamedTuple

from cgagen.emulator.clock import NEVER_NS, Clock
from cgagen.emulator.parts.part import Part
from cgagen.emulator.wires import Wire

CENTRE_NS = 1_500_000
NS_PER_DEG = 10_000
"""Ref: choice; 1 ms for some 90 degrees is what most hobby servos do."""
LEAST_NS, MOST_NS = 900_000, 2_100_000
"""Wider than S10's 1 to 2 ms by what a servo still follows; its end stops. Choice."""
SHORTEST_NS, LONGEST_NS = 500_000, 2_500_000
"""Pulses outside of this are none. Choice."""
NS_PER_TURNED_DEG = 0.2e9 / 60
"""60 degrees in 0.2 s. Ref: choice; the robot files reckon with the same speed."""
LIMP_NS = 50_000_000


class Pulses(NamedTuple):
    """What a servo has seen since it was made, or since `forget`.

    Attributes:
        taken: pulses that it took.
        odd: pulses that were too short or too long to be any.
        shortest_ns: width, likewise the next.
        longest_ns: see there.
        shortest_period_ns: from one rising edge to the next; `NEVER_NS` before two pulses.
        longest_period_ns: likewise; 0 before two pulses.
        limp: how often it went limp after it had been held.
    """

    taken: int
    odd: int
    shortest_ns: int
    longest_ns: int
    shortest_period_ns: int
    longest_period_ns: int
    limp: int

    @property
    def jitter_ns(self) -> int:
        """How much the period varies."""
        return max(self.longest_period_ns - self.shortest_period_ns, 0)


class Servo(Part):
    """One servo. It books nothing: where it stands follows from the pulses.

    Args:
        name: as the bench calls it.
        clock: the bench's.
        signal: the wire on its control input.
        ns_per_deg: of pulse width; negative where a longer pulse turns to negative angles.
        ns_per_turned_deg: speed.
        angle_deg: where it stands before the first pulse.
        centre_ns: pulse width at 0 degrees.
    """

    def __init__(
        self,
        name: str,
        clock: Clock,
        signal: Wire,
        ns_per_deg: float = NS_PER_DEG,
        ns_per_turned_deg: float = NS_PER_TURNED_DEG,
        angle_deg: float = 0.0,
        centre_ns: int = CENTRE_NS,
    ) -> None:
        super().__init__(name, clock)
        self._centre_ns = centre_ns
        self._ns_per_deg = ns_per_deg
        self._ns_per_turned_deg = ns_per_turned_deg
        self._from_deg = self._target_deg = angle_deg
        self._from_ns = clock.now_ns
        self._rose_ns: int | None = None
        self._before_ns: int | None = None
        self._width_ns: int | None = None
        self._held_until_ns = 0
        self.forget()
        signal.listen(self._changed, self._fallen)

    @property
    def angle_deg(self) -> float:
        """Where it stands now; 0 is the centre."""
        turns_ns = min(self.clock.now_ns, self._held_until_ns) - self._from_ns
        way = max(turns_ns, 0) / self._ns_per_turned_deg
        distance = self._target_deg - self._from_deg
        if abs(distance) <= way:
            return self._target_deg
        return self._from_deg + (way if distance > 0 else -way)

    @property
    def target_deg(self) -> float:
        """Where the last pulse sent it."""
        return self._target_deg

    @property
    def limp(self) -> bool:
        """Whether nothing holds it: no pulse for 50 ms, or none yet."""
        return self.clock.now_ns >= self._held_until_ns

    @property
    def width_ns(self) -> int | None:
        """Width of the last pulse; None before the first."""
        return self._width_ns

    @property
    def pulses(self) -> Pulses:
        """What it has seen."""
        return Pulses(
            self._taken,
            self._odd,
            self._shortest_ns,
            self._longest_ns,
            self._shortest_period_ns,
            self._longest_period_ns,
            self._limp,
        )

    def told(self) -> dict[str, Any]:
        """See `Part.told`."""
        seen = self.pulses
        return {
            "angle_deg": round(self.angle_deg, 3),
            "limp": self.limp,
            "pulses": seen.taken,
            "shortest_ns": seen.shortest_ns if seen.taken else None,
            "longest_ns": seen.longest_ns if seen.taken else None,
            "odd": seen.odd,
        }

    def forget(self) -> None:
        """Begin the counts and extremes anew."""
        self._taken = self._odd = self._limp = 0
        self._shortest_ns = self._shortest_period_ns = NEVER_NS
        self._longest_ns = self._longest_period_ns = 0

    def _changed(self, level: int | None) -> None:
        if level == 1:
            self._rose_ns = self.clock.now_ns
        elif self._rose_ns is not None:
            self._fallen(self._rose_ns)

    def _fallen(self, began_ns: int) -> None:
        """A pulse has ended. A robot has 600 of them a second: equal ones cost less."""
        self._rose_ns = None
        now_ns = self.clock.now_ns
        width_ns = now_ns - began_ns
        if width_ns < SHORTEST_NS or width_ns > LONGEST_NS:
            self._odd += 1
            return
        if self._before_ns is not None and self._taken:
            period_ns = began_ns - self._before_ns
            if not self._shortest_period_ns <= period_ns <= self._longest_period_ns:
                self._shortest_period_ns = min(self._shortest_period_ns, period_ns)
                self._longest_period_ns = max(self._longest_period_ns, period_ns)
            if now_ns > self._held_until_ns:
                self._limp += 1
        self._before_ns = began_ns
        if self._from_deg != self._target_deg:
            self._from_deg = self.angle_deg
        self._from_ns = now_ns
        if width_ns != self._width_ns or not self._taken:
            self._width_ns = width_ns
            self._shortest_ns = min(self._shortest_ns, width_ns)
            self._longest_ns = max(self._longest_ns, width_ns)
            kept_ns = min(max(width_ns, LEAST_NS), MOST_NS)
            self._target_deg = (kept_ns - self._centre_ns) / self._ns_per_deg
        self._taken += 1
        self._held_until_ns = now_ns + LIMP_NS
