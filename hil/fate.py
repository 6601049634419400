"""What became of a mutant, and which survivors somebody has looked at."""

import re
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from hil.mutate import Mutant
from hil.subject import CHIPS

SURVIVORS = Path(__file__).parent / "survivors.toml"
ROLES = ("predator", "prey")
PROGRAMS = tuple((role, chip) for role in ROLES for chip in CHIPS)

NOT_COMPILED, EQUIVALENT, SURVIVED = "does not compile", "same image", "survived"
PROVEN = "proven equal"
"""No check notices it, and no check could: `hil.proof` shows that it decides alike everywhere."""

APART = (NOT_COMPILED, EQUIVALENT, PROVEN, SURVIVED)


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


def unreviewed(fates: Iterable[Fate]) -> list[Fate]:
    """Return the survivors without a reason."""
    return [one for one in fates if one.end == SURVIVED and reason_for(one) is None]
