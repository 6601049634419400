"""Line and branch coverage of PBASIC, counted by the chip itself."""

import pytest

from cgagen.emulator.coverage_report import (
    SourceCoverage,
    cover_source,
    coverage_listing,
    lcov,
)
from cgagen.emulator.programs import bench_of_sources
from cgagen.tokenizer import Tokenizer

LIMIT_NS = 5_000_000_000

HEAD = "' {$STAMP BS2}\n' {$PBASIC 2.5}\nx VAR Byte\ny VAR Byte\n"

SOURCE = (
    HEAD
    + """\
FOR x = 1 TO 3
  SELECT x
    CASE 1
      y = y + 1
    CASE 5
      y = 99
    CASE ELSE
      y = y + 10
  ENDSELECT
  IF y > 15 THEN
    y = 0
  ELSEIF y = 1 THEN
    y = 2
  ELSE
    y = 3 : IF x = 9 THEN y = 8
  ENDIF
NEXT
DO WHILE x < 3
  x = 0
LOOP
BRANCH x, [Never]
GOTO Done
Never:
y = 77
Done:
END
"""
)
# x = 1: y becomes 1, then 2. x = 2: 12, then 3. x = 3: 13, then 3. Behind the loop x is 4.

COUNTS = {
    5: 1,  # FOR
    7: 3,  # CASE 1
    8: 1,
    9: 2,  # CASE 5
    10: 0,
    12: 2,
    14: 3,  # IF
    15: 0,
    16: 3,  # ELSEIF
    17: 1,
    19: 2,
    21: 3,  # NEXT
    22: 1,  # DO WHILE
    23: 0,
    24: 0,  # LOOP
    25: 1,  # BRANCH
    26: 1,
    28: 0,
    30: 1,
}

BRANCHES = {  # on or false, jump or true
    7: [(2, 1)],
    9: [(2, 0)],
    14: [(3, 0)],
    16: [(2, 1)],
    19: [(2, 0)],
    21: [(1, 2)],
    22: [(1, 0)],
    25: [(1, 0)],
}


def cover(tokenizer: Tokenizer, source: str, name: str = "it.bs2") -> SourceCoverage:
    compiled = tokenizer.compile(source, name)
    bench = bench_of_sources({0: compiled})
    chip = bench.chip("main")
    counted = chip.cover()
    bench.run(LIMIT_NS)
    return cover_source(compiled, counted)


@pytest.fixture(scope="module")
def covered(tokenizer: Tokenizer) -> SourceCoverage:
    return cover(tokenizer, SOURCE)


def test_lines_are_counted(covered: SourceCoverage) -> None:
    assert {line.line: line.count for line in covered.lines} == COUNTS


def test_decisions_are_counted_both_ways(covered: SourceCoverage) -> None:
    found = {line.line: [one.counts for one in line.decisions] for line in covered.lines}
    assert {line: counts for line, counts in found.items() if counts} == BRANCHES


def test_sums(covered: SourceCoverage) -> None:
    assert covered.lines_hit == 14
    assert covered.ways == (11, 16)
    assert covered.summary == "it.bs2: 14 of 19 lines, 11 of 16 branches"


def test_lcov(covered: SourceCoverage) -> None:
    rows = lcov([covered, covered]).splitlines()
    assert rows[:4] == ["TN:cgagen", "SF:it.bs2", "BRDA:7,0,0,2", "BRDA:7,0,1,1"]
    assert [row for row in rows if row.startswith("DA:")] == 2 * [
        f"DA:{line},{count}" for line, count in COUNTS.items()
    ]
    for row in ("BRF:16", "BRH:11", "LF:19", "LH:14", "end_of_record"):
        assert rows.count(row) == 2


def test_listing(covered: SourceCoverage) -> None:
    rows = coverage_listing([covered]).splitlines()
    assert rows[0] == "coverage of it.bs2: 14 of 19 lines, 11 of 16 branches"
    assert "        3    21  NEXT" in rows
    assert "                 ' left 1, again 2" in rows
    assert "    -----    10        y = 99" in rows
    assert "             13    ENDSELECT" in rows
    assert "                 ' past the list 1, in the list never" in rows


def test_what_is_never_come_to(tokenizer: Tokenizer) -> None:
    covered = cover(
        tokenizer, HEAD + "END\nIF x = 1 THEN y = 2\nSERIN 1, 84, 5, Late, [x]\nLate:\n"
    )
    assert [(line.line, line.count) for line in covered.lines] == [(5, 1), (6, 0), (7, 0)]
    (serin,) = covered.lines[2].decisions
    assert (serin.counts, serin.taken) == (None, 0)
    assert "BRDA:7,0,1,-" in lcov([covered]).splitlines()
    assert "never decided" in coverage_listing([covered])


def test_instructions_with_a_label(tokenizer: Tokenizer) -> None:
    covered = cover(tokenizer, HEAD + "SERIN 16, 84, 5, Late, [x]\ny = 1\nLate:\ny = 2\n")
    counts = {line.line: line.count for line in covered.lines}
    assert counts == {5: 1, 6: 0, 8: 1}
    (serin,) = covered.lines[0].decisions
    assert (serin.counts, serin.ways) == ((0, 1), ("went on", "to a label"))


def test_coverage_changes_nothing_but_speed(tokenizer: Tokenizer) -> None:
    compiled = tokenizer.compile(SOURCE)
    seen = []
    for wanted in (False, True):
        bench = bench_of_sources({0: compiled})
        chip = bench.chip("main")
        if wanted:
            chip.cover()
        bench.run(LIMIT_NS)
        seen.append((chip.instructions, chip.local_ns, chip.registers["W0"], chip.pc))
    assert seen[0] == seen[1]
