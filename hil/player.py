"""One robot of a bench with several: its parts under its name, and what it has done."""

from typing import NamedTuple

from cgagen.emulator.bench import Bench
from cgagen.emulator.wires import Wire
from cgagen.errors import RigError
from hil.forced import ForcedSensors
from hil.gait_reader import GaitReader, Reading
from hil.subject import Subject
from hil.target import Stimulus
from hil.telemetry import Told, parse_telemetry


class StepWire(NamedTuple):
    """The step line of a robot on a bench.

    Attributes:
        line: the wire.
        go_driver: who drives it for the main controller.
        walk_driver: who drives it for the locomotion controller.
    """

    line: Wire
    go_driver: str
    walk_driver: str


def step_wire(subject: Subject, bench: Bench, word: str) -> StepWire:
    """Return a robot's step line.

    Raises:
        RigError: it has none.
    """
    line = subject.robot.link.step_line
    if line is None:
        raise RigError(
            f"{subject.robot.name}: has no step line, so nobody can say when a step is "
            "finished; give it one ([command] step_line) or let it run free"
        )
    return StepWire(
        bench.wire(f"{word}_step"),
        f"{word}_main.P{line.main_pin}",
        f"{word}_locomotion.P{line.locomotion_pin}",
    )


class Player:
    """One robot of the colony: its parts, and what it has done in this step.

    Attributes:
        subject: its programs.
        word: before the names of its parts.
        gait: reads its servos.
        said: the last line of its telemetry; None before it.
        made: the movement of this step; None where it has made none.
        told: whether it was told to make the movement that it makes now.
        heard: all that its main controller has said.
    """

    def __init__(self, subject: Subject, bench: Bench, word: str) -> None:
        self.subject = subject
        self.word = word
        self.gait = GaitReader(subject.robot, bench, f"{word}_")
        self.said: Told | None = None
        self.made: Reading | None = None
        self.told = False
        self.heard = ""
        self._bytes = bytearray()
        self._sensors = ForcedSensors(subject.robot, bench, f"{word}_")
        bench.host(f"{word}_main").heard = self._heard

    def show(self, stimulus: Stimulus) -> None:
        """Put all that there is to be measured before the sensors."""
        self._sensors.show(stimulus)

    def _heard(self, byte: int) -> None:
        self._bytes.append(byte)
        if byte == 0x0D:
            line = self._bytes.decode("ascii", "replace")
            self._bytes.clear()
            self.heard += line
            self.said = parse_telemetry(line, self.subject.role) or self.said
