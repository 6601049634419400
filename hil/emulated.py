"""The robot's own images on the emulator: a bench with both Stamps, all sensors and servos.

The main controller hunts: every count reaches it as a pulse, a contact or an RC time on its pins,
and its command is read from the wires when it says GO. `hil.registers` is the fast way.
"""

from collections.abc import Sequence
from itertools import count

from cgagen.bench_protocol import END, FAULT
from cgagen.build.bench import bench_text
from cgagen.closing import Closing
from cgagen.emulator.bench import Bench, BenchState
from cgagen.emulator.bench_file import parse_bench
from cgagen.emulator.parts.sonar import Sonar
from cgagen.errors import (
    CgagenError,
    ContentionError,
    ExecutionError,
    MismatchError,
    RigError,
    TargetTimeout,
)
from cgagen.robot import Robot
from cgagen.stamp.image import Image
from cgagen.temporaries import temporary_folder
from hil.benches import show
from hil.forced import ForcedSensors
from hil.roster import check_reading, check_senses
from hil.subject import CHIPS, Subject
from hil.target import (
    COUNTS,
    IMAGE,
    LATENCY,
    PINS,
    STATE,
    Identity,
    Observation,
    Stimulus,
)
from hil.telemetry import Told, parse_telemetry

MOST_SONAR_COUNTS = 65_534
"""The longest echo that PULSIN can measure; 65,535 reaches the classifier as registers only."""

FIRST_LIMIT_NS = 10_000_000_000
"""How long a robot may take from power-up to its first look. Choice: four times what it takes."""

DECISION_LIMIT_NS = 3_000_000_000
"""How long one decision may take. Choice: ten times what the slowest chip takes."""

LEAD_NS = 1_000_000
"""How long before the first trigger the sensors are set."""


BROKEN = (ExecutionError, ContentionError)
"""What a program does that no chip can: it is wrong, and the bench is well."""


def robot_bench(robot: Robot, images: dict[str, Image]) -> Bench:
    """Return the bench of a robot with these images in its chips."""
    with temporary_folder() as folder:
        for name in CHIPS:
            (folder / f"{name}.bin").write_bytes(images[name].eeprom)
        return show(parse_bench(bench_text(robot), "bench.toml", folder), images)


def stopped(where: str, error: CgagenError) -> RigError:
    """Return what it says that the emulator cannot go on.

    A program that comes to what is no instruction, or shorts two drivers, is broken, as one that
    hangs is: `TargetTimeout`. Everything else is about the bench.
    """
    words = f"{where}: on the emulator: {error}"
    broken = isinstance(error, BROKEN)
    return TargetTimeout(words) if broken else RigError(words)


class PinsTarget(Closing):
    """The emulated robot, with everything through its pins.

    Args:
        subject: what is on trial.
        images: in place of the subject's own.

    Attributes:
        bench: the robot.
    """

    caps = frozenset({STATE, COUNTS, LATENCY, PINS, IMAGE})

    def __init__(self, subject: Subject, images: dict[str, Image] | None = None) -> None:
        self.url = "emulator"
        self.stale = 0
        self.subject = subject
        self.images = images or subject.images
        self.bench = Bench()
        self._seq = count(1)
        self._ready: BenchState | None = None

    def open(self) -> None:
        """Switch the robot on and let it come to the moment before its first look.

        Raises:
            TargetTimeout: it does not look at its sensors, or does what no chip can.
            RigError: the bench cannot be.
        """
        try:
            self._power_up()
        except TargetTimeout:
            raise
        except CgagenError as error:
            raise stopped(self.subject.where, error) from error

    def close(self) -> None:
        """Let the bench go."""
        self._ready = None

    def reset(self) -> None:
        """Switch it off and on."""
        self.open()

    def load(self, image: Image, chip: str = "main") -> None:
        """Put another image into a chip, and switch on."""
        self.images = {**self.images, chip: image}
        self.open()

    def identity(self) -> Identity:
        """Return the banner's words, and the digests of what is in the chips."""
        digests = {name: image.digest for name, image in self.images.items()}
        return Identity(self.subject.robot.name, self.subject.genome_digest, digests)

    def admits(self, stimulus: Stimulus) -> bool:
        """Say whether a stimulus can come through the pins."""
        counts = (*stimulus.sonars, *stimulus.lights)
        return all(one <= MOST_SONAR_COUNTS for one in counts)

    def decide(self, stimulus: Stimulus) -> Observation:
        """Let the robot look, decide and say GO.

        Raises:
            ReadingError: the stimulus is not one of this robot.
            TargetTimeout: it has not decided in three seconds of its own time, or does what no
                chip can.
            MismatchError: its wires say another command than its telemetry.
        """
        self.present(stimulus)
        try:
            seen = self.look()
        except CgagenError as error:
            here = f"{self.subject.where}: at the reading {stimulus.text()}"
            raise stopped(here, error) from error
        if seen is None:
            raise TargetTimeout(
                f"{self.subject.where}: no decision in {DECISION_LIMIT_NS // 1_000_000} ms of the "
                f"robot's time for the reading {stimulus.text()}; it hangs there"
            )
        return self._observed(*seen)

    def look(self) -> tuple[int, int] | None:
        """Let the robot decide on what has been presented.

        Returns:
            Its command and the ns that it took, to GO; None where it does not decide.
        """
        bench = self.bench
        self._line.clear()
        self._go = None
        self._done = False
        began_ns = bench.clock.now_ns + LEAD_NS
        bench.run(began_ns + DECISION_LIMIT_NS)
        if not self._done or self._go is None:
            return None
        command, go_ns = self._go
        return command, go_ns - began_ns

    def told(self) -> Told | None:
        """Return what the robot's telemetry says of its last look; None where it says nothing."""
        return parse_telemetry(self.said, self.subject.role)

    def present(self, stimulus: Stimulus) -> None:
        """Go back to the moment before the first look, with this in front of the sensors."""
        check_reading(stimulus, self.subject.robot)
        self._go_back()
        self._sensors.show(stimulus)

    def present_ns(
        self,
        echoes_ns: Sequence[int | None],
        touched: Sequence[bool],
        drains_ns: Sequence[int | None],
    ) -> None:
        """Likewise, with echoes and RC times as they are; None for no echo, and for dark.

        Raises:
            ReadingError: they are of other sensors.
        """
        check_senses((len(echoes_ns), len(touched), len(drains_ns)), self.subject.robot)
        self._go_back()
        self._sensors.show_ns(echoes_ns, touched, drains_ns)

    def _go_back(self) -> None:
        if self._ready is None:
            raise RigError("the emulated robot is not open; open it first")
        self.bench.restore(self._ready)

    def _observed(self, command: int, latency_ns: int) -> Observation:
        told = self.told()
        if told is None:
            return Observation(next(self._seq), command, latency_ns=latency_ns)
        if told.command != command:
            raise MismatchError(
                f"{self.subject.where}: the command lines say {command} and the telemetry "
                f"{told.command} for the reading {told.stimulus.text()}"
            )
        return Observation(next(self._seq), command, told.state, told.stimulus, latency_ns)

    def equip(self, bench: Bench) -> None:
        """Add what else is to be on the bench; called before it is switched on."""

    @property
    def said(self) -> str:
        """What has come from the main controller since power-up, or since the last look began."""
        return self._line.decode("ascii", "replace")

    def _power_up(self) -> None:
        robot = self.subject.robot
        self.bench = robot_bench(robot, self.images)
        first_ns = self._first_trigger_ns()
        self.bench = bench = robot_bench(robot, self.images)
        self._sensors = ForcedSensors(robot, bench)
        self._line, self._go, self._done = bytearray(), None, True
        self._watch()
        self.equip(bench)
        bench.run(first_ns - LEAD_NS)
        self._ready = bench.snapshot()

    def _first_trigger_ns(self) -> int:
        """Return when the robot first asks a sonar."""
        bench, sonars = self.bench, list(self.bench.parts_of(Sonar).values())
        main = bench.chip("main")

        def look() -> None:
            if sonars[0].triggers:
                bench.clock.stop()

        pin = self.subject.robot.sonars[0].pins[0]
        main.on_pin(pin, lambda level: bench.clock.stop() if level == 1 else look())
        bench.run(FIRST_LIMIT_NS)
        if bench.clock.now_ns >= FIRST_LIMIT_NS:
            raise TargetTimeout(
                f"{self.subject.where}: the main controller has not looked at its sensors "
                f"{FIRST_LIMIT_NS // 1_000_000_000} s after power-up; it hangs before"
            )
        return bench.clock.now_ns

    def _watch(self) -> None:
        """Note the command when GO is said, and the line of telemetry."""
        bench, robot = self.bench, self.subject.robot
        if robot.link.step_line is None or not robot.telemetry:
            self._watch_next_look(bench, robot)
        if robot.link.step_line is not None:
            bench.wire("step").listen(lambda level: self._went() if level == 0 else None)
        host = bench.host("main")

        def heard(byte: int) -> None:
            self._line.append(byte)
            if byte == 0x0D and self._go is not None and not self._done:
                said = self.said.removesuffix(END).rpartition(END)[2]
                if not said.startswith(FAULT):  # a GO that came too soon; the report is behind it
                    self._finish()

        host.heard = heard

    def _watch_next_look(self, bench: Bench, robot: Robot) -> None:
        """Without telemetry or step line, a decision is over when the next look begins."""
        last = bench.parts_of(Sonar)[f"sonar_{robot.sonars[-1].name}"]

        def trigger(level: int | None) -> None:
            if level == 1 and last.triggers:
                self._went()
                self._finish()

        bench.chip("main").on_pin(robot.sonars[0].pins[0], trigger)

    def _went(self) -> None:
        if self._go is None:
            levels = [self.bench.wire(f"command_{bit}").level or 0 for bit in range(3)]
            command = sum(level << bit for bit, level in enumerate(levels))
            self._go = (command, self.bench.clock.now_ns)

    def _finish(self) -> None:
        self._done = True
        self.bench.clock.stop()

    _sensors: ForcedSensors
    _line: bytearray
    _go: tuple[int, int] | None
    _done: bool
