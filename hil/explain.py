"""Which line of PBASIC made a decision that is wrong."""

import re
from collections.abc import Sequence
from typing import NamedTuple

from cgagen.stamp.scan import lines_of
from cgagen.words import Role

MOST_LINES = 3

_CONSTANT = re.compile(r"^(\w+)\s+CON\s+(\d+)\b")
"""That a report names. Choice."""

TABLES = {Role.PREDATOR: "Genes", Role.PREY: "Answers"}
"""Labels of the tables that `Decide` reads."""


class Line(NamedTuple):
    """A line of a source."""

    file: str
    number: int
    text: str

    def __str__(self) -> str:
        return f"{self.file}:{self.number}: {self.text.strip()}"


def table_line(source: str, file: str, role: Role, state: int) -> Line | None:
    """Return the line of DATA that holds the command of a state; None where it is not found."""
    lines = lines_of(source)
    first = next(
        (n for n, line in enumerate(lines) if re.match(rf"{TABLES[role]}\s+DATA\s", line)), None
    )
    if first is None:
        return None
    for number in range(first, len(lines)):
        code = lines[number].partition("'")[0]
        if "DATA" not in code:
            return None
        values = code.partition("DATA")[2].count(",") + 1
        if state < values:
            return Line(file, number + 1, lines[number])
        state -= values
    return None


def last_lines(source: str, file: str, passed: Sequence[int]) -> tuple[Line, ...]:
    """Return the last lines that a program went through which did not come back from there."""
    lines = lines_of(source)
    numbers = list(dict.fromkeys(reversed(passed)))[:MOST_LINES]
    return tuple(Line(file, number, lines[number - 1]) for number in numbers)


def deciding_lines(
    source: str, file: str, passed: Sequence[int], variable: str, counts: Sequence[int]
) -> tuple[Line, ...]:
    """Return the lines that a decision went through and that concern a variable.

    Args:
        source: the program's text.
        file: its name.
        passed: line numbers in the order of execution.
        variable: what has the wrong value.
        counts: of the stimulus; a line that compares with a constant beside one of them comes
            first, the later lines before the earlier ones.
    """
    lines = lines_of(source)
    constants = dict(found for line in lines for found in _CONSTANT.findall(line))
    near = {str(count + step) for count in counts if count for step in (-1, 0, 1)}
    found = []
    for number in dict.fromkeys(reversed(passed)):
        code = lines[number - 1].partition("'")[0]
        if re.search(rf"\b{variable}\s*=", code):
            words = {constants.get(word, word) for word in re.findall(r"\w+", code)}
            found.append((not words & near, Line(file, number, lines[number - 1])))
    return tuple(line for _, line in sorted(found, key=lambda row: row[0]))[:MOST_LINES]
