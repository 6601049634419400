"""The proof over the whole sensor space: it proves what is right, and finds what is wrong."""

from dataclasses import replace
from itertools import combinations

import pytest

from cgagen.robot.reader import parse_robot
from cgagen.stamp.decode import decode
from cgagen.stamp.image import Image
from cgagen.tokenizer import Tokenizer
from hil.criticals import Criticals
from hil.dataflow import flow_of
from hil.followed import POSITIONS
from hil.proof import Question, prove
from hil.subject import subject_of
from hil.tracing import classifier_criticals
from tests.firmware_cases import PREDATOR, built
from tests.proof_cases import FAIL, PASS, questions, with_image, with_source


def test_the_predator_is_proven() -> None:
    proof = prove(questions()["predator"].subject)
    assert proof.proven, proof.text()
    assert proof.cells == proof.tried == 4 * 384 * 36
    # What both lamps show hides all sonars, so with the target ahead no far obstacle is seen.
    assert len(proof.by_state) == 40
    assert "all 55,296 cells; 40 states" in proof.text()


def test_a_sample_is_no_proof() -> None:
    proof = prove(questions()["prey"].subject, sample=500)
    assert (proof.verdict, proof.tried, proof.cells) == (PASS, 500, 4 * 85_220)
    assert not proof.proven
    assert proof.text() == "PASS: 500 of 340,880 cells agree; a sample, no proof"


def test_every_critical_number_is_a_threshold() -> None:
    """Nothing is compared with a number that is neither a limit of the robot nor "no echo"."""
    for question in questions().values():
        robot = question.subject.robot
        limits = {robot.alarm_count} if robot.limits is None else set()
        if robot.limits is not None:
            *sonars, left, right = robot.situation_counts
            limits = {*sonars, *left, *right}
        found = set().union(*question.criticals.cuts.values())
        assert found == limits | {1, 65_535}
    predator, prey = (questions()[role].criticals.pairs for role in ("predator", "prey"))
    assert predator == {(0, 1), (0, 2), (1, 2)}
    assert prey == set(combinations(range(6), 2))


@pytest.mark.parametrize("role", ["predator", "prey"])
def test_image_and_simulator_compare_the_same(role: str) -> None:
    """Either side alone; only the sonar that is looked at first is held against "no echo"."""
    question = questions()[role]
    places, image = question.places, question.subject.images["main"]
    program, ours = decode(image.eeprom, image.model), Criticals()
    for touched in POSITIONS:
        levels = tuple(not bent for bent in touched)
        flow = flow_of(program, image.eeprom, places, levels)
        assert not flow.refused
        assert flow.exits
        ours.add(flow.criticals)
    theirs = classifier_criticals(question.subject.robot, places.names)
    assert ours.pairs == theirs.pairs == question.criticals.pairs
    assert ours.cuts == question.criticals.cuts
    assert ours.cuts == {**theirs.cuts, 0: theirs.cuts[0] | {65_535}}


WRONG = [
    ("predator", "EchoFrontNear   CON     1966", "EchoFrontNear   CON     1965"),
    ("predator", "EchoSideFar     CON     7079", "EchoSideFar     CON     7080"),
    ("predator", "LeftLampRange   CON     2587", "LeftLampRange   CON     2588"),
    ("predator", "RightLampMiddle CON     916", "RightLampMiddle CON     915"),
    ("predator", "nearest < EchoFrontMiddle", "nearest <= EchoFrontMiddle"),
    ("predator", "lightRight > 0 AND", "lightRight >= 0 AND"),
    ("predator", "IF distance < nearest THEN", "IF distance <= nearest THEN"),
    ("predator", "FOR sonar = Front TO Left ", "FOR sonar = Left TO Front "),
    ("predator", "    masked = %011 ", "    masked = %000 "),
    ("predator", "    masked = %101 ", "    masked = %100 "),
    ("predator", "LeftLampNear OR lightRight", "LeftLampNear AND lightRight"),
    ("predator", "IF distance = 0 THEN", "IF distance = 1 THEN"),
    ("predator", "ELSEIF antennas = %10 THEN", "ELSEIF antennas = %00 THEN"),
    ("predator", "obstacle * 8 + target", "obstacle * 8 | target + 1 & 63"),
    ("predator", "DATA    4,     0,     0,     5, ", "DATA    4,     0,     0,     4, "),
    ("predator", "nearest         VAR     Word", "nearest         VAR     echo"),
    ("predator", "  READ Genes +", "  IF echo(2) = 777 THEN state = 5\n  READ Genes +"),
    ("predator", "  litLeft = 0\n", "  litLeft = 0\n  echo(0) = echo(0) MIN 5\n"),
    ("predator", "  litLeft = 0\n", "  litLeft = 0\n  IF lightLeft = echo(1) THEN lightLeft = 0\n"),
    ("prey", "Alarm           CON     7079", "Alarm           CON     7078"),
    ("prey", "IF distance < nearest THEN", "IF distance <= nearest THEN"),
    ("prey", "IF distance > nearest THEN", "IF distance >= nearest THEN"),
    ("prey", "FrontLeft TO RearRight", "FrontLeft TO RearLeft"),
    ("prey", "    IF nearest = 0 THEN nearest = NoEcho\n", ""),
    ("prey", "DATA    2   ' 3", "DATA    3   ' 3"),
]


@pytest.mark.parametrize(("role", "old", "new"), WRONG)
def test_a_wrong_program_fails(role: str, old: str, new: str, tokenizer: Tokenizer) -> None:
    subject = with_source(questions()[role].subject, tokenizer, (old, new))
    proof = prove(subject)
    assert proof.verdict is FAIL, proof.text()
    assert proof.difference is not None
    # The difference is one: a target of its own says the same of this reading.
    stimulus, expected, observed = proof.difference
    wrong = Question(subject).decide(stimulus.sonars + stimulus.lights, stimulus.touched)
    assert wrong == observed != expected
    right = questions()[role].decide(stimulus.sonars + stimulus.lights, stimulus.touched)
    assert right == expected
    assert stimulus.text() in proof.text()
    trial = proof.trial()
    assert trial.verdict is FAIL
    assert sum(trial.agreed.values()) == trial.decisions - 1
    assert trial.smallest is not None
    assert trial.smallest.stimulus == stimulus


@pytest.mark.parametrize(
    "case",
    ["predator-free-running", "predator-silent", "predator-srf04", "predator-other-pins",
     "predator-srf04-bs2", "prey-free-running", "prey-silent"],
)  # fmt: skip
def test_robots_of_other_make_can_be_proven(case: str) -> None:
    proof = prove(subject_of(built(case), case), sample=99)
    assert (proof.verdict, proof.tried) == (PASS, 99), proof.text()


SAME = [
    (
        "lightLeft < LeftLampNear OR lightRight < RightLampNear",
        "lightRight < RightLampNear OR lightLeft < LeftLampNear",
    ),
    ("litLeft = 1 AND litRight = 1 THEN", "litRight AND litLeft = 1 THEN"),
    ("IF nearest < EchoFrontFar THEN", "IF NOT nearest >= EchoFrontFar THEN"),
    ("IF nearest < EchoSideNear THEN", "IF nearest <= EchoSideNear - 1 THEN"),
    ("nearest         VAR     Word", "nearest         VAR     lightLeft"),
]
"""The last keeps two things in one word, the one after the other."""


@pytest.mark.parametrize(("old", "new"), SAME)
def test_another_program_that_decides_alike_is_proven(
    old: str, new: str, tokenizer: Tokenizer
) -> None:
    subject = with_source(questions()["predator"].subject, tokenizer, (old, new))
    assert subject.images["main"].eeprom != questions()["predator"].subject.images["main"].eeprom
    assert prove(subject).proven


@pytest.mark.parametrize("state", [0, 8, 16, 45, 63])
def test_a_wrong_gene_fails_where_it_occurs(state: int) -> None:
    """A gene that no reading leads to cannot be proven wrong by readings: see `by_state`."""
    subject = questions()["predator"].subject
    image = subject.images["main"]
    eeprom = bytearray(image.eeprom)
    first = bytes(subject.genome.commands()) if subject.genome else b""
    eeprom[image.eeprom.index(first) + state] ^= 1
    proof = prove(with_image(subject, Image(image.model, bytes(eeprom))))
    assert proof.verdict is (PASS if state == 63 else FAIL)
    assert (proof.difference.expected[0] if proof.difference else 63) == state


def test_a_robot_with_other_limits_is_another_question() -> None:
    """The simulator's side is divided by its own numbers."""
    other = PREDATOR.replace("side_far_in = 36", "side_far_in = 36.01")
    assert other != PREDATOR
    robot = parse_robot(other, "other.toml")
    proof = prove(replace(questions()["predator"].subject, robot=robot))
    assert proof.verdict is FAIL


def test_a_number_on_the_left_is_the_same(tokenizer: Tokenizer) -> None:
    changes = [
        ("IF lightLeft < LeftLampNear", "IF LeftLampNear > lightLeft"),
        ("IF nearest < EchoFrontNear", "IF EchoFrontNear - 1 >= nearest"),
        ("IF lightLeft > 0", "IF 1 <= lightLeft"),
    ]
    before = questions()["predator"]
    after = Question(with_source(before.subject, tokenizer, *changes))
    assert after.criticals == before.criticals


def test_swapped_sonars_fail(tokenizer: Tokenizer) -> None:
    """Which sonar a word belongs to is told by the pin, not by the names in the source."""
    right, left = "PULSIN SonarRight, 1, echo(Right)", "PULSIN SonarLeft, 1, echo(Left)"
    subject = with_source(
        questions()["predator"].subject,
        tokenizer,
        (right, right.replace("(Right)", "(2)")),
        (left, left.replace("(Left)", "(Right)")),
    )
    assert prove(subject).verdict is FAIL
