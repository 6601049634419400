"""The robot's own images on the emulator: a bench with both Stamps, all sensors and servos.

`PinsTarget` lets the main controller hunt: every count reaches it as a pulse, a contact or an RC
time on its pins, and its command is read from the wires when it says GO. `RegisterTarget` goes on
from the moment behind sensing: the counts are put where sensing would have left them. It is a
thousand times faster, and it is not believed before it has agreed with the pins.
"""

import tempfile
from collections.abc import Callable, Sequence
from itertools import count
from pathlib import Path
from types import TracebackType
from typing import Self

from cgagen.build.bench import bench_text
from cgagen.emulator.bench import Bench, BenchState
from cgagen.emulator.bench_file import parse_bench
from cgagen.emulator.chip import Chip
from cgagen.emulator.parts.photocell import Photocell
from cgagen.emulator.parts.sonar import Answer, Sonar, middle_ns
from cgagen.emulator.parts.whisker import Whisker
from cgagen.emulator.routine import Routine
from cgagen.errors import CgagenError, MismatchError, RigError, TargetTimeout
from cgagen.robot import Robot
from cgagen.stamp.compiled import Compiled
from cgagen.stamp.image import Image, Use
from hil.layout import Place, layout_of, line_of_label
from hil.subject import CHIPS, Subject
from hil.target import (
    COUNTS,
    IMAGE,
    LATENCY,
    PINS,
    REGISTERS,
    STATE,
    Identity,
    Observation,
    Stimulus,
)
from hil.telemetry import parse_telemetry

MOST_SONAR_COUNTS = 65_534
"""The longest echo that PULSIN can measure; 65,535 reaches the classifier as registers only."""

FIRST_LIMIT_NS = 10_000_000_000
"""How long a robot may take from power-up to its first look. Choice: four times what it takes."""

DECISION_LIMIT_NS = 3_000_000_000
"""How long one decision may take. Choice: ten times what the slowest chip takes."""

LEAD_NS = 1_000_000
"""How long before the first trigger the sensors are set."""

CALIBRATION_COUNTS = (1_000, 1_100, 1_200, 1_300, 1_400, 1_500)
"""What the sonars see while it is found out where sensing leaves its counts. Choice: all differ."""


class Forced:
    """Makes a sonar answer with just the count that is wanted, or not at all.

    Attributes:
        width_ns: of the echo; None for no echo.
    """

    def __init__(self) -> None:
        self.width_ns: int | None = None

    def spoil(self, answer: Answer) -> Answer | None:
        """Return the wanted answer."""
        return None if self.width_ns is None else answer._replace(width_ns=self.width_ns)


def robot_bench(robot: Robot, images: dict[str, Image]) -> Bench:
    """Return the bench of a robot with these images in its chips."""
    with tempfile.TemporaryDirectory(prefix="cgagen-") as folder:
        for name in CHIPS:
            (Path(folder) / f"{name}.bin").write_bytes(images[name].eeprom)
        return parse_bench(bench_text(robot), "bench.toml", Path(folder))


class PinsTarget:
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
            TargetTimeout: it does not look at its sensors.
        """
        try:
            self._power_up()
        except TargetTimeout:
            raise
        except CgagenError as error:
            raise RigError(f"{self.subject.where}: on the emulator: {error}") from error

    def close(self) -> None:
        """Let the bench go."""
        self._ready = None

    def __enter__(self) -> Self:
        self.open()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

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
            TargetTimeout: it has not decided in three seconds of its own time.
            MismatchError: its wires say another command than its telemetry.
        """
        self.present(stimulus)
        bench = self.bench
        self._line.clear()
        self._go = None
        self._done = False
        began_ns = bench.clock.now_ns + LEAD_NS
        bench.run(began_ns + DECISION_LIMIT_NS)
        if not self._done or self._go is None:
            raise TargetTimeout(
                f"{self.subject.where}: no decision in {DECISION_LIMIT_NS // 1_000_000} ms of the "
                f"robot's time for the reading {stimulus.text()}; it hangs there"
            )
        command, go_ns = self._go
        return self._observed(command, go_ns - began_ns)

    def present(self, stimulus: Stimulus) -> None:
        """Go back to the moment before the first look, with this in front of the sensors."""
        if self._ready is None:
            raise RigError("the emulated robot is not open; open it first")
        self.bench.restore(self._ready)
        main = self.subject.robot.main
        for forced, one in zip(self._forced, stimulus.sonars, strict=True):
            forced.width_ns = middle_ns(one, main.pulsin_unit_ns) if one else None
        for whisker, bent in zip(self._whiskers, stimulus.touched, strict=True):
            whisker.touch(bent)
        for cell, one in zip(self._cells, stimulus.lights, strict=True):
            cell.drain(middle_ns(one, main.rctime_unit_ns) if one else None)

    def _observed(self, command: int, latency_ns: int) -> Observation:
        told = parse_telemetry(self._line.decode("ascii", "replace"), self.subject.role)
        if told is None:
            return Observation(next(self._seq), command, latency_ns=latency_ns)
        if told.command != command:
            raise MismatchError(
                f"{self.subject.where}: the command lines say {command} and the telemetry "
                f"{told.command} for the reading {told.stimulus.text()}"
            )
        return Observation(next(self._seq), command, told.state, told.stimulus, latency_ns)

    # -- Setting up ---------------------------------------------------------------------------

    def _power_up(self) -> None:
        robot = self.subject.robot
        self.bench = robot_bench(robot, self.images)
        first_ns = self._first_trigger_ns()
        self.bench = bench = robot_bench(robot, self.images)
        sonars = bench.parts_of(Sonar)
        self._forced = [Forced() for _ in robot.sonars]
        for sonar, forced in zip(robot.sonars, self._forced, strict=True):
            sonars[f"sonar_{sonar.name}"].spoilers.append(forced)
        self._whiskers = list(bench.parts_of(Whisker).values())
        self._cells = list(bench.parts_of(Photocell).values())
        self._line, self._go, self._done = bytearray(), None, True
        self._watch()
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

    _forced: list[Forced]
    _whiskers: list[Whisker]
    _cells: list[Photocell]
    _line: bytearray
    _go: tuple[int, int] | None
    _done: bool


Compile = Callable[[str, str], Compiled]
"""Turns a source and its name into an image with its source map."""


class RegisterTarget:
    """The main controller's `Decide`, from a snapshot behind sensing.

    Args:
        subject: what is on trial; its source says where `Decide` and its variables are.
        compile_source: the tokenizer.
        images: in place of the subject's own.

    Attributes:
        compiled: the source, with its lines.
        entry: the address where `Decide` begins.
    """

    caps = frozenset({STATE, LATENCY, REGISTERS, IMAGE})

    def __init__(
        self,
        subject: Subject,
        compile_source: Compile,
        images: dict[str, Image] | None = None,
    ) -> None:
        self.url = "emulator:registers"
        self.stale = 0
        self.subject = subject
        self.entry = 0
        self._pins = PinsTarget(subject, images)
        self._seq = count(1)
        self.compiled = compile_source(subject.sources["main"], subject.files["main"])
        layout = layout_of(subject.sources["main"])
        try:
            self._words = _words_of(subject.robot, layout)
            self._antennas = layout["antennas"].element
            self._state = layout["state"].element
        except KeyError as error:
            raise RigError(f"{subject.where}: main source has no variable {error}") from error
        self._shifts = list(enumerate(subject.robot.link.main_pins))

    def open(self) -> None:
        """Run the robot to its first `Decide` and prove that the registers are understood.

        Raises:
            RigError: the program in the image is not the source's, or senses otherwise.
            TargetTimeout: it never decides.
        """
        self._check_program(self._pins.images["main"])
        self._pins.open()
        self.entry = self._entry_address()
        chip = self._to_decide(calibration(self.subject.robot))
        stop = chip.machine.memory.slots[chip.slot].header(chip.machine.gosubs[-1])
        self._routine, self._table = Routine(chip, stop), None
        self._before = list(self._routine.before)
        self._calibrate()

    def close(self) -> None:
        """Let the bench go."""
        self._pins.close()

    def reset(self) -> None:
        """Begin anew."""
        self.open()

    def __enter__(self) -> Self:
        self.open()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def load(self, image: Image, chip: str = "main") -> None:
        """Put another image into a chip, and begin anew."""
        self._pins.images = {**self._pins.images, chip: image}
        self.open()

    def identity(self) -> Identity:
        """Return the banner's words, and the digests of what is in the chips."""
        return self._pins.identity()

    def decide(self, stimulus: Stimulus) -> Observation:
        """Run `Decide` once.

        Raises:
            TargetTimeout: it does not come back.
        """
        try:
            took_ns = self._routine.call(self.registers(stimulus))
        except CgagenError as error:
            raise TargetTimeout(f"{self.subject.where}: {error}") from error
        words, command = self._routine.words, self._command(self._routine.latch)
        state = words[self._state >> 1] >> 8 * (self._state & 1) & 0xFF
        return Observation(next(self._seq), command, state, None, took_ns)

    def decide_all(self, stimuli: Sequence[Stimulus]) -> list[Observation]:
        """Return all decisions."""
        return [self.decide(stimulus) for stimulus in stimuli]

    def look_up(self, state: int) -> int:
        """Return the command that the program reads from its table for a state.

        This reaches the states that no reading leads to, too.

        Raises:
            RigError: the program reads no table.
            TargetTimeout: it does not come back.
        """
        if self._table is None:
            chip = self._to_decide(calibration(self.subject.robot))
            stop = chip.machine.memory.slots[chip.slot].header(chip.machine.gosubs[-1])
            read = self._table_address()
            limit_ns = self._pins.bench.clock.now_ns + DECISION_LIMIT_NS
            if not chip.run_until(lambda: chip.pc == read, limit_ns):
                raise TargetTimeout(f"{self.subject.where}: Decide never comes to its table")
            self._table = Routine(chip, stop)
        words = list(self._table.before)
        index, shift = self._state >> 1, 8 * (self._state & 1)
        words[index] = words[index] & ~(0xFF << shift) | state << shift
        try:
            self._table.call(words)
        except CgagenError as error:
            raise TargetTimeout(f"{self.subject.where}: {error}") from error
        return self._command(self._table.latch)

    def _table_address(self) -> int:
        """Return where the READ in `Decide` begins."""
        statements = self.compiled.source_map.statements
        lines = self.compiled.source.splitlines()
        for one in statements:
            if one.bit >= self.entry and lines[one.line - 1].lstrip().upper().startswith("READ "):
                return one.bit
        raise RigError(f"{self.subject.where}: {self.compiled.name} reads no table in Decide")

    def _command(self, latch: int) -> int:
        return sum((latch >> pin & 1) << bit for bit, pin in self._shifts)

    def registers(self, stimulus: Stimulus) -> list[int]:
        """Return the register file as sensing leaves it."""
        words = self._before.copy()
        for index, one in zip(self._words, (*stimulus.sonars, *stimulus.lights), strict=True):
            words[index] = one
        left, right = stimulus.touched
        shift = 4 * (self._antennas & 3)
        levels = (not left) | (not right) << 1
        index = self._antennas >> 2
        words[index] = words[index] & ~(0xF << shift) | levels << shift
        return words

    def trace(self, stimulus: Stimulus) -> list[int]:
        """Return the source lines that `Decide` goes through, in order, each once in a row."""
        chip = self._to_decide(calibration(self.subject.robot))
        chip.registers.words[:] = self.registers(stimulus)
        depth, lines = len(chip.machine.gosubs), list[int]()

        def hook(one: Chip) -> None:
            if len(one.machine.gosubs) < depth or len(lines) > 10_000:
                one.clock.stop()
                return
            statement = self.compiled.source_map.at_bit(one.pc)
            if statement is not None and lines[-1:] != [statement.line]:
                lines.append(statement.line)

        remove = chip.on_instruction(hook)
        try:
            self._pins.bench.run(self._pins.bench.clock.now_ns + DECISION_LIMIT_NS)
        finally:
            remove()
        return lines

    def _check_program(self, image: Image) -> None:
        flags = self.compiled.image.known_flags()
        pairs = zip(flags, image.eeprom, self.compiled.image.eeprom, strict=True)
        if any(flag & 3 == Use.PROGRAM and byte != wanted for flag, byte, wanted in pairs):
            raise RigError(
                f"{self.subject.where}: the program in the main controller's image is not that of "
                f"{self.subject.files['main']}, so its variables are unknown; try it by its pins"
            )

    def _entry_address(self) -> int:
        line = line_of_label(self.compiled.source, "Decide")
        after = [s for s in self.compiled.source_map.statements if line and s.line > line]
        if not after:
            raise RigError(f"{self.subject.where}: {self.compiled.name} has no routine Decide")
        return after[0].bit

    def _to_decide(self, stimulus: Stimulus) -> Chip:
        """Let the robot sense a stimulus; its main controller then stands at `Decide`."""
        self._pins.present(stimulus)
        chip = self._pins.bench.chip("main")
        limit_ns = self._pins.bench.clock.now_ns + DECISION_LIMIT_NS
        if not chip.run_until(lambda: chip.pc == self.entry, limit_ns) or not chip.machine.gosubs:
            raise TargetTimeout(f"{self.subject.where}: senses, and never comes to Decide")
        return chip

    def _calibrate(self) -> None:
        """Compare what sensing left with what would be put there, and both ways' decisions."""
        stimulus = calibration(self.subject.robot)
        if self.registers(stimulus) != self._before:
            raise RigError(
                f"{self.subject.where}: sensing {stimulus.text()} leaves other registers than "
                f"the variables of {self.subject.files['main']} say; try it by its pins"
            )
        here, there = self.decide(stimulus), self._pins.decide(stimulus)
        if here.command != there.command or there.state not in (None, here.state):
            raise RigError(
                f"{self.subject.where}: Decide alone answers {stimulus.text()} with "
                f"{here.command} and the robot with {there.command}; try it by its pins"
            )

    _routine: Routine
    _table: Routine | None
    _before: list[int]


def calibration(robot: Robot) -> Stimulus:
    """Return a reading whose counts all differ, with one antenna touched."""
    lights = (300, 400) if robot.light else ()
    return Stimulus(CALIBRATION_COUNTS[: len(robot.sonars)], (True, False), lights)


def _words_of(robot: Robot, layout: dict[str, Place]) -> list[int]:
    """Return the registers of the sonars' and the light sensors' counts."""
    echo = layout["echo"].element
    words = [echo + index for index in range(len(robot.sonars))]
    if robot.light:
        words += [layout[name].element for name in ("lightleft", "lightright")]
    return words
