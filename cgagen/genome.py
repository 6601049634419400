"""A genome: 64 commands as 192 bits, and the text file that holds it.

Gene 0 answers the state "no obstacle, no target"; the others follow `words.state_of`. Inside a
gene the most significant bit comes first, as the paper prints it (Ref: S1 figure 5). The file is
TOML with the table of movements as comments, or the bare 192 characters.
"""

import math
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w
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

FORMAT = "cgagen-genome-1"
PAPER_ROBOT = "servobot-predator"
"""The robot of a bare text of 192 characters: the paper's own. Ref: S1 figure 5."""

LARGEST_FILE = 65_536
"""Bytes; a genome file has about 3,000. choice: a wrong file is refused before it is parsed."""


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
    """

    seed: int | None = None
    trial: int | None = None
    generation: int | None = None
    fitness: float | None = None
    robot_digest: str | None = None
    versions: tuple[tuple[str, str], ...] = ()


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
        problem = _problem_of_bits(self.bits)
        if problem:
            raise ValueError(f"a genome {problem}")

    @property
    def digest(self) -> str:
        """SHA-256 of the 192 characters, as 64 hexadecimal digits."""
        return files.digest(self.bits)

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


def load(path: Path) -> Genome:
    """Read a genome file.

    Raises:
        GenomeError: the file cannot be read or is no genome; the sentence names the file.
    """
    try:
        if path.exists() and not path.is_file():
            raise GenomeError(f"{path}: is not a file; give the best.genome of a run")
        if path.exists() and path.stat().st_size > LARGEST_FILE:
            raise GenomeError(
                f"{path}: {path.stat().st_size:,} bytes are too many for a genome file "
                f"(at most {LARGEST_FILE:,}); give the best.genome of a run"
            )
        text = path.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise GenomeError(
            f"{path}: byte {error.start} is not UTF-8 text; give the best.genome of a run"
        ) from None
    except OSError as error:
        raise GenomeError(
            f"{path}: cannot be read as a genome ({error.strerror or error}); "
            "give the best.genome of a run"
        ) from None
    return parse(text, str(path))


def parse(text: str, name: str) -> Genome:
    """Return the genome that a text holds, TOML or the bare 192 characters.

    Args:
        text: content of the file.
        name: what sentences call the file.

    Raises:
        GenomeError: one sentence with `name`, what is wrong and what is allowed.

    >>> parse("001 " * 64, "mine.genome").robot
    'servobot-predator'
    """
    if not set("=[#") & set(text):
        return Genome(_bits_of(text, name, ""))
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise GenomeError(f"{name}: is not TOML ({error}); see the format of best.genome") from None
    return _from_toml(data, name)


def to_text(genome: Genome) -> str:
    """Return the text of a genome file: the same genome gives the same bytes."""
    head: dict[str, Any] = {"format": FORMAT, "robot": genome.robot}
    if genome.interface is not None:
        head["interface"] = genome.interface
    fields = {
        "seed": genome.origin.seed,
        "trial": genome.origin.trial,
        "generation": genome.origin.generation,
        "fitness": genome.origin.fitness,
        "robot_digest": genome.origin.robot_digest,
        "versions": dict(genome.origin.versions) or None,
    }
    origin = {key: value for key, value in fields.items() if value is not None}
    row = GENOME_BITS // len(Situation)
    lines = [genome.bits[start : start + row] for start in range(0, GENOME_BITS, row)]
    bits = "\n".join(" ".join(line[at : at + BITS_PER_GENE] for at in range(0, row, BITS_PER_GENE))
                     for line in lines)  # fmt: skip
    table = "\n".join(f"# {line}".rstrip() for line in movement_table(genome))
    return (
        f"{tomli_w.dumps(head)}\n"
        "# One line per obstacle, one group of three bits per target, in the order of the table.\n"
        f'bits = """\n{bits}\n"""\n\n{table}\n'
    ) + (f"\n{tomli_w.dumps({'origin': origin})}" if origin else "")


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
    evolved_on = genome.origin.robot_digest
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


def _from_toml(data: Mapping[str, Any], name: str) -> Genome:
    """Return the genome of a parsed file, or the sentence that says why it is none."""
    _check_keys(data, {"format", "robot", "interface", "bits", "origin"}, name, "")
    for key in ("format", "robot", "bits"):
        if key not in data:
            raise GenomeError(f"{name}: the key {key} is missing; a genome has format, robot, bits")
    form = data["format"]
    if form != FORMAT:
        raise GenomeError(f"{name}: format is {form!r}, and this version reads {FORMAT!r}")
    for key in ("robot", "interface", "bits"):
        value = data.get(key, "-")
        if not isinstance(value, str) or not value.strip():
            raise GenomeError(f"{name}: {key} is {value!r}, it must be a text that is not empty")
    origin = data.get("origin", {})
    if not isinstance(origin, dict):
        raise GenomeError(f"{name}: origin is {origin!r}, it must be a table [origin]")
    return Genome(
        _bits_of(data["bits"], name, "bits: "),
        data["robot"],
        data.get("interface"),
        _origin_of(origin, name),
    )


def _origin_of(table: Mapping[str, Any], name: str) -> Origin:
    """Return the [origin] of a file, or the sentence that says what is wrong with it."""
    known = {"seed": 0, "trial": 1, "generation": 1}
    _check_keys(table, {*known, "fitness", "robot_digest", "versions"}, name, "[origin] ")
    for key, least in known.items():
        value = table.get(key, least)
        if type(value) is not int or value < least:
            raise GenomeError(f"{name}: [origin] {key} is {value!r}, a whole number >= {least}")
    fitness = table.get("fitness", 0.0)
    if type(fitness) not in (int, float) or not math.isfinite(fitness):
        raise GenomeError(f"{name}: [origin] fitness is {fitness!r}, it must be a finite number")
    versions = table.get("versions", {})
    texts = [table.get("robot_digest", "")]
    texts += list(versions.values()) if isinstance(versions, dict) else [None]
    if not all(isinstance(text, str) for text in texts):
        raise GenomeError(f"{name}: [origin] robot_digest and versions must hold texts")
    return Origin(
        seed=table.get("seed"),
        trial=table.get("trial"),
        generation=table.get("generation"),
        fitness=float(fitness) if "fitness" in table else None,
        robot_digest=table.get("robot_digest"),
        versions=tuple(sorted(versions.items())),
    )


def _check_keys(table: Mapping[str, Any], allowed: set[str], name: str, where: str) -> None:
    """Refuse the first key, in the file's order, that is not one of ours."""
    for key in table:
        if key not in allowed:
            choices = ", ".join(sorted(allowed))
            raise GenomeError(f"{name}: {where}the key {key} is unknown; allowed are {choices}")


def _bits_of(text: str, name: str, where: str) -> str:
    """Return the 192 characters without white space, or the sentence that says what is wrong."""
    bits = "".join(text.split())
    problem = _problem_of_bits(bits)
    if problem:
        raise GenomeError(f"{name}: {where}{problem}")
    return bits


def _problem_of_bits(bits: str) -> str:
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
