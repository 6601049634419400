"""A trace: what a robot has sensed, reading after reading, and what was decided, if that is known.

Times count from the first reading. A trace is in the chip's counts, whatever its file was in.
"""

from dataclasses import dataclass, field
from typing import Any

from cgagen.errors import TraceError
from cgagen.words import GENES, Role
from hil.messages import TICK_NS
from hil.target import Observation, Stimulus

STATES = {Role.PREDATOR: GENES, Role.PREY: 11}
"""Of each robot. Ref: S1 table II; the prey's are those of PROTOCOL.md."""

COMMANDS = 8
"""Ref: S1 table I."""

NS_PER_US = 1_000


@dataclass(frozen=True, slots=True)
class Sample:
    """A reading, and the decision that was recorded with it.

    Attributes:
        time_ns: since the first reading; whole microseconds, which is what the files hold.
        stimulus: the reading, in counts.
        seq: its number; consecutive, and 0 follows 65,535.
        state: None where it was not recorded.
        command: likewise.
        latency_ns: likewise, from the beginning of sensing by the target's own clock.
        where: its place in the file it was read from, such as `line 12`.
    """

    time_ns: int
    stimulus: Stimulus
    seq: int
    state: int | None = None
    command: int | None = None
    latency_ns: int | None = None
    where: str = field(default="", compare=False)

    @property
    def decided(self) -> bool:
        """Whether anything of a decision was recorded."""
        return self.state is not None or self.command is not None


@dataclass(frozen=True, slots=True)
class Origin:
    """Where a trace comes from: what its sidecar says.

    Attributes:
        target: kind of what decided: `simulator`, `emulator`, `serial`, `can`; `hand` for
            vectors that were written.
        robot: name.
        role: of the robot.
        robot_digest: of its file.
        genome: digest; None for a prey, and for readings without decisions.
        images: digest by chip, of those that decided.
        seed: of what was chosen by chance; None where nothing was.
        clock: `nominal` where all readings are one second apart, `host` for a computer's clock.
        source: how the readings came about, in words and numbers that repeat it.
        robot_file: content of the robot's file, where it is none that ships; None otherwise.
    """

    target: str
    robot: str
    role: Role
    robot_digest: str
    genome: str | None = None
    images: dict[str, str] = field(default_factory=dict)
    seed: int | None = None
    clock: str = "nominal"
    source: dict[str, Any] = field(default_factory=dict)
    robot_file: str | None = None


@dataclass(frozen=True, slots=True)
class Trace:
    """Readings in order.

    Attributes:
        name: of the file, for messages.
        samples: one at least.
        origin: None where nothing tells.
        stale: decisions in the file that answered an earlier question once more.
    """

    name: str
    samples: tuple[Sample, ...]
    origin: Origin | None = None
    stale: int = 0

    @property
    def stimuli(self) -> list[Stimulus]:
        """The readings alone."""
        return [sample.stimulus for sample in self.samples]

    @property
    def decided(self) -> bool:
        """Whether any decision was recorded."""
        return any(sample.decided for sample in self.samples)


def refused(name: object, where: str, what: str, remedy: str = "record it again") -> TraceError:
    """Return the error of a place in a file.

    >>> str(refused("a.log", "line 3", "is empty"))
    'a.log: line 3: is empty; record it again'
    """
    return TraceError(
        f"{name}: {where}: {what}; {remedy}" if where else f"{name}: {what}; {remedy}"
    )


def check_decision(role: Role, state: int | None, command: int | None) -> str:
    """Return what is wrong with a decision's numbers; "" for nothing.

    >>> check_decision(Role.PREY, 11, 0)
    'state 11 is none of a prey, which are 0 to 10'
    """
    if state is not None and not 0 <= state < STATES[role]:
        return f"state {state} is none of a {role}, which are 0 to {STATES[role] - 1}"
    if command is not None and not 0 <= command < COMMANDS:
        return f"command {command} is not 0 to {COMMANDS - 1}"
    return ""


def sample_of(
    time_ns: int, stimulus: Stimulus, seq: int, observation: Observation | None
) -> Sample:
    """Return a reading and a decision; their times lose what a file has no room for."""
    time_ns -= time_ns % NS_PER_US
    if observation is None:
        return Sample(time_ns, stimulus, seq)
    seen, latency_ns = observation, observation.latency_ns
    if latency_ns is not None:
        latency_ns -= latency_ns % TICK_NS
    return Sample(time_ns, stimulus, seq, seen.state, seen.command, latency_ns)
