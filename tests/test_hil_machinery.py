"""The bench itself on trial: planted faults must be found, sick targets must be named so."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from cgagen.errors import RigError, RunError
from cgagen.stamp.chips import EEPROM_BYTES
from cgagen.stamp.image import Image
from cgagen.tokenizer import Tokenizer
from hil.decisions import Decision, read_decisions, write_decisions
from hil.emulated import PinsTarget
from hil.equivalence import Verdict, compare
from hil.explainers import explainer, explainer_elsewhere
from hil.outcome import finding_lines
from hil.registers import RegisterTarget, calibration
from hil.simulated import SimulatedTarget
from hil.stimuli import Level, every_state, neutral, stimuli_of, thresholds
from hil.subject import Subject, read_subject
from hil.target import Observation, Stimulus
from hil.timing import try_timing
from hil.verify import try_sources, try_table, try_target, verify
from tests.subjects import FIRMWARE

ROLES = ("predator", "prey")


@pytest.fixture(scope="module", params=ROLES)
def subject(request: pytest.FixtureRequest) -> Subject:
    return read_subject(FIRMWARE / request.param)


@pytest.fixture(scope="module")
def predator() -> Subject:
    return read_subject(FIRMWARE / "predator")


@pytest.fixture(scope="module")
def registers(subject: Subject, tokenizer: Tokenizer) -> Iterator[RegisterTarget]:
    with RegisterTarget(subject, tokenizer.compile) as target:
        yield target


def with_image(subject: Subject, change: dict[int, int]) -> Subject:
    """A subject whose main image was changed behind its source's back."""
    image = subject.images["main"]
    eeprom = bytearray(image.eeprom)
    for address, value in change.items():
        eeprom[address] = value
    changed = Image(image.model, bytes(eeprom), slot=image.slot)
    return replace(subject, images={**subject.images, "main": changed})


def with_source(subject: Subject, tokenizer: Tokenizer, old: str, new: str) -> Subject:
    """A subject whose main source was changed and compiled."""
    assert subject.sources["main"].count(old) == 1, old
    source = subject.sources["main"].replace(old, new)
    image = tokenizer.compile(source, "main.bsp").image
    return replace(
        subject,
        sources={**subject.sources, "main": source},
        images={**subject.images, "main": image},
    )


def test_both_ways_into_the_emulator_agree_with_the_simulator(
    subject: Subject, registers: RegisterTarget
) -> None:
    trial = compare(subject, registers, stimuli_of(subject.robot, Level.SMOKE))
    assert (trial.verdict, trial.left_out, trial.stale) == (Verdict.PASS, 0, 0)
    assert trial.decisions == sum(trial.agreed.values()) > 500
    with PinsTarget(subject) as pins:
        few = [calibration(subject.robot), *list(every_state(subject.robot).values())[::5]]
        trial = compare(subject, pins, few)
        seen = pins.decide(few[0])
    assert (trial.verdict, trial.decisions) == (Verdict.PASS, len(few))
    assert seen.counts == few[0]
    assert 20_000_000 < (seen.latency_ns or 0) < 200_000_000


def test_every_sensor_count_that_pulsin_knows_arrives_as_presented(predator: Subject) -> None:
    with PinsTarget(predator) as pins:
        for sonars, lights in (((1, 2, 65_534), (1, 2)), ((0, 1, 0), (65_534, 0))):
            stimulus = Stimulus(sonars, (False, True), lights)
            assert pins.decide(stimulus).counts == stimulus
        assert not pins.admits(Stimulus((65_535, 0, 0), lights=(0, 0)))


def test_the_table_is_read_for_every_state(subject: Subject, registers: RegisterTarget) -> None:
    trial = try_table(subject, registers)
    assert trial.verdict is Verdict.PASS
    assert trial.decisions == (64 if subject.genome else 11)


def test_thresholds_come_with_one_less_and_one_more(predator: Subject) -> None:
    counts = predator.robot.situation_counts
    front = {one.sonars[0] for one in thresholds(predator.robot)}
    for limit in (counts.front_near, counts.front_middle, counts.front_far):
        assert {limit - 1, limit, limit + 1} <= front
    left = {one.lights[0] for one in thresholds(predator.robot) if one.lights[1] == 0}
    far = counts.lamp_left.range
    assert {far - 1, far, far + 1} <= left


def genes_at(subject: Subject, state: int) -> int:
    """Where a gene is in the image: the table's bytes are found, not looked up."""
    assert subject.genome is not None
    table = bytes(subject.genome.commands())
    return subject.images["main"].eeprom.index(table) + state


def test_a_planted_wrong_gene_fails_with_its_line(predator: Subject, tokenizer: Tokenizer) -> None:
    state = next(iter(s for s in every_state(predator.robot) if s > 20))
    at = genes_at(predator, state)
    wrong = with_image(predator, {at: predator.images["main"].eeprom[at] ^ 1})
    report = verify(wrong, tokenizer.compile)
    failed = {name for name, trial in report.trials.items() if trial.verdict is Verdict.FAIL}
    assert failed == {"sources", "table", "registers", "cells", "emulator", "conduct"}
    assert (report.verdict, report.verdict.exit_code) == (Verdict.FAIL, 9)
    small = report.smallest
    assert small is not None
    assert small.stimulus == every_state(predator.robot)[state]
    assert small.expected.state == state
    assert "DATA" in small.lines[0].text


def test_lines_are_named_where_the_program_decides_so_again(
    predator: Subject, tokenizer: Tokenizer
) -> None:
    """Not for a target that decides otherwise than its own program."""
    state, stimulus = next((s, one) for s, one in every_state(predator.robot).items() if s > 20)
    at = genes_at(predator, state)
    wrong = with_image(predator, {at: predator.images["main"].eeprom[at] ^ 1})
    for subject, named in ((wrong, 1), (predator, 0)):
        explain = explainer_elsewhere(subject, tokenizer.compile)
        with PinsTarget(wrong) as target:
            trial = compare(predator, target, [stimulus], explain)
        assert trial.smallest is not None
        assert len(trial.smallest.lines) == named


def test_a_gene_that_no_reading_reaches_fails_too(predator: Subject, tokenizer: Tokenizer) -> None:
    state = next(s for s in range(64) if s not in every_state(predator.robot))
    at = genes_at(predator, state)
    wrong = with_image(predator, {at: predator.images["main"].eeprom[at] ^ 7})
    with RegisterTarget(wrong, tokenizer.compile) as target:
        trial = try_table(wrong, target)
    assert trial.verdict is Verdict.FAIL
    assert [finding.expected.state for finding in trial.findings] == [state]


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("IF nearest < EchoFrontNear THEN", "IF nearest <= EchoFrontNear THEN"),
        ("lightLeft < LeftLampMiddle OR", "lightLeft > LeftLampMiddle OR"),
        ("FOR sonar = Front TO Left ", "FOR sonar = Left TO Front "),
    ],
)
def test_a_flipped_comparison_fails_with_its_line(
    predator: Subject, tokenizer: Tokenizer, old: str, new: str
) -> None:
    wrong = with_source(predator, tokenizer, old, new)
    assert try_sources(wrong, tokenizer.compile).verdict is Verdict.PASS
    with RegisterTarget(wrong, tokenizer.compile) as target:
        readings = stimuli_of(wrong.robot, Level.BOUNDARY)
        trial = compare(wrong, target, readings, explainer(wrong, target))
    small = trial.smallest
    assert trial.verdict is Verdict.FAIL
    assert small is not None
    assert small.stimulus is not None
    if "Echo" in old:
        assert small.stimulus == Stimulus((1966, 0, 0), (False, False), (0, 0))
    if "IF" in new:
        assert any(new in line.text for line in small.lines)


def test_a_source_of_other_bytes_fails(predator: Subject, tokenizer: Tokenizer) -> None:
    source = predator.sources["main"].replace("GoTime          CON     100", "GoTime CON 90")
    other = replace(predator, sources={**predator.sources, "main": source})
    trial = try_sources(other, tokenizer.compile)
    assert trial.verdict is Verdict.FAIL
    assert "main.bsp compiles to other bytes" in trial.reason


def test_wrong_pins_are_found_through_the_pins(predator: Subject, tokenizer: Tokenizer) -> None:
    wrong = with_source(
        predator, tokenizer, "SonarRight      PIN     5 ", "SonarRight      PIN     6 "
    )
    with PinsTarget(wrong) as pins:
        trial = compare(wrong, pins, [calibration(wrong.robot)])
    assert trial.verdict is Verdict.FAIL
    assert "measured" in trial.reason


def test_a_program_that_hangs_fails(predator: Subject, tokenizer: Tokenizer) -> None:
    wrong = with_source(predator, tokenizer, "  GOSUB Tell\n", "  STOP\n")
    with PinsTarget(wrong) as pins:
        trial = compare(wrong, pins, [neutral(wrong.robot)])
    assert (trial.verdict, trial.decisions) == (Verdict.FAIL, 1)
    assert "no decision" in trial.reason


class Odd(SimulatedTarget):
    """A target that misbehaves in a way of its choice."""

    url = "odd"

    def __init__(self, subject: Subject, way: str) -> None:
        super().__init__(subject)
        self._way, self._old, self._asked = way, None, 0

    _old: Observation | None

    def decide(self, stimulus: Stimulus) -> Observation:
        self._asked += 1
        if self._way == "dead":
            raise RigError("odd: does not answer; switch it on")
        fresh = super().decide(stimulus)
        if self._old is not None and (self._way == "stuck" or self._asked == 2):
            return self._old
        self._old = fresh
        return fresh


@pytest.mark.parametrize(
    ("way", "verdict", "stale"),
    [("dead", Verdict.BLOCKED, 0), ("late", Verdict.PASS, 1), ("stuck", Verdict.BLOCKED, 3)],
)
def test_a_sick_target_is_blocked_and_a_late_answer_is_counted(
    predator: Subject, way: str, verdict: Verdict, stale: int
) -> None:
    readings = list(every_state(predator.robot).values())
    trial = compare(predator, Odd(predator, way), readings)
    assert (trial.verdict, trial.stale) == (verdict, stale)


def test_a_program_that_comes_to_no_instruction_has_failed(
    predator: Subject, tokenizer: Tokenizer
) -> None:
    """Nothing is wrong with the bench: neither where it decides, nor where it begins."""
    compiled = tokenizer.compile(predator.sources["main"], "main.bsp")
    number = predator.sources["main"].partition("obstacle = MiddleFront")[0].count("\n") + 1
    bit = next(one.bit for one in compiled.source_map.statements if one.line == number)
    behind = EEPROM_BYTES - 2 - bit // 8
    broken = with_image(predator, {behind: 0xFF, behind - 1: 0xFF})
    trial = try_target(broken, lambda: PinsTarget(broken), [neutral(broken.robot)])
    assert trial.verdict is Verdict.FAIL
    assert "at the reading 0,0,0/--/0,0: on the emulator: main: slot 0" in trial.reason
    assert trial.smallest is not None
    empty = with_image(predator, dict.fromkeys(range(64, EEPROM_BYTES), 0xFF))
    for trial in (try_target(empty, lambda: PinsTarget(empty), []), try_timing(empty)[0]):
        assert trial.verdict is Verdict.FAIL
        assert "main: slot 0, stream bit" in trial.reason


def test_a_program_that_hangs_has_failed_with_the_line_where_it_does(
    predator: Subject, tokenizer: Tokenizer
) -> None:
    old = "nearest < EchoFrontNear THEN obstacle = NearFront\n"
    spin = "IF nearest = 1966 THEN Spin"
    hangs = with_source(predator, tokenizer, old, f"{old}Spin:\n      {spin}\n")
    readings = [neutral(hangs.robot), Stimulus((1966, 0, 0), lights=(0, 0))]
    with RegisterTarget(hangs, tokenizer.compile) as target, PinsTarget(hangs) as pins:
        trials = [
            compare(hangs, target, readings, explainer(hangs, target)),
            compare(hangs, pins, readings, explainer_elsewhere(hangs, tokenizer.compile)),
        ]
    for trial in trials:
        small = trial.smallest
        assert (trial.verdict, trial.decisions) == (Verdict.FAIL, 2)
        assert small is not None
        assert (small.stimulus, small.observed) == (readings[1], None)
        assert small.lines[0].text.strip() == spin
        assert any(line.startswith("ends in main.bsp:") for line in finding_lines(small, hangs))


def test_nothing_applied_is_unproven(predator: Subject) -> None:
    trial = compare(predator, SimulatedTarget(predator), [])
    assert (trial.verdict, trial.verdict.exit_code) == (Verdict.UNPROVEN, 11)


def test_decisions_are_read_back(predator: Subject, tmp_path: Path) -> None:
    readings = list(every_state(predator.robot).values())
    target = SimulatedTarget(predator)
    made = [Decision(one, target.decide(one)) for one in readings]
    write_decisions(tmp_path / "a.jsonl", made)
    assert list(read_decisions(tmp_path / "a.jsonl")) == made
    text = (tmp_path / "a.jsonl").read_text().splitlines()
    (tmp_path / "b.jsonl").write_text("\n".join([text[0], text[1].replace("/", "|")]))
    with pytest.raises(RunError, match=r"b\.jsonl: line 2 is no decision"):
        list(read_decisions(tmp_path / "b.jsonl"))
