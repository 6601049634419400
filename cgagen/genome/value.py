"""The genome as a value, and whether it fits a robot."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Self

import numpy as np
from numpy.typing import NDArray

from cgagen import files
from cgagen.errors import GenomeError
from cgagen.words import (
    BITS_PER_GENE,
    COMMANDS,
    GENES,
    GENOME_BITS,
    Role,
    Situation,
    situation_name,
    situations_of,
)

PAPER_ROBOT = "servobot-predator"
"""The robot of a bare text of 192 characters: the paper's own. Ref: S1 figure 5."""


@dataclass(frozen=True, slots=True)
class Origin:
    """Where a genome comes from; every field may be unknown.

    Attributes:
        seed: seed of the run.
        trial: trial of the run, from 1.
        generation: generation that held the individual, from 1.
        fitness: mean step score on the fixed starts, arena units.
        robot_digest: SHA-256 of the robot that it was evolved on.
        versions: (program, version) pairs, sorted by program.
        digest: of the genome that all of this is said of; see `Genome.digest`.
        edited_from: digest of a genome that was evolved, where this one is a change of it.
    """

    seed: int | None = None
    trial: int | None = None
    generation: int | None = None
    fitness: float | None = None
    robot_digest: str | None = None
    versions: tuple[tuple[str, str], ...] = ()
    digest: str | None = None
    edited_from: str | None = None


class Standing(StrEnum):
    """What the origin in a genome's file is worth."""

    ATTESTED = "attested"
    """It carries the digest of these very bits."""
    UNATTESTED = "unattested"
    """It carries none: from an older version, or written by hand."""
    EDITED = "edited since"
    """It was said of other bits: none of it holds for these."""
    NONE = "none"
    """Nothing is said."""


@dataclass(frozen=True, slots=True)
class Genome:
    """A table of 64 commands for one kind of robot.

    Attributes:
        bits: 192 characters of 0 and 1.
        robot: name of the robot that it is for.
        interface: the robot's sensors, situations and movements in one line; None if unknown.
        origin: the run that it comes from.

    Raises:
        ValueError: `bits` is not 192 characters of 0 and 1.
    """

    bits: str
    robot: str = PAPER_ROBOT
    interface: str | None = None
    origin: Origin = Origin()

    def __post_init__(self) -> None:
        problem = problem_of_bits(self.bits)
        if problem:
            raise ValueError(f"a genome {problem}")

    @property
    def digest(self) -> str:
        """SHA-256 of the 192 characters, as 64 hexadecimal digits."""
        return files.digest(self.bits)

    @property
    def standing(self) -> Standing:
        """What the origin is worth."""
        origin = self.origin
        if origin.edited_from is not None or origin.digest not in (None, self.digest):
            return Standing.EDITED
        if origin.digest is not None:
            return Standing.ATTESTED
        return Standing.NONE if origin == Origin() else Standing.UNATTESTED

    @property
    def evolved(self) -> Origin:
        """What of the origin holds for these bits: after an edit only what they were edited from.

        >>> changed = Genome("1" * 192, origin=Origin(fitness=700.0, digest="ab"))
        >>> changed.evolved.fitness, changed.evolved.edited_from
        (None, 'ab')
        """
        if self.standing is not Standing.EDITED:
            return self.origin
        return Origin(edited_from=self.origin.edited_from or self.origin.digest)

    def attested(self) -> Self:
        """Return the same with the digest of its bits in its origin; for whoever evolved it."""
        return replace(self, origin=replace(self.origin, digest=self.digest))

    def commands(self) -> tuple[int, ...]:
        """Return the 64 commands, 0 to 7, by state.

        >>> Genome("001" + "111" * 63).commands()[:2]
        (1, 7)
        """
        starts = range(0, GENOME_BITS, BITS_PER_GENE)
        return tuple(int(self.bits[start : start + BITS_PER_GENE], 2) for start in starts)

    def array(self) -> NDArray[np.uint8]:
        """Return the bits as an array of 0 and 1, shape (192,)."""
        return np.frombuffer(self.bits.encode(), np.uint8) - np.uint8(ord("0"))


def from_commands(
    commands: Iterable[int],
    robot: str = PAPER_ROBOT,
    interface: str | None = None,
    origin: Origin | None = None,
) -> Genome:
    """Make a genome of 64 commands, 0 to 7, by state.

    Raises:
        ValueError: there are not 64, or one is not 0 to 7.

    >>> from_commands([1] + [7] * 63).bits[:6]
    '001111'
    """
    genes = tuple(commands)
    if len(genes) != GENES or not all(0 <= gene < 2**BITS_PER_GENE for gene in genes):
        raise ValueError(f"a genome is {GENES} commands of 0 to 7, not {genes}")
    return Genome(
        "".join(f"{gene:0{BITS_PER_GENE}b}" for gene in genes),
        robot,
        interface,
        origin or Origin(),
    )


def from_array(
    bits: NDArray[np.uint8],
    robot: str = PAPER_ROBOT,
    interface: str | None = None,
    origin: Origin | None = None,
) -> Genome:
    """Make a genome of an array of 0 and 1, shape (192,).

    Raises:
        ValueError: the array has another shape or other values.

    >>> genome = from_array(np.ones(192, np.uint8))
    >>> genome.commands() == (7,) * 64, (genome.array() == 1).all().item()
    (True, True)
    """
    if bits.shape != (GENOME_BITS,):
        raise ValueError(f"a genome has shape ({GENOME_BITS},), not {bits.shape}")
    text = "".join(map(str, bits.astype(int).tolist()))
    return Genome(text, robot, interface, origin or Origin())


def movement_table(genome: Genome) -> list[str]:
    """Return the movements as lines of text: a row per obstacle, a column per target.

    >>> print(movement_table(Genome("001" * 64))[1][:33].rstrip())
    no_object     BACKWARD       BACK
    """
    names = COMMANDS[Role.PREDATOR]
    commands = genome.commands()
    lines = [" " * 14 + "".join(situation_name(s, "target").ljust(15) for s in Situation).rstrip()]
    for obstacle in Situation:
        row = commands[8 * obstacle : 8 * obstacle + 8]
        cells = "".join(names[command].value.ljust(15) for command in row)
        lines.append(situation_name(obstacle, "object").ljust(14) + cells.rstrip())
    return lines


def origin_text(genome: Genome) -> str:
    """Return where a genome comes from, in words, and what that is worth; "" where nothing is said.

    >>> origin_text(Genome("1" * 192, origin=Origin(seed=7, fitness=700.0)))
    'seed 7, fitness 700.0; unattested: the file does not say of which bits'
    >>> origin_text(Genome("1" * 192, origin=Origin(fitness=700.0, digest="8e241ca1ff")))
    'edited since it was evolved as 8e241ca1; what was said of that is not said of these bits'
    """
    origin = genome.evolved
    if genome.standing is Standing.EDITED:
        return (
            f"edited since it was evolved as {(origin.edited_from or '')[:8]}; what was said of "
            "that is not said of these bits"
        )
    words = [
        f"{name} {value}"
        for name, value in (
            ("seed", origin.seed),
            ("trial", origin.trial),
            ("generation", origin.generation),
        )
        if value is not None
    ]
    words += [] if origin.fitness is None else [f"fitness {origin.fitness:.1f}"]
    loose = genome.standing is Standing.UNATTESTED and words
    return ", ".join(words) + ("; unattested: the file does not say of which bits" if loose else "")


def check_interface(
    genome: Genome, robot_name: str, interface: str, robot_digest: str | None = None
) -> str | None:
    """Refuse a genome that was made for another kind of robot.

    Args:
        genome: the genome to be used.
        robot_name: name of the robot that it shall drive.
        interface: that robot's sensors, situations and movements.
        robot_digest: that robot's digest; None where it does not matter.

    Returns:
        A note for the user where the robots differ in what a genome does not depend on (name,
        trims, thresholds, measured movements); None where there is nothing to say.

    Raises:
        GenomeError: sensors, situations or movements differ; the first that does is named.
    """
    if genome.interface is None:
        return (
            f"the genome does not say which sensors it was made for; "
            f"it is taken to be one for {robot_name}"
        )
    if genome.interface != interface:
        theirs, ours = _first_difference(genome.interface, interface)
        raise GenomeError(
            f"the genome was made for {genome.robot}, which has {theirs} where {robot_name} has "
            f"{ours}; evolve one for {robot_name} or choose the robot that it was made for"
        )
    if genome.robot != robot_name:
        return f"the genome was evolved on {genome.robot} and is used on {robot_name}"
    evolved_on = genome.evolved.robot_digest
    if robot_digest is not None and evolved_on is not None and evolved_on != robot_digest:
        return f"{robot_name} has changed since the genome was evolved on it"
    return None


def _first_difference(theirs: str, ours: str) -> tuple[str, str]:
    """Return the first items of two interface lines that differ, quoted."""
    left, right = ([item.strip() for item in line.replace(";", ",").split(",")]
                   for line in (theirs, ours))  # fmt: skip
    for index in range(max(len(left), len(right))):
        here = left[index] if index < len(left) else None
        there = right[index] if index < len(right) else None
        if here != there:
            return (repr(here) if here else "nothing"), (repr(there) if there else "nothing")
    return repr(theirs), repr(ours)


def problem_of_bits(bits: str) -> str:
    """Return what keeps characters from being a genome's bits; nothing if they are."""
    for index, character in enumerate(bits):
        if character not in "01":
            gene, bit = divmod(index, BITS_PER_GENE)
            place = f"character {index + 1}"
            if gene < GENES:
                obstacle, target = situations_of(gene)
                place += (
                    f" (gene {gene}: {situation_name(obstacle, 'object')}, "
                    f"{situation_name(target, 'target')}; its bit {bit + 1} of {BITS_PER_GENE})"
                )
            return f"has {character!r} as {place}, where only 0 and 1 are allowed"
    if len(bits) != GENOME_BITS:
        return (
            f"has {len(bits)} bits, and a genome has {GENOME_BITS}: "
            f"{GENES} genes of {BITS_PER_GENE}"
        )
    return ""
