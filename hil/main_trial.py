"""A main controller on trial: all its sensors forced, and ears on its pins."""

from collections.abc import Callable

from cgagen.emulator.chip import Coverage
from cgagen.emulator.parts.photocell import Photocell
from cgagen.emulator.parts.sonar import Sonar, middle_ns
from cgagen.emulator.parts.whisker import Whisker
from cgagen.stamp.image import Image
from hil.forced import Forced
from hil.subject import Subject
from hil.target import Stimulus
from hil.trial import Trial


class MainTrial(Trial):
    """A main controller with all its sensors forced, and ears on its pins."""

    def __init__(self, subject: Subject, image: Image, coverage: Coverage | None = None) -> None:
        super().__init__(subject, "main", image, coverage)
        robot, bench = subject.robot, self.bench
        sonars = bench.parts_of(Sonar)
        self._forced = [Forced() for _ in robot.sonars]
        for sonar, forced in zip(robot.sonars, self._forced, strict=True):
            sonars[f"sonar_{sonar.name}"].spoilers.append(forced)
        self._whiskers = list(bench.parts_of(Whisker).values())
        self._cells = list(bench.parts_of(Photocell).values())
        self.edges: list[tuple[int, int, int | None]] = []
        sensors = [pin for sonar in robot.sonars for pin in sonar.pins]
        sensors += [one.pin for one in robot.light.sensors] if robot.light else []
        for pin in sensors:
            bench.end(f"main.P{pin}").listen(self._listener(pin))
        self.first_pin = robot.sonars[0].pins[0]
        line = robot.link.step_line
        self.step_bit = 1 << (line.main_pin if line else 0)
        self.line_bits = sum(1 << pin for pin in robot.link.main_pins)

    def _listener(self, pin: int) -> Callable[[int | None], None]:
        def changed(level: int | None) -> None:
            self.edges.append((self.now_ns, pin, level))
            if level == 1:
                self.event("look" if pin == self.first_pin else "")

        return changed

    @property
    def drives(self) -> int:
        """Pins that are outputs."""
        return self.chip.pins.directions

    def lines(self) -> int:
        """Return the command that is on the wires."""
        return sum((self.bench.wire(f"command_{bit}").level or 0) << bit for bit in range(3))

    def present(self, stimulus: Stimulus) -> None:
        """Put this in front of the sensors."""
        main = self.robot.main
        for forced, one in zip(self._forced, stimulus.sonars, strict=True):
            forced.width_ns = middle_ns(one, main.pulsin_unit_ns) if one else None
        for whisker, bent in zip(self._whiskers, stimulus.touched, strict=True):
            whisker.touch(bent)
        for cell, one in zip(self._cells, stimulus.lights, strict=True):
            cell.drain(middle_ns(one, main.rctime_unit_ns) if one else None)


def levels(stimulus: Stimulus) -> int:
    """Return the antennas' pin levels: bit 0 left, bit 1 right, 1 is free."""
    return (not stimulus.touched[0]) | (not stimulus.touched[1]) << 1
