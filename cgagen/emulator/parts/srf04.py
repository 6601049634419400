"""The SRF04 of Devantech: trigger and echo on pins of their own. Ref: S8 for the numbers below.

A pulse of at least 10 us on TRIGGER; after its falling edge, eight cycles at 40 kHz and a
blanking time; then ECHO is high as long as the sound is on its way, or 36 ms without a target.

Left out: the burst itself, temperature, angles, what a target is made of, and the current (50 mA).
What sonars hear of one another is the business of `Air`.
"""

from cgagen.emulator.clock import Clock
from cgagen.emulator.parts.sonar import Sonar
from cgagen.emulator.wires import Wire

TRIGGER_NS = 10_000
BURST_NS = 200_000
"""Eight cycles of 40 kHz."""
BLANKING_NS = 100_000
MODE_NS = 300_000
"""More before the echo when the mode pin is grounded. Ref: S8 p. 6; parts made since April 2003."""
SHORTEST_NS = 174_000
"""3 cm, at the 58 us that S8 reckons for each, there and back."""
LONGEST_NS = 36_000_000
REST_NS = 10_000_000
"""Before the next trigger. Ref: choice, S8 names 10 ms; earlier triggers are ignored here."""


class Srf04(Sonar):
    """An SRF04.

    Args:
        name: as the bench calls it.
        clock: the bench's.
        trigger: the wire on its trigger input.
        echo: the wire on its echo output, which it always drives.
        mode_grounded: the mode pin is on ground, so that a slow chip sees the echo begin; the
            range stays. Otherwise it is left open.
    """

    def __init__(
        self, name: str, clock: Clock, trigger: Wire, echo: Wire, mode_grounded: bool = False
    ) -> None:
        super().__init__(name, clock, SHORTEST_NS, LONGEST_NS)
        self._delay_ns = BURST_NS + BLANKING_NS + (MODE_NS if mode_grounded else 0)
        self._echo = echo
        self._busy = False
        self._rose_ns: int | None = None
        self._width_ns = 0
        self._begin = self.timer(self._echo_begins)
        self._end = self.timer(self._echo_ends)
        self._rest = self.timer(self._rested)
        echo.drive(name, 0)
        trigger.listen(self._changed)

    def _changed(self, level: int | None) -> None:
        if level == 1:
            self._rose_ns = self.clock.now_ns
            return
        if self._rose_ns is None:
            return
        high_ns, self._rose_ns = self.clock.now_ns - self._rose_ns, None
        if self._busy or high_ns < TRIGGER_NS:
            self.ignored += 1
            return
        answer = self._answer(self._delay_ns)
        if answer is not None:
            self._busy = True
            self._width_ns = answer.width_ns
            self._begin.after(answer.delay_ns)

    def _echo_begins(self) -> None:
        self._listen(self._width_ns)
        self._echo.drive(self.name, 1)

    def _echo_ends(self) -> None:
        self._heard()
        self._rest.after(REST_NS)
        self._echo.drive(self.name, 0)

    def _rested(self) -> None:
        self._busy = False
