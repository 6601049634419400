"""Faults of sonars: an echo that never comes, comes late, or is always that of something near."""

from cgagen.emulator.clock import Clock
from cgagen.emulator.parts.fault import Fault
from cgagen.emulator.parts.sonar import Answer, Sonar


class NoEcho(Fault):
    """The sonar stays silent when it is asked, as a broken one does.

    One that merely sees nothing is no fault: it gives its longest pulse (`Sonar.see(None)`).
    """

    def __init__(
        self,
        name: str,
        clock: Clock,
        sonar: Sonar,
        from_ns: int | None = 0,
        until_ns: int | None = None,
    ) -> None:
        super().__init__(name, clock, from_ns, until_ns)
        sonar.spoilers.append(self)

    def spoil(self, answer: Answer) -> Answer | None:
        """Swallow the answer while the fault is on."""
        if not self.on:
            return answer
        self._fire()
        return None


class LateEcho(Fault):
    """The echo pulse begins later than the data sheet says; its width stays."""

    def __init__(
        self,
        name: str,
        clock: Clock,
        sonar: Sonar,
        late_ns: int,
        from_ns: int | None = 0,
        until_ns: int | None = None,
    ) -> None:
        super().__init__(name, clock, from_ns, until_ns)
        self._late_ns = late_ns
        sonar.spoilers.append(self)

    def spoil(self, answer: Answer) -> Answer | None:
        """Put the answer off while the fault is on."""
        if not self.on:
            return answer
        self._fire()
        return answer._replace(delay_ns=answer.delay_ns + self._late_ns)


class StuckEcho(Fault):
    """The sonar hears something at one distance for ever, unless a real target is nearer.

    Three owners of a PING))) have reported it, all at 14 to 15 cm; its cause is not known.
    Ref: S10 (95609, 101364, 111253): 422 to 428 counts of a BS2.
    """

    def __init__(
        self,
        name: str,
        clock: Clock,
        sonar: Sonar,
        echo_ns: int,
        from_ns: int | None = 0,
        until_ns: int | None = None,
    ) -> None:
        super().__init__(name, clock, from_ns, until_ns)
        self._echo_ns = echo_ns
        sonar.spoilers.append(self)

    def spoil(self, answer: Answer) -> Answer | None:
        """Cut a longer echo short while the fault is on."""
        if not self.on or answer.width_ns <= self._echo_ns:
            return answer
        self._fire()
        return answer._replace(width_ns=self._echo_ns)
