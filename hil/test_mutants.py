"""Mutants of the firmware: what the list has in it, and that the checks notice a sample of it."""

import json
import re
from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from cgagen.tokenizer import compile_source
from hil import covered
from hil.fate import (
    EQUIVALENT,
    FREE_PROGRAMS,
    NOT_COMPILED,
    PROGRAMS,
    PROVEN,
    SURVIVED,
    Fate,
    reviews,
    unreviewed,
)
from hil.judge_legs import judge_legs
from hil.judge_main import judge_main
from hil.kill import judge, main, proven, subject_for
from hil.kills import matrix, record_of, record_text, summary
from hil.main_wanted import wanted_of
from hil.mutate import Mutant, all_mutants, choose

pytestmark = pytest.mark.hil_req("CHECKS")

SAMPLE = {"main": 14, "locomotion": 7}
"""Mutants of each program, all kinds in turn. Choice: `make hil-mutants` has them by hundreds."""

KINDS = {
    "main": {
        "comparison", "constant", "index", "label", "logic", "lost line", "masking", "operator",
        "order", "pin", "rows", "table", "threshold",
    },
    "locomotion": {
        "comparison", "constant", "index", "label", "logic", "lost line", "operator", "order",
        "pin", "rows", "table",
    },
}  # fmt: skip


@pytest.mark.parametrize(("role", "chip"), PROGRAMS)
def test_every_kind_of_slip_is_made_and_always_the_same(role: str, chip: str) -> None:
    source = subject_for(role).sources[chip]
    mutants = all_mutants(source)
    counts = Counter(one.kind for one in mutants)
    assert counts.keys() | {"masking"} == KINDS[chip] | {"masking"}
    assert len(mutants) > 500
    assert len({one.apply(source) for one in mutants} - {source}) >= 0.97 * len(mutants)
    assert choose(mutants, 215) == choose(all_mutants(source), 215)
    for one in mutants:
        assert one.apply(source).count("\n") == source.count("\n")


def test_comments_and_texts_are_left_alone() -> None:
    source = (
        "x VAR Byte ' 7 < 8\nTable DATA 1, 2 ' 3\n  IF x < 3 THEN Go ' 4\n"
        + '  SEROUT 1, ["5 < 6"]'
    )
    for one in all_mutants(source):
        changed = one.apply(source)
        assert "' 7 < 8" in changed
        assert '"5 < 6"' in changed or one.kind in ("lost line", "order")
    texts = {one.text() for one in all_mutants(source)}
    assert "comparison: IF x < 3 THEN Go -> IF x <= 3 THEN Go" in texts
    assert "table: Table DATA 1, 2 -> Table DATA 1, 3" in texts


@pytest.fixture(scope="session")
def sampled() -> list[Fate]:
    fates = []
    for role, chip in PROGRAMS:
        source = subject_for(role).sources[chip]
        fates += [judge(role, chip, one) for one in choose(all_mutants(source), SAMPLE[chip])]
    return fates


def test_a_sample_of_the_mutants_is_killed(sampled: list[Fate]) -> None:
    survivors = [
        f"{one.role} {one.chip} {one.mutant.text()}" for one in unreviewed(proven(sampled))
    ]
    assert not survivors
    judged = [one for one in sampled if one.end != NOT_COMPILED]
    assert sum(one.killed for one in judged) >= 0.8 * len(judged)
    assert len(judged) >= 0.9 * 2 * sum(SAMPLE.values())
    assert len({one.end for one in judged}) >= 5
    assert re.search(r"^comparison +", matrix(sampled), re.M)


def test_a_sample_on_three_lines_is_killed() -> None:
    fates = []
    for role, chip in FREE_PROGRAMS:
        source = subject_for(role).sources[chip]
        assert "StepLine" not in source
        fates += [judge(role, chip, one) for one in choose(all_mutants(source), SAMPLE[chip] // 2)]
    survivors = [f"{one.role} {one.chip} {one.mutant.text()}" for one in unreviewed(proven(fates))]
    assert not survivors
    judged = [one for one in fates if one.end != NOT_COMPILED]
    assert sum(one.killed for one in judged) >= 0.8 * len(judged)


def test_a_survivor_that_nobody_has_looked_at_is_told() -> None:
    new = Fate("predator", "main", Mutant("order", 1, "  a = 1", "  a = 2"), SURVIVED)
    assert unreviewed([new]) == [new]
    assert all(len(reason.split()) > 4 for reason in (one.reason for one in reviews()))


def test_more_survivors_of_one_kind_than_were_looked_at_are_told() -> None:
    lost = [Mutant("lost line", line, "  GOSUB Pulses", "") for line in range(4)]
    fates = [Fate("prey", "locomotion", one, SURVIVED) for one in lost]
    other = [replace(one, role="predator") for one in fates[:2]]
    assert unreviewed([*fates[:3], *other]) == []
    assert unreviewed([*fates, *other]) == fates


def test_the_matrix_is_a_file_that_reports_can_read() -> None:
    changes = [Mutant("order", line, "  a = 1", f"  a = {line}") for line in range(6)]
    listed = next(
        one
        for one in all_mutants(subject_for("prey").sources["main"])
        if one.text().startswith("lost line: LOW Sonar")
    )
    ends = ["decide", "lines", "decide", NOT_COMPILED, EQUIVALENT, PROVEN]
    fates = [Fate("prey", "main", one, end, "why") for one, end in zip(changes, ends, strict=True)]
    fates += [
        Fate("prey", "main", listed, SURVIVED),
        Fate("prey", "locomotion", changes[0], SURVIVED),
        Fate("predator", "main", changes[0], SURVIVED),
    ]
    record = record_of(subject_for("prey"), fates)
    assert record_text(record) == record_text(record_of(subject_for("prey"), fates[::-1]))
    assert json.loads(record_text(record)) == record
    assert (record["format"], record["robot"]) == ("cgagen-kills-1", "servobot-prey")
    assert record["images"]["locomotion"] == subject_for("prey").images["locomotion"].digest
    rows = [(row["chip"], row["kind"], *list(row.values())[2:]) for row in record["rows"]]
    assert rows == [
        ("main", "lost line", 1, 0, 0, 0, 1, {}),
        ("main", "order", 5, 3, 1, 1, 0, {"decide": 2, "lines": 1}),
        ("locomotion", "order", 1, 0, 0, 0, 1, {}),
    ]
    assert [(one["line"], bool(one["reason"])) for one in record["survivors"]] == [
        (listed.line, True),
        (0, False),
    ]
    assert [one["change"] for one in record["proven"]] == ["a = 1 -> a = 5"]
    assert "prey main: 6 mutants, 3 killed, 1 with the same image, 1 proven" in summary(fates)


def test_a_matrix_is_of_one_robot(tmp_path: Path) -> None:
    done = CliRunner().invoke(main, ["--out", str(tmp_path / "kills.json")])
    assert (done.exit_code, list(tmp_path.iterdir())) == (2, [])
    assert "say which, with --robot" in done.output
    far = ["--robot", "prey", "--out", str(tmp_path / "nowhere" / "kills.json")]
    assert "there is no folder" in " ".join(CliRunner().invoke(main, far).output.split())


@pytest.mark.parametrize("role", ["predator", "prey"])
def test_the_firmware_itself_passes_and_all_of_it_is_met(role: str) -> None:
    for chip in ("main", "locomotion"):
        one = covered.cover(role, chip)
        known = covered.reviewed_lines()
        assert [line for line in one.missed() if f"{chip} {line}" not in known] == []
        gone, ways = one.source.ways
        assert one.source.lines_hit == len(one.source.lines) > 100
        assert gone == ways > 50
        if (role, chip) == ("predator", "main"):
            assert one.genes == frozenset(range(64))


def test_the_checks_name_what_they_find() -> None:
    subject = subject_for("prey")
    source = subject.sources["main"].replace("IF nearest < Alarm", "IF nearest <= Alarm")
    with pytest.raises(Exception, match=r"decide: 0,0,0,0,0,7079/--|decide: .*7079.*"):
        judge_main(subject, wanted_of(subject), compile_source(source, "main.bsp").image)
    source = subject.sources["locomotion"].replace("PULSOUT PinLiftRM", "PULSOUT PinLiftRR", 1)
    with pytest.raises(Exception, match="gaps: servo 9 has no pulse"):
        judge_legs(subject, compile_source(source, "locomotion.bs2").image)
