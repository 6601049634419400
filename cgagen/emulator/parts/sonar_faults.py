"""Faults of sonars: an echo that never comes, or comes late."""

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
