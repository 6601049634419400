"""Which lines of a PBASIC source were executed, and which way its decisions went.

Nothing is added to the program: the chip counts its instructions (`Chip.cover`), and the source
map says which line each of them came from.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass

from cgagen.emulator.chip import Coverage
from cgagen.outputs import begins
from cgagen.stamp.compiled import Compiled, Statement
from cgagen.stamp.decode import decode
from cgagen.stamp.program import Instruction, Program
from cgagen.stamp.scan import lines_of

_WORDS: dict[str, tuple[str, str]] = {
    "IF": ("false", "true"),
    "NEXT": ("left", "again"),
    "BRANCH": ("past the list", "in the list"),
    "BUTTON": ("went on", "to its label"),
}
"""Instructions that decide: going on behind themselves, and jumping."""

TEST_NAME = "TN:cgagen"
"""First line of a tracefile: the name of the test, as LCOV has it, and whose file it is."""

LISTING_TITLE = "coverage of "
"""What a listing begins with."""

TRACEFILE = begins("coverage", TEST_NAME + "\n")
LISTING = begins("a listing of coverage", LISTING_TITLE)

_LABELLED = ("went on", "to a label")
"""Serial instructions with a label for time-out or parity."""

_NO_LINE = re.compile(r"(ELSE|ENDIF|ENDSELECT|CASE\s+ELSE)\b", re.IGNORECASE)
"""Words that emit nothing of their own: the GOTO that ends the part before stands there."""

_AFTER_GOTO = re.compile(r"(CASE|ELSEIF)\b", re.IGNORECASE)
"""Words whose own instructions come behind such a GOTO."""


@dataclass(frozen=True, slots=True)
class Decision:
    """An instruction that may jump.

    Attributes:
        bit: its stream address.
        ways: in words, going on and jumping.
        counts: how often each; None where it was never come to.
    """

    bit: int
    ways: tuple[str, str]
    counts: tuple[int, int] | None

    @property
    def taken(self) -> int:
        """How many of its two ways were gone."""
        return sum(1 for count in self.counts or () if count)


@dataclass(frozen=True, slots=True)
class LineCoverage:
    """A line of a source that emits instructions.

    Attributes:
        line: from 1.
        count: how often it was executed; of several statements, the one that was most often.
        decisions: on this line.
    """

    line: int
    count: int
    decisions: tuple[Decision, ...]


@dataclass(frozen=True, slots=True)
class SourceCoverage:
    """A whole source.

    Attributes:
        name: of its file.
        source: its text.
        lines: those that emit instructions, ascending.
    """

    name: str
    source: str
    lines: tuple[LineCoverage, ...]

    @property
    def lines_hit(self) -> int:
        """Lines that were executed."""
        return sum(1 for line in self.lines if line.count)

    @property
    def ways(self) -> tuple[int, int]:
        """Ways of decisions that were gone, and all of them."""
        decisions = [one for line in self.lines for one in line.decisions]
        return sum(one.taken for one in decisions), 2 * len(decisions)

    @property
    def summary(self) -> str:
        """One line of text."""
        gone, ways = self.ways
        return (
            f"{self.name}: {self.lines_hit} of {len(self.lines)} lines, {gone} of {ways} branches"
        )


def cover_source(compiled: Compiled, coverage: Coverage, slot: int = 0) -> SourceCoverage:
    """Return what of a source was executed.

    Args:
        compiled: the source, as it was when the program started.
        coverage: of its chip.
        slot: where the program was.
    """
    image = compiled.image
    program = decode(image.eeprom, image.model, image.flags)
    counts: dict[int, int] = {}
    for statement, instruction in _statements(compiled, program):
        times = coverage.counts[slot, instruction.address]
        counts[statement.line] = max(times, counts.get(statement.line, 0))
    decisions: dict[int, list[Decision]] = {}
    for instruction in program.instructions:
        ways = _ways(instruction)
        at = compiled.source_map.at_bit(instruction.address)
        if ways and at is not None:
            gone = coverage.branches.get((slot, instruction.address))
            taken = None if gone is None else (gone[0], gone[1])
            decisions.setdefault(at.line, []).append(Decision(instruction.address, ways, taken))
    lines = (
        LineCoverage(line, counts[line], tuple(decisions.get(line, ()))) for line in sorted(counts)
    )
    return SourceCoverage(compiled.name, compiled.source, tuple(lines))


def lcov(sources: Sequence[SourceCoverage]) -> str:
    """Return a tracefile of LCOV's: genhtml and most editors read it.

    Branch 0 of a decision goes on behind it, branch 1 jumps.
    """
    rows: list[str] = []
    for one in sources:
        rows += [TEST_NAME, f"SF:{one.name}"]
        for line in one.lines:
            for block, decision in enumerate(line.decisions):
                for way in (0, 1):
                    taken = "-" if decision.counts is None else decision.counts[way]
                    rows.append(f"BRDA:{line.line},{block},{way},{taken}")
        gone, ways = one.ways
        rows += [f"BRF:{ways}", f"BRH:{gone}"]
        rows += [f"DA:{line.line},{line.count}" for line in one.lines]
        rows += [f"LF:{len(one.lines)}", f"LH:{one.lines_hit}", "end_of_record"]
    return "\n".join(rows) + "\n"


def coverage_listing(sources: Sequence[SourceCoverage]) -> str:
    """Return the sources with a count before each line, `-----` where it was never executed."""
    rows: list[str] = []
    for one in sources:
        rows += [LISTING_TITLE + one.summary, ""]
        known = {line.line: line for line in one.lines}
        for number, text in enumerate(lines_of(one.source), 1):
            line = known.get(number)
            count = "" if line is None else str(line.count or "-----")
            rows.append(f"{count:>9} {number:>5}  {text}".rstrip())
            for decision in line.decisions if line else ():
                rows.append(f"{'':17}' {_told(decision)}")
        rows.append("")
    return "\n".join(rows)


def _told(decision: Decision) -> str:
    if decision.counts is None:
        return "never decided"
    ways = zip(decision.ways, decision.counts, strict=True)
    return ", ".join(f"{way} {count or 'never'}" for way, count in ways)


def _ways(instruction: Instruction) -> tuple[str, str] | None:
    if instruction.name.startswith(("SERIN", "SEROUT")):
        return _LABELLED if instruction.targets else None
    return _WORDS.get(instruction.name)


def _statements(compiled: Compiled, program: Program) -> list[tuple[Statement, Instruction]]:
    """Return the statements that emit something, each with the instruction that tells its count."""
    statements = compiled.source_map.statements
    found = []
    for index, statement in enumerate(statements):
        nexts = statements[index + 1].bit if index + 1 < len(statements) else None
        text = compiled.source[statement.offset : statement.offset + 40]
        if nexts == statement.bit or _NO_LINE.match(text):
            continue
        instruction = program.at(statement.bit)
        if instruction is not None and instruction.name == "GOTO" and _AFTER_GOTO.match(text):
            instruction = program.at(instruction.end)
        if instruction is not None:
            found.append((statement, instruction))
    return found
