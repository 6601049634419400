"""The kill matrix: as a table for people, in a line per program, and as a file for reports."""

import json
from collections import Counter
from collections.abc import Iterable
from typing import Any

from cgagen.outputs import begins
from hil.fate import (
    APART,
    EQUIVALENT,
    FREE_PROGRAMS,
    NOT_COMPILED,
    PROGRAMS,
    PROVEN,
    SURVIVED,
    Fate,
    reason_for,
)
from hil.subject import CHIPS, Subject

FORMAT = "cgagen-kills-1"

MATRIX = begins("a kill matrix", f'{{\n "format": "{FORMAT}"')


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
    for role, chip in (*PROGRAMS, *FREE_PROGRAMS):
        mine = [one for one in fates if (one.role, one.chip) == (role, chip)]
        if not mine:
            continue
        ends = Counter(one.end for one in mine)
        listed = sum(one.end == SURVIVED and reason_for(one) is not None for one in mine)
        rows.append(
            f"{role} {chip}: {len(mine) - ends[NOT_COMPILED]} mutants, "
            f"{sum(one.killed for one in mine)} killed, {ends[EQUIVALENT]} with the same "
            f"image, {ends[PROVEN]} proven equal, "
            f"{listed} survive and are reviewed, {ends[SURVIVED] - listed} survive"
        )
    return "\n".join(rows)


def record_of(subject: Subject, fates: Iterable[Fate]) -> dict[str, Any]:
    """Return one robot's kill matrix as a value that JSON can hold.

    Args:
        subject: the programs that were changed.
        fates: of their mutants, in any order; other robots' are left out.

    Returns:
        `format`, `robot`, `image` (SHA-256 of the main controller's), `images` by chip; `rows` by
        chip and kind of change: `mutants` are those that compile, `by` counts the killed by the
        check that has noticed them; `survivors` with the reason why each is let live, null
        where nobody has looked; `proven`, those that decide alike everywhere.
    """
    mine = sorted(
        (one for one in fates if one.role == subject.role and one.end != NOT_COMPILED),
        key=lambda one: (CHIPS.index(one.chip), one.mutant),
    )
    programs = {(one.chip, one.mutant.kind): None for one in mine}
    return {
        "format": FORMAT,
        "robot": subject.robot.name,
        "image": subject.images["main"].digest,
        "images": {chip: subject.images[chip].digest for chip in CHIPS},
        "rows": [
            {"chip": chip, "kind": kind}
            | _counts([one for one in mine if (one.chip, one.mutant.kind) == (chip, kind)])
            for chip, kind in programs
        ],
        "survivors": [_told(one, reason_for(one)) for one in mine if one.end == SURVIVED],
        "proven": [_told(one, one.reason) for one in mine if one.end == PROVEN],
    }


def record_text(record: dict[str, Any]) -> str:
    """Return the record as a file holds it; the same fates give the same bytes."""
    return json.dumps(record, indent=1) + "\n"


def _counts(fates: list[Fate]) -> dict[str, Any]:
    ends = Counter(one.end for one in fates)
    killed = Counter(one.end for one in fates if one.killed)
    return {
        "mutants": len(fates),
        "killed": killed.total(),
        "equal": ends[PROVEN],
        "same_image": ends[EQUIVALENT],
        "survivors": ends[SURVIVED],
        "by": dict(sorted(killed.items())),
    }


def _told(fate: Fate, reason: str | None) -> dict[str, Any]:
    line, kind = fate.mutant.line, fate.mutant.kind
    change = fate.mutant.text().removeprefix(f"{kind}: ")
    return {"chip": fate.chip, "line": line, "kind": kind, "change": change, "reason": reason}
