"""What became of a mutant, and which survivors somebody has looked at."""

import re
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from cgagen.errors import RunError
from cgagen.inputs import REVIEWS, read_text
from cgagen.notations import parse_toml
from cgagen.shown import short
from hil.mutate import Mutant
from hil.subject import CHIPS

SURVIVORS = Path(__file__).parent / "survivors.toml"
ROLES = ("predator", "prey")
PROGRAMS = tuple((role, chip) for role in ROLES for chip in CHIPS)

FREE = {f"{role}-free": role for role in ROLES}
"""The same robots built for three lines alone, without a step line."""

FREE_PROGRAMS = tuple((role, chip) for role in FREE for chip in CHIPS)

NOT_COMPILED, EQUIVALENT, SURVIVED = "does not compile", "same image", "survived"
PROVEN = "proven equal"
"""No check notices it, and no check could: `hil.proof` shows that it decides alike everywhere."""

APART = (NOT_COMPILED, EQUIVALENT, PROVEN, SURVIVED)


@dataclass(frozen=True, slots=True)
class Fate:
    """What became of a mutant.

    Attributes:
        role: of the robot, or a name in `FREE`.
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
        most: so many survivors of one program at most; None for all that there are.
    """

    chips: tuple[str, ...]
    change: re.Pattern[str]
    reason: str
    most: int | None = None


def read_reviews(path: Path) -> dict[str, Any]:
    """Return the content of a list of reviews.

    Raises:
        RunError: it cannot be read, or is not TOML.
    """
    try:
        return parse_toml(read_text(path, REVIEWS))
    except ValueError as error:
        raise RunError(f"{path}: is not TOML ({error}); {REVIEWS.mend}") from error


@cache
def reviews(path: Path = SURVIVORS) -> tuple[Review, ...]:
    """Return the list."""
    rows = read_reviews(path).get("survivor", [])
    try:
        return tuple(
            Review(tuple(row["chips"]), re.compile(row["change"]), row["reason"], row.get("most"))
            for row in rows
        )
    except (KeyError, TypeError, AttributeError, re.error, RecursionError) as error:
        raise bad_row(path, error) from error


def bad_row(path: Path, error: Exception) -> RunError:
    """Return the refusal of a row that lacks a key, or has something else under it."""
    return RunError(f"{path}: a row is not as the others ({short(str(error))}); {REVIEWS.mend}")


def reason_for(fate: Fate) -> str | None:
    """Return why a survivor is let live; None where nobody has looked at it."""
    review = _review_of(fate)
    return review.reason if review else None


def unreviewed(fates: Iterable[Fate]) -> list[Fate]:
    """Return the survivors without a reason, and those of a reason that has too many."""
    survivors = [one for one in fates if one.end == SURVIVED]
    found = [(one.role, one.chip, _review_of(one)) for one in survivors]
    counts = Counter(found)
    return [
        one
        for one, key in zip(survivors, found, strict=True)
        if key[2] is None or (key[2].most is not None and counts[key] > key[2].most)
    ]


def _review_of(fate: Fate) -> Review | None:
    text = fate.mutant.text()
    for one in reviews():
        if fate.chip in one.chips and one.change.fullmatch(text):
            return one
    return None
