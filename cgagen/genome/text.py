"""The text file of a genome: TOML with the movements as comments, or the bare 192 characters."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import tomli_w

from cgagen.errors import GenomeError
from cgagen.genome.value import Genome, Origin, movement_table, problem_of_bits
from cgagen.inputs import GENOME, read_text
from cgagen.notations import parse_toml
from cgagen.shown import short, shown
from cgagen.words import BITS_PER_GENE, GENOME_BITS, Situation

FORMAT = "cgagen-genome-1"


def load(path: Path) -> Genome:
    """Read a genome file.

    Raises:
        GenomeError: the file cannot be read or is no genome; the sentence names the file.
    """
    return parse(read_text(path, GENOME), str(path))


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
        data = parse_toml(text)
    except ValueError as error:
        raise GenomeError(f"{name}: is not TOML ({error}); see the format of best.genome") from None
    return _from_toml(data, name)


def to_text(genome: Genome) -> str:
    """Return the text of a genome file: the same genome gives the same bytes.

    Of bits that were edited since, no more is said than what they were edited from.
    """
    head: dict[str, Any] = {"format": FORMAT, "robot": genome.robot}
    if genome.interface is not None:
        head["interface"] = genome.interface
    of = genome.evolved
    fields = {
        "seed": of.seed,
        "trial": of.trial,
        "generation": of.generation,
        "fitness": of.fitness,
        "robot_digest": of.robot_digest,
        "digest": of.digest,
        "edited_from": of.edited_from,
        "versions": dict(of.versions) or None,
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


def _from_toml(data: Mapping[str, Any], name: str) -> Genome:
    """Return the genome of a parsed file, or the sentence that says why it is none."""
    _check_keys(data, {"format", "robot", "interface", "bits", "origin"}, name, "")
    for key in ("format", "robot", "bits"):
        if key not in data:
            raise GenomeError(f"{name}: the key {key} is missing; a genome has format, robot, bits")
    form = data["format"]
    if form != FORMAT:
        raise GenomeError(f"{name}: format is {shown(form)}, and this version reads {FORMAT!r}")
    for key in ("robot", "interface", "bits"):
        value = data.get(key, "-")
        if not isinstance(value, str) or not value.strip():
            raise GenomeError(
                f"{name}: {key} is {shown(value)}, it must be a text that is not empty"
            )
    origin = data.get("origin", {})
    if not isinstance(origin, dict):
        raise GenomeError(f"{name}: origin is {shown(origin)}, it must be a table [origin]")
    return Genome(
        _bits_of(data["bits"], name, "bits: "),
        data["robot"],
        data.get("interface"),
        _origin_of(origin, name),
    )


def _origin_of(table: Mapping[str, Any], name: str) -> Origin:
    """Return the [origin] of a file, or the sentence that says what is wrong with it."""
    known = {"seed": 0, "trial": 1, "generation": 1}
    digests = ("robot_digest", "digest", "edited_from")
    _check_keys(table, {*known, *digests, "fitness", "versions"}, name, "[origin] ")
    for key, least in known.items():
        value = table.get(key, least)
        if type(value) is not int or value < least:
            raise GenomeError(
                f"{name}: [origin] {key} is {shown(value)}, a whole number >= {least}"
            )
    fitness = table.get("fitness", 0.0)
    if type(fitness) not in (int, float) or not math.isfinite(fitness):
        raise GenomeError(
            f"{name}: [origin] fitness is {shown(fitness)}, it must be a finite number"
        )
    versions = table.get("versions", {})
    texts = [table.get(key, "") for key in digests]
    texts += list(versions.values()) if isinstance(versions, dict) else [None]
    if not all(isinstance(text, str) for text in texts):
        raise GenomeError(f"{name}: [origin] digests and versions must hold texts")
    return Origin(
        seed=table.get("seed"),
        trial=table.get("trial"),
        generation=table.get("generation"),
        fitness=float(fitness) if "fitness" in table else None,
        robot_digest=table.get("robot_digest"),
        versions=tuple(sorted(versions.items())),
        digest=table.get("digest"),
        edited_from=table.get("edited_from"),
    )


def _check_keys(table: Mapping[str, Any], allowed: set[str], name: str, where: str) -> None:
    """Refuse the first key, in the file's order, that is not one of ours."""
    for key in table:
        if key not in allowed:
            choices = ", ".join(sorted(allowed))
            raise GenomeError(
                f"{name}: {where}the key {short(key)} is unknown; allowed are {choices}"
            )


def _bits_of(text: str, name: str, where: str) -> str:
    """Return the 192 characters without white space, or the sentence that says what is wrong."""
    bits = "".join(text.split())
    problem = problem_of_bits(bits)
    if problem:
        raise GenomeError(f"{name}: {where}{problem}")
    return bits
