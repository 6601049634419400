"""What a target is: something that decides, and can be asked for its decision.

The simulator, the emulator and a real Stamp are targets. All of them are told what the chip
measures, in the chip's own counts, so that equal means equal, at every boundary.
"""

from dataclasses import dataclass, field
from typing import Protocol

STATE, COUNTS, LATENCY, PINS, REGISTERS, IMAGE, POWER, SERVOS = (
    "state",
    "counts",
    "latency",
    "pins",
    "registers",
    "image",
    "power",
    "servos",
)
"""What a target may be able to do besides giving a command: show its state (Table II), show what
it has measured, time a decision, sense through its pins, take its registers, show its EEPROM,
switch the supply, show the servos' pulses."""


@dataclass(frozen=True, slots=True, order=True)
class Stimulus:
    """What the main controller measures.

    Attributes:
        sonars: PULSIN counts in the robot's order, 0 to 65,535; 0 is no echo.
        touched: antennas, left and right.
        lights: RCTIME counts, left and right, 0 is dark; a prey has none.
    """

    sonars: tuple[int, ...]
    touched: tuple[bool, bool] = (False, False)
    lights: tuple[int, ...] = ()

    def text(self) -> str:
        """Return the stimulus as a command line takes it.

        >>> Stimulus((1843, 0, 700), (False, True), (0, 170)).text()
        '1843,0,700/-R/0,170'
        """
        antennas = "".join(
            letter if bent else "-" for letter, bent in zip("LR", self.touched, strict=True)
        )
        parts = [",".join(map(str, self.sonars)), antennas]
        return "/".join([*parts, ",".join(map(str, self.lights))] if self.lights else parts)


def stimulus_of(text: str) -> Stimulus:
    """Return the stimulus that `Stimulus.text` has written.

    Raises:
        ValueError: the text is none.

    >>> stimulus_of("1843,0,700/-R/0,170") == Stimulus((1843, 0, 700), (False, True), (0, 170))
    True
    """
    sonars, _, rest = text.partition("/")
    antennas, *last = rest.split("/")
    touched = (antennas[:1] == "L", antennas[1:] == "R")
    try:
        lights = tuple(map(int, last[0].split(","))) if last else ()
        stimulus = Stimulus(tuple(map(int, sonars.split(","))), touched, lights)
    except ValueError as error:
        raise ValueError(f"{text!r} is not like 1843,0,700/-R/0,170") from error
    if stimulus.text() != text or not _fit(stimulus):
        raise ValueError(f"{text!r} is not like 1843,0,700/-R/0,170")
    return stimulus


def _fit(stimulus: Stimulus) -> bool:
    return all(0 <= count <= 0xFFFF for count in (*stimulus.sonars, *stimulus.lights))


@dataclass(frozen=True, slots=True)
class Observation:
    """What a target has decided.

    Attributes:
        seq: number of the question that this answers.
        command: 0 to 7.
        state: a predator's 0 to 63, a prey's 0 to 10 (see PROTOCOL.md); None where unseen.
        counts: what was measured; None where unseen.
        latency_ns: from the beginning of sensing, or of the decision, by the target's own clock.
    """

    seq: int
    command: int
    state: int | None = None
    counts: Stimulus | None = None
    latency_ns: int | None = None


@dataclass(frozen=True, slots=True)
class Identity:
    """What a target says of itself.

    Attributes:
        robot: name.
        genome: 8 digits: of a genome, or of a prey's robot file.
        images: digest of the EEPROM by chip, of those that the target can show.
        nonce: what it was given to return; "" for none.
    """

    robot: str
    genome: str
    images: dict[str, str] = field(default_factory=dict)
    nonce: str = ""


class Target(Protocol):
    """Something that decides.

    Attributes:
        url: what it is called: `simulator`, `emulator`, `serial:PORT`, `can:INTERFACE:CHANNEL`.
        caps: what it can do; see the words above.
    """

    url: str
    caps: frozenset[str]

    @property
    def stale(self) -> int:
        """Answers to earlier questions that came late and were thrown away."""
        ...

    def open(self) -> None:
        """Make it ready. Raises RigError."""
        ...

    def close(self) -> None:
        """Let it go. Harmless when repeated."""
        ...

    def identity(self) -> Identity:
        """Return who it is. Raises RigError."""
        ...

    def reset(self) -> None:
        """Reset its chips. Raises RigError where that cannot be done."""
        ...

    def decide(self, stimulus: Stimulus) -> Observation:
        """Return the decision. Raises TargetTimeout."""
        ...
