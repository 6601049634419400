"""Which mutants the checks kill: each is compiled, tried on the emulator, and counted.

A mutant that is refused by the tokenizer is none; one with the same image is equivalent and
apart; one that no check notices survives, and stands in `survivors.toml` with a reason or fails
the run.
"""

import re
import sys
import time
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import cache
from pathlib import Path

import click

from cgagen.errors import CgagenError, LackingError, SourceError
from cgagen.files import write_text
from cgagen.outputs import check_outputs
from cgagen.tokenizer import Tokenizer, compile_source
from hil.emulated import BROKEN
from hil.fate import (
    EQUIVALENT,
    FREE,
    FREE_PROGRAMS,
    NOT_COMPILED,
    PROGRAMS,
    PROVEN,
    ROLES,
    SURVIVED,
    Fate,
    reason_for,
    unreviewed,
)
from hil.judge_legs import judge_legs
from hil.judge_main import judge_main
from hil.kills import MATRIX, matrix, record_of, record_text, summary
from hil.main_wanted import Wanted, wanted_of
from hil.mutate import Mutant, all_mutants, choose
from hil.proof import Proof, prove
from hil.rates import freed
from hil.subject import CHIPS, Subject, read_subject
from hil.trial import FailedCheck

FIRMWARE = Path(__file__).parent.parent / "firmware"

MUTANTS = 215
"""Of each program in a full run; some do not compile. Choice: at least 200 are to be judged."""

IMPOSSIBLE = "electric"
"""The check that kills what the bench or the chip cannot do, such as outputs that fight."""

LACKING = "unproven"
"""The end of those that no check finds wrong and that cannot be judged in full: UNPROVEN, and so
no PASS, for its user."""


@cache
def subject_for(role: str) -> Subject:
    """Return the checked-in firmware of a robot, or the same robot's for three lines."""
    if role in FREE:
        with Tokenizer() as tokenizer:
            return freed(read_subject(FIRMWARE / FREE[role]), tokenizer)
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
            judge_main(subject, _wanted(role), compiled.image)
        else:
            judge_legs(subject, compiled.image)
    except FailedCheck as failed:
        return Fate(role, chip, mutant, failed.check, failed.reason)
    except LackingError as error:
        return Fate(role, chip, mutant, LACKING, str(error))
    except BROKEN as error:
        return Fate(role, chip, mutant, IMPOSSIBLE, str(error))
    except Exception as error:  # a bug of a check is no kill: it ends the run, and says where
        error.add_note(f"while {role} {chip} line {mutant.line} was judged: {mutant.text()}")
        raise
    return Fate(role, chip, mutant, SURVIVED)


def judge_all(
    number: int | None, workers: int = 1, roles: tuple[str, ...] = ROLES
) -> Iterator[Fate]:
    """Judge so many mutants of each program, or all of them, in a fixed order."""
    work = []
    for role, chip in ((role, chip) for role in roles for chip in CHIPS):
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


@click.command()
@click.argument("number", type=click.IntRange(1), default=MUTANTS)
@click.option("--all", "every", is_flag=True, help="All mutants that there are.")
@click.option("--robot", type=click.Choice((*ROLES, *FREE)), help="This robot's programs alone.")
@click.option("--out", type=click.Path(path_type=Path), help="The matrix as JSON, of one --robot.")
@click.option("--force", is_flag=True, help="Overwrite what is no matrix of ours.")
def main(number: int, every: bool, robot: str | None, out: Path | None, force: bool) -> None:
    """Judge NUMBER mutants of each program; print matrix and survivors.

    Ends with 1 where a survivor is not reviewed.
    """
    if out is not None and robot not in ROLES:
        raise click.UsageError("--out holds one robot's matrix: say which, with --robot")
    if out is not None:
        try:
            check_outputs([(out, MATRIX)], force=force)
        except CgagenError as error:
            raise click.UsageError(f"--out: {error}") from error
    began_s = time.monotonic()
    roles = ROLES if robot is None else (robot,)
    fates = list(proven(judge_all(None if every else number, workers=2, roles=roles)))
    click.echo(_told(fates))
    click.echo(f"\n{summary(fates)}\n{time.monotonic() - began_s:.0f} s")
    if out is not None and robot is not None:
        write_text(out, record_text(record_of(subject_for(robot), fates)))
    sys.exit(1 if unreviewed(fates) else 0)


def _told(fates: list[Fate]) -> str:
    """Return the matrix of each program, and all survivors."""
    rows = []
    for role, chip in (*PROGRAMS, *FREE_PROGRAMS):
        mine = [one for one in fates if (one.role, one.chip) == (role, chip)]
        rows += [f"\n{role} {chip}\n", matrix(mine)] if mine else []
    rows.append("\nsurvivors that were looked at:")
    for one in fates:
        if one.end == PROVEN or (one.end == SURVIVED and reason_for(one)):
            rows.append(f"  {_place(one)}\n      {reason_for(one) or one.reason}")
    fresh = unreviewed(fates)
    rows.append("\nsurvivors that nobody has looked at:" if fresh else "\nno other survivors")
    return "\n".join([*rows, *(f"  {_place(one)}" for one in fresh)])


def _place(fate: Fate) -> str:
    return f"{fate.role} {fate.chip} line {fate.mutant.line}, {fate.mutant.text()}"


if __name__ == "__main__":
    main()
