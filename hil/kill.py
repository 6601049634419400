"""Which mutants the checks kill: each is compiled, tried on the emulator, and counted.

A mutant that is refused by the tokenizer is none; one with the same image is equivalent and
apart; one that no check notices survives, and stands in `survivors.toml` with a reason or fails
the run.
"""

import re
import sys
import time
import tomllib
from collections import Counter
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import click

from cgagen.errors import CgagenError, SourceError
from cgagen.tokenizer import compile_source
from hil.judge_legs import judge_legs
from hil.judge_main import Wanted, judge_main, wanted_of
from hil.mutate import Mutant, all_mutants, choose
from hil.proof import Proof, prove
from hil.subject import CHIPS, Subject, read_subject
from hil.trial import FailedCheck

FIRMWARE = Path(__file__).parent.parent / "firmware"
SURVIVORS = Path(__file__).parent / "survivors.toml"
PROGRAMS = tuple((role, chip) for role in ("predator", "prey") for chip in CHIPS)

MUTANTS = 215
"""Of each program in a full run; some do not compile. Choice: at least 200 are to be judged."""

NOT_COMPILED, EQUIVALENT, SURVIVED = "does not compile", "same image", "survived"
PROVEN = "proven equal"
"""No check notices it, and no check could: `hil.proof` shows that it decides alike everywhere."""

APART = (NOT_COMPILED, EQUIVALENT, PROVEN, SURVIVED)
IMPOSSIBLE = "electric"
"""The check that kills what the bench or the chip cannot do, such as outputs that fight."""


@dataclass(frozen=True, slots=True)
class Fate:
    """What became of a mutant.

    Attributes:
        role: of the robot.
        chip: `main` or `locomotion`.
        mutant: the change.
        end: the check that killed it, or one of the words `APART`.
        reason: what the check found.
    """

    role: str
    chip: str
    mutant: Mutant
    end: str
    reason: str = ""

    @property
    def killed(self) -> bool:
        """Whether a check has noticed it."""
        return self.end not in APART


@cache
def subject_for(role: str) -> Subject:
    """Return the checked-in firmware of a robot."""
    return read_subject(FIRMWARE / role)


@cache
def _wanted(role: str) -> Wanted:
    return wanted_of(subject_for(role))


def judge(role: str, chip: str, mutant: Mutant) -> Fate:
    """Compile a mutant and try it."""
    subject = subject_for(role)
    source = mutant.apply(subject.sources[chip])
    try:
        compiled = compile_source(source, subject.files[chip])
    except SourceError as error:
        return Fate(role, chip, mutant, NOT_COMPILED, str(error))
    if compiled.image.eeprom == subject.images[chip].eeprom:
        return Fate(role, chip, mutant, EQUIVALENT)
    try:
        if chip == "main":
            judge_main(subject, _wanted(role), compiled)
        else:
            judge_legs(subject, compiled.image)
    except FailedCheck as failed:
        return Fate(role, chip, mutant, failed.check, failed.reason)
    except (CgagenError, IndexError) as error:
        return Fate(role, chip, mutant, IMPOSSIBLE, str(error))
    return Fate(role, chip, mutant, SURVIVED)


def judge_all(number: int | None, workers: int = 1) -> Iterator[Fate]:
    """Judge so many mutants of each program, or all of them, in a fixed order."""
    work = []
    for role, chip in PROGRAMS:
        mutants = all_mutants(subject_for(role).sources[chip])
        chosen = mutants if number is None else choose(mutants, number)
        work += [(role, chip, mutant) for mutant in chosen]
    if workers == 1:
        yield from (judge(*one) for one in work)
        return
    with ProcessPoolExecutor(workers) as pool:
        yield from pool.map(judge, *zip(*work, strict=True), chunksize=4)


def proven(fates: Iterable[Fate]) -> Iterator[Fate]:
    """Return the same; a survivor inside of `Decide` is PROVEN where the proof holds for it."""
    for fate in fates:
        proof = proof_of(fate)
        whole = proof is not None and proof.proven
        yield replace(fate, end=PROVEN, reason=proof.text()) if proof and whole else fate


def proof_of(fate: Fate, sample: int | None = None) -> Proof | None:
    """Return what the proof says of a survivor inside of `Decide`; None for all others.

    Args:
        fate: of a mutant.
        sample: so many cells, which prove nothing; None for all.
    """
    if fate.end != SURVIVED or fate.chip != "main" or not _in_decide(fate):
        return None
    subject = subject_for(fate.role)
    compiled = compile_source(fate.mutant.apply(subject.sources["main"]), "main")
    return prove(replace(subject, images={**subject.images, "main": compiled.image}), sample)


def _in_decide(fate: Fate) -> bool:
    """Whether a change is in the routine, or in a constant that nothing else uses."""
    lines = subject_for(fate.role).sources["main"].split("\n")
    first = next(n for n, line in enumerate(lines, 1) if line.startswith("Decide:"))
    last = next(n for n, line in enumerate(lines, 1) if n > first and line.strip() == "RETURN")
    inside = range(first + 1, last)
    found = re.match(r"(\w+) +CON ", fate.mutant.before)
    if not found:
        return fate.mutant.line in inside
    word = re.compile(rf"\b{found[1]}\b")
    uses = [n for n, line in enumerate(lines, 1) if word.search(line.partition("  '")[0])]
    return all(n in inside for n in uses if n != fate.mutant.line)


@dataclass(frozen=True, slots=True)
class Review:
    """Survivors that somebody has looked at.

    Attributes:
        chips: whose programs.
        change: what `Mutant.text` says of them in full, as a regular expression.
        reason: why no check notices them.
    """

    chips: tuple[str, ...]
    change: re.Pattern[str]
    reason: str


@cache
def reviews(path: Path = SURVIVORS) -> tuple[Review, ...]:
    """Return the list."""
    rows = tomllib.loads(path.read_text("utf-8")).get("survivor", [])
    return tuple(
        Review(tuple(row["chips"]), re.compile(row["change"]), row["reason"]) for row in rows
    )


def reason_for(fate: Fate) -> str | None:
    """Return why a survivor is let live; None where nobody has looked at it."""
    text = fate.mutant.text()
    for one in reviews():
        if fate.chip in one.chips and one.change.fullmatch(text):
            return one.reason
    return None


def matrix(fates: Iterable[Fate]) -> str:
    """Return the kill matrix: kinds of change by what became of them."""
    fates = list(fates)
    counts = Counter((fate.mutant.kind, fate.end) for fate in fates)
    checks = [*sorted({fate.end for fate in fates if fate.killed}), *APART]
    kinds = sorted({kind for kind, _ in counts})
    rows = [["", *checks, "all"]]
    for kind in kinds:
        row = [counts[kind, check] for check in checks]
        rows.append([kind, *(str(count or ".") for count in row), str(sum(row))])
    sums = [sum(counts[kind, check] for kind in kinds) for check in checks]
    rows.append(["all", *map(str, sums), str(sum(sums))])
    widths = [max(len(row[at]) for row in rows) for at in range(len(rows[0]))]
    return "\n".join(
        "  ".join(
            cell.ljust(width) if at == 0 else cell.rjust(width)
            for at, (cell, width) in enumerate(zip(row, widths, strict=True))
        )
        for row in rows
    )


def summary(fates: Iterable[Fate]) -> str:
    """Return a line per program."""
    fates, rows = list(fates), []
    for role, chip in PROGRAMS:
        mine = [one for one in fates if (one.role, one.chip) == (role, chip)]
        ends = Counter(one.end for one in mine)
        listed = sum(one.end == SURVIVED and reason_for(one) is not None for one in mine)
        rows.append(
            f"{role} {chip}: {len(mine) - ends[NOT_COMPILED]} mutants, "
            f"{sum(one.killed for one in mine)} killed, {ends[EQUIVALENT]} with the same "
            f"image, {ends[PROVEN]} proven equal, "
            f"{listed} survive and are reviewed, {ends[SURVIVED] - listed} survive"
        )
    return "\n".join(rows)


def unreviewed(fates: Iterable[Fate]) -> list[Fate]:
    """Return the survivors without a reason."""
    return [one for one in fates if one.end == SURVIVED and reason_for(one) is None]


def main() -> int:
    """Judge, print matrix and survivors; 1 where one is not reviewed."""
    words = sys.argv[1:]
    number = None if "--all" in words else next((int(w) for w in words if w.isdigit()), MUTANTS)
    began_s = time.monotonic()
    fates = list(proven(judge_all(number, workers=2)))
    fresh = unreviewed(fates)
    for role, chip in PROGRAMS:
        click.echo(f"\n{role} {chip}\n")
        click.echo(matrix(one for one in fates if (one.role, one.chip) == (role, chip)))
    click.echo("\nsurvivors that were looked at:")
    for one in fates:
        if one.end == PROVEN or (one.end == SURVIVED and reason_for(one)):
            click.echo(f"  {one.role} {one.chip} line {one.mutant.line}, {one.mutant.text()}")
            click.echo(f"      {reason_for(one) or one.reason}")
    click.echo("\nsurvivors that nobody has looked at:" if fresh else "\nno other survivors")
    for one in fresh:
        click.echo(f"  {one.role} {one.chip} line {one.mutant.line}, {one.mutant.text()}")
    click.echo(f"\n{summary(fates)}\n{time.monotonic() - began_s:.0f} s")
    return 1 if fresh else 0


if __name__ == "__main__":
    sys.exit(main())
