"""The PING))) of Parallax (#28015): trigger and echo on one pin. Ref: S6 p. 1, 2 for all numbers.

A pulse of at least 2 us on SIG; 750 us after its end, a pulse that is as long as the sound is on
its way, or 20 ms where nothing is heard; 200 us later it can be asked again.

Left out: the burst itself, temperature, angles, what a target is made of, and the current (35 mA).
What sonars hear of one another is the business of `Air`.
"""

from cgagen.emulator.clock import Clock
from cgagen.emulator.parts.sonar import Answer, Sonar
from cgagen.emulator.wires import Strength, Wire

TRIGGER_NS = 2_000
HOLD_OFF_NS = 750_000
SHORTEST_NS = 115_000
LONGEST_NS = 18_500_000
SILENCE_NS = 20_000_000
"""Without a target. Ref: measured, S10 (119926): 19.98 ms at 28 C to 20.01 ms at 34 C, one sensor;
S6 names no other time than `LONGEST_NS`."""
REST_NS = 200_000


class Ping(Sonar):
    """A PING))).

    SIG is low while it does not answer (through its own resistor: choice; the data sheet shows
    the line low). While it answers it drives the line like any output: a program that still
    drives SIG low then is a short circuit and ends as one.

    Args:
        name: as the bench calls it.
        clock: the bench's.
        signal: the wire on SIG.

    >>> clock, wire = Clock(), Wire("sig")
    >>> ping = Ping("front", clock, wire); ping.see(10)
    >>> wire.drive("main.P4", 1); clock.run_until(5_000); wire.drive("main.P4", 0)
    >>> wire.drive("main.P4", None); clock.run_until(755_000); wire.level
    1
    >>> clock.run_until(755_000 + 1_474_920); wire.level
    0
    """

    def __init__(self, name: str, clock: Clock, signal: Wire) -> None:
        super().__init__(name, clock, SHORTEST_NS, LONGEST_NS, SILENCE_NS)
        self._signal = signal
        self._busy = False
        self._rose_ns: int | None = None
        self._width_ns = 0
        self._begin = self.timer(self._echo_begins)
        self._end = self.timer(self._echo_ends)
        self._rest = self.timer(self._rested)
        signal.drive(name, 0, Strength.PULL)
        signal.listen(self._changed)

    def _changed(self, level: int | None) -> None:
        if level == 1:
            self._rose_ns = None if self._busy else self.clock.now_ns
            self.ignored += self._busy and self._signal.output is not None and not self._answers
        elif level == 0 and self._rose_ns is not None and not self._busy:
            high_ns, self._rose_ns = self.clock.now_ns - self._rose_ns, None
            if high_ns < TRIGGER_NS:
                self.ignored += 1
                return
            answer = self._answer(HOLD_OFF_NS)
            if answer is not None:
                self._start(answer)

    @property
    def _answers(self) -> bool:
        """Whether the part itself drives SIG now."""
        return self._end.state() is not None

    def _start(self, answer: Answer) -> None:
        self._busy = True
        self._width_ns = answer.width_ns
        self._begin.after(answer.delay_ns)

    def _echo_begins(self) -> None:
        self._listen(self._width_ns)
        self._signal.drive(self.name, 1)

    def _echo_ends(self) -> None:
        self._heard()
        self._rest.after(REST_NS)
        self._signal.drive(self.name, 0, Strength.PULL)

    def _rested(self) -> None:
        self._busy = False
