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
from hil.anchors import Anchors, anchors_of
from hil.emulated import DECISION_LIMIT_NS, PinsTarget
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
        subject: what is on trial.
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
        self._shifts = list(enumerate(subject.robot.link.main_pins))

    def open(self) -> None:
        """Run the robot to its first `Decide` and prove that the registers are understood.

        Raises:
            RigError: the program in the image is not the source's, or senses otherwise.
            LackingError: it does not decide as every generated program does.
            TargetTimeout: it never decides.
        """
        image = self._pins.images["main"]
        self._check_program(image)
        self._anchors = anchors_of(image, self.subject.robot)
        self._pins.open()
        self.entry = self._anchors.places.entry
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
        command = self._command(self._routine.latch)
        state = self._anchors.state_in(self._routine.words)
        return Observation(next(self._seq), command, state, None, took_ns)

    def decide_all(self, stimuli: Sequence[Stimulus]) -> list[Observation]:
        """Return all decisions."""
        return [self.decide(stimulus) for stimulus in stimuli]

    def look_up(self, state: int) -> int:
        """Return the command that the program reads from its table for a state.

        This reaches the states that no reading leads to, too.

        Raises:
            TargetTimeout: it does not come back.
        """
        if self._table is None:
            chip = self._to_decide(calibration(self.subject.robot))
            stop = chip.machine.memory.slots[chip.slot].header(chip.machine.gosubs[-1])
            read = self._anchors.read
            limit_ns = self._pins.bench.clock.now_ns + DECISION_LIMIT_NS
            if not chip.run_until(lambda: chip.pc == read, limit_ns):
                raise TargetTimeout(f"{self.subject.where}: Decide never comes to its table")
            self._table = Routine(chip, stop)
        try:
            self._table.call(self._anchors.with_state(list(self._table.before), state))
        except CgagenError as error:
            raise TargetTimeout(f"{self.subject.where}: {error}") from error
        return self._command(self._table.latch)

    def _command(self, latch: int) -> int:
        return sum((latch >> pin & 1) << bit for bit, pin in self._shifts)

    def registers(self, stimulus: Stimulus) -> list[int]:
        """Return the register file as sensing leaves it. Raises ReadingError."""
        check_reading(stimulus, self.subject.robot)
        return self._anchors.sensed(self._before, stimulus)

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

    _anchors: Anchors
    _routine: Routine
    _table: Routine | None
    _before: list[int]


def calibration(robot: Robot) -> Stimulus:
    """Return a reading whose counts all differ, with one antenna touched."""
    lights = (300, 400) if robot.light else ()
    return Stimulus(CALIBRATION_COUNTS[: len(robot.sonars)], (True, False), lights)
