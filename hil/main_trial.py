"""A main controller on trial: all its sensors forced, and ears on its pins."""

from collections.abc import Callable

from cgagen.emulator.chip import Chip, Coverage
from cgagen.errors import LackingError
from cgagen.stamp.image import Image
from hil.forced import ForcedSensors
from hil.roster import check_reading
from hil.subject import Subject
from hil.target import Stimulus
from hil.trial import Trial

FAST_UNIT_NS = 1_000


class MainTrial(Trial):
    """A main controller with all its sensors forced, and ears on its pins.

    Attributes:
        edges: time, pin and level of all that has changed on the sensors' pins.
        touched: told of each of its lines that it drives to another level; None for nobody.
        number: of its next decision, as telemetry says it.
        lacks: what could not be tried, since the program lacks what it is tried by.
    """

    def __init__(self, subject: Subject, image: Image, coverage: Coverage | None = None) -> None:
        super().__init__(subject, "main", image, coverage)
        robot, bench = subject.robot, self.bench
        self.image = image
        self._sensors = ForcedSensors(robot, bench)
        self.edges: list[tuple[int, int, int | None]] = []
        self.touched: Callable[[int], None] | None = None
        self.number = 0
        self.lacks: list[LackingError] = []
        sensors = [pin for sonar in robot.sonars for pin in sonar.pins]
        sensors += [one.pin for one in robot.light.sensors] if robot.light else []
        for pin in sensors:
            bench.end(f"main.P{pin}").listen(self._listener(pin))
        self.shown: Stimulus | None = None
        self.asked_ns: int | None = None
        """When a sonar was triggered last, in whichever look."""
        self.first_pin = robot.sonars[0].pins[0]
        line = robot.link.step_line
        self.step_bit = 1 << line.main_pin if line else 0
        self.line_bits = sum(1 << pin for pin in robot.link.main_pins)
        for pin in (pin for pin in range(16) if (self.line_bits | self.step_bit) >> pin & 1):
            bench.end(f"main.P{pin}").listen(self._line_listener(pin))

    def _listener(self, pin: int) -> Callable[[int | None], None]:
        def changed(level: int | None) -> None:
            self.edges.append((self.now_ns, pin, level))
            if level == 1 and pin == self.first_pin and self.drives >> pin & 1:
                self.event("look")

        return changed

    def _line_listener(self, pin: int) -> Callable[[int | None], None]:
        def changed(_level: int | None) -> None:
            if self.touched is not None and self.drives >> pin & 1:
                self.touched(pin)

        return changed

    @property
    def fast(self) -> bool:
        """Whether the chip is one that computes fast: those count in units of less than 1 us."""
        return self.robot.main.pulsout_unit_ns < FAST_UNIT_NS

    @property
    def drives(self) -> int:
        """Pins that are outputs."""
        return self.chip.pins.directions

    @property
    def drives_all(self) -> bool:
        """Whether all command lines are outputs."""
        return self.drives & self.line_bits == self.line_bits

    @property
    def shown_bright(self) -> bool:
        """Whether both light sensors are lit by what is presented."""
        if self.shown is None or not self.shown.lights:
            return False
        counts = self.robot.situation_counts
        ranges = (counts.lamp_left.range, counts.lamp_right.range)
        return all(0 < n < most for n, most in zip(self.shown.lights, ranges, strict=True))

    def lines(self) -> int:
        """Return the command that is on the wires."""
        return sum((self.bench.wire(f"command_{bit}").level or 0) << bit for bit in range(3))

    def present(self, stimulus: Stimulus) -> None:
        """Put this in front of the sensors. Raises ReadingError."""
        check_reading(stimulus, self.subject.robot)
        self.shown = stimulus
        self._sensors.show(stimulus)

    def wait_decided(self, limit_ms: float) -> bool:
        """Go on until it has told a decision: by GO, or by driving all lines where there is none.

        Returns:
            Whether it has in time.
        """
        if self.has_step:
            return self.wait("step 0", limit_ms)

        def look(_chip: Chip) -> None:
            if self.drives_all:
                self.event("driven")

        remove = self.chip.on_instruction(look)
        try:
            return self.wait("driven", limit_ms)
        finally:
            remove()


def levels(stimulus: Stimulus) -> int:
    """Return the antennas' pin levels: bit 0 left, bit 1 right, 1 is free."""
    return (not stimulus.touched[0]) | (not stimulus.touched[1]) << 1
