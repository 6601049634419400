"""The main controller's `Decide` alone, from the moment behind sensing.

The counts are put where sensing would have left them. It is a thousand times faster than going
through the pins, and it is not believed before it has agreed with them.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from itertools import count

from cgagen.closing import Closing
from cgagen.emulator.chip import Chip
from cgagen.emulator.routine import Routine
from cgagen.errors import CgagenError, ExecutionError, RigError, TargetTimeout
from cgagen.robot import Robot
from cgagen.stamp.compiled import Compiled
from cgagen.stamp.image import Image, Use
from cgagen.stamp.scan import lines_of
from hil.emulated import DECISION_LIMIT_NS, PinsTarget
from hil.layout import Place, layout_of, line_of_label
from hil.roster import check_reading
from hil.subject import Subject
from hil.target import IMAGE, LATENCY, REGISTERS, STATE, Identity, Observation, Stimulus

CALIBRATION_COUNTS = (1_000, 1_100, 1_200, 1_300, 1_400, 1_500)
"""What the sonars see while it is found out where sensing leaves its counts. Choice: all differ."""

Compile = Callable[[str, str], Compiled]
"""Turns a source and its name into an image with its source map."""


class RegisterTarget(Closing):
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
        # What `Decide` does not set, or leaves as it was, shows: 7 is on the lines before.
        chip.pins.set_latch(chip.pins.latch | sum(1 << pin for _, pin in self._shifts))
        self._routine, self._table = Routine(chip, stop), None
        self._before = list(self._routine.before)
        self._calibrate()

    def close(self) -> None:
        """Let the bench go."""
        self._pins.close()

    def reset(self) -> None:
        """Begin anew."""
        self.open()

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
            ReadingError: the stimulus is not one of this robot.
            TargetTimeout: it does not come back.
        """
        registers = self.registers(stimulus)
        try:
            took_ns = self._routine.call(registers)
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
        lines = lines_of(self.compiled.source)
        for one in statements:
            if one.bit >= self.entry and lines[one.line - 1].lstrip().upper().startswith("READ "):
                return one.bit
        raise RigError(f"{self.subject.where}: {self.compiled.name} reads no table in Decide")

    def _command(self, latch: int) -> int:
        return sum((latch >> pin & 1) << bit for bit, pin in self._shifts)

    def registers(self, stimulus: Stimulus) -> list[int]:
        """Return the register file as sensing leaves it. Raises ReadingError."""
        check_reading(stimulus, self.subject.robot)
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
        """Return the source lines that `Decide` goes through, in order, each once in a row.

        Where it does not come back, or comes to what is no instruction, they end there.
        """
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
            with suppress(ExecutionError):
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
                f"{self.subject.where}: Decide alone answers {stimulus.text()} with state "
                f"{here.state} and command {here.command}, the robot with {there.state} and "
                f"{there.command}; try it by its pins"
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
