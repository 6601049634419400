"""The proof over the whole sensor space: it finds what is wrong, and misses no cell."""

import random
from collections.abc import Callable
from dataclasses import replace
from itertools import combinations, product
from pathlib import Path

import pytest

from cgagen.emulator.chip import Chip
from cgagen.emulator.clock import Clock
from cgagen.errors import UnprovenError
from cgagen.robot.reader import parse_robot
from cgagen.stamp.decode import decode
from cgagen.stamp.image import Image
from cgagen.tokenizer import Tokenizer
from hil.criticals import Criticals
from hil.dataflow import flow_of
from hil.equivalence import Verdict
from hil.followed import POSITIONS
from hil.partition import Group, Partition, joined
from hil.proof import Question, prove
from hil.subject import Subject, read_subject, subject_of
from hil.tracing import Trace, classifier_criticals
from tests.firmware_cases import PREDATOR, built

FIRMWARE = Path(__file__).parent.parent / "firmware"
PASS, FAIL, UNPROVEN = Verdict.PASS, Verdict.FAIL, Verdict.UNPROVEN


@pytest.fixture(scope="module")
def questions() -> dict[str, Question]:
    return {role: Question(read_subject(FIRMWARE / role)) for role in ("predator", "prey")}


def with_source(subject: Subject, tokenizer: Tokenizer, *changes: tuple[str, str]) -> Subject:
    """A subject whose main source was changed and compiled."""
    source = subject.sources["main"]
    for old, new in changes:
        assert old in source, old
        source = source.replace(old, new)
    return with_image(subject, tokenizer.compile(source, "main.bsp").image)


def with_image(subject: Subject, image: Image) -> Subject:
    return replace(subject, images={**subject.images, "main": image})


# -- What is proven ---------------------------------------------------------------------------


def test_the_predator_is_proven(questions: dict[str, Question]) -> None:
    proof = prove(questions["predator"].subject)
    assert proof.proven, proof.text()
    assert proof.cells == proof.tried == 4 * 384 * 46
    # What both lamps show hides all sonars, so with the target ahead no far obstacle is seen.
    assert len(proof.by_state) == 40
    assert "all 70,656 cells; 40 states" in proof.text()


def test_a_sample_is_no_proof(questions: dict[str, Question]) -> None:
    proof = prove(questions["prey"].subject, sample=500)
    assert (proof.verdict, proof.tried, proof.cells) == (PASS, 500, 4 * 85_220)
    assert not proof.proven
    assert proof.text() == "PASS: 500 of 340,880 cells agree; a sample, no proof"


def test_every_critical_number_is_a_threshold(questions: dict[str, Question]) -> None:
    """Nothing is compared with a number that is neither a limit of the robot nor "no echo"."""
    for question in questions.values():
        robot = question.subject.robot
        limits = set(robot.situation_counts) if robot.limits else {robot.alarm_count}
        found = set().union(*question.criticals.cuts.values())
        assert found == limits | {1, 65_535}
    predator, prey = (questions[role].criticals.pairs for role in ("predator", "prey"))
    assert predator == {(0, 1), (0, 2), (1, 2), (3, 4)}
    assert prey == set(combinations(range(6), 2))


@pytest.mark.parametrize("role", ["predator", "prey"])
def test_image_and_simulator_compare_the_same(role: str, questions: dict[str, Question]) -> None:
    """Either side alone; only the sonar that is looked at first is held against "no echo"."""
    question = questions[role]
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


# -- What is found ----------------------------------------------------------------------------

WRONG = [
    ("predator", "EchoFrontNear   CON     1843", "EchoFrontNear   CON     1842"),
    ("predator", "EchoSideFar     CON     6637", "EchoSideFar     CON     6638"),
    ("predator", "LampRange       CON     2587", "LampRange       CON     2588"),
    ("predator", "LampFrontMiddle CON     916", "LampFrontMiddle CON     915"),
    ("predator", "nearest < EchoFrontMiddle", "nearest <= EchoFrontMiddle"),
    ("predator", "lightRight > 0 AND", "lightRight >= 0 AND"),
    ("predator", "IF distance < nearest THEN", "IF distance <= nearest THEN"),
    ("predator", "FOR sonar = Front TO Left ", "FOR sonar = Left TO Front "),
    ("predator", "    masked = %011 ", "    masked = %000 "),
    ("predator", "    masked = %101 ", "    masked = %100 "),
    ("predator", "lightLeft MAX lightRight", "lightLeft MIN lightRight"),
    ("predator", "IF distance = 0 THEN", "IF distance = 1 THEN"),
    ("predator", "ELSEIF antennas = %10 THEN", "ELSEIF antennas = %00 THEN"),
    ("predator", "obstacle * 8 + target", "obstacle * 8 | target + 1 & 63"),
    ("predator", "DATA    4,     0,     0,     5, ", "DATA    4,     0,     0,     4, "),
    ("predator", "nearest         VAR     Word", "nearest         VAR     echo"),
    ("predator", "  READ Genes +", "  IF echo(2) = 777 THEN state = 5\n  READ Genes +"),
    ("predator", "  litLeft = 0\n", "  litLeft = 0\n  echo(0) = echo(0) MIN 5\n"),
    ("predator", "  litLeft = 0\n", "  litLeft = 0\n  IF lightLeft = echo(1) THEN lightLeft = 0\n"),
    ("prey", "Alarm           CON     6637", "Alarm           CON     6636"),
    ("prey", "IF distance < nearest THEN", "IF distance <= nearest THEN"),
    ("prey", "IF distance > nearest THEN", "IF distance >= nearest THEN"),
    ("prey", "FrontLeft TO RearRight", "FrontLeft TO RearLeft"),
    ("prey", "    IF nearest = 0 THEN nearest = NoEcho\n", ""),
    ("prey", "DATA    2   ' 3", "DATA    3   ' 3"),
]


@pytest.mark.parametrize(("role", "old", "new"), WRONG)
def test_a_wrong_program_fails(
    role: str, old: str, new: str, questions: dict[str, Question], tokenizer: Tokenizer
) -> None:
    subject = with_source(questions[role].subject, tokenizer, (old, new))
    proof = prove(subject)
    assert proof.verdict is FAIL, proof.text()
    assert proof.difference is not None
    # The difference is one: a target of its own says the same of this reading.
    stimulus, expected, observed = proof.difference
    wrong = Question(subject).decide(stimulus.sonars + stimulus.lights, stimulus.touched)
    assert wrong == observed != expected
    right = questions[role].decide(stimulus.sonars + stimulus.lights, stimulus.touched)
    assert right == expected
    assert stimulus.text() in proof.text()
    trial = proof.trial()
    assert trial.verdict is FAIL
    assert sum(trial.agreed.values()) == trial.decisions - 1
    assert trial.smallest is not None
    assert trial.smallest.stimulus == stimulus


UNLIT = "  litLeft = 0\n"
UNSET = "that nothing has set"

UNKNOWN = [
    ("distance = echo(sonar)\n", "distance = echo(sonar) / 2\n", "arithmetic, with /"),
    ("distance = echo(sonar)\n", "distance = echo(sonar) + sonar\n", "arithmetic, with +"),
    ("IF lightLeft > 0 AND", "IF lightLeft AND", "light left is used in arithmetic, with &"),
    ("IF lightLeft > 0", "IF lightLeft.HIGHBYTE > 0", "a part of light left is read"),
    ("IF lightLeft > 0", "IF lightLeft.BIT3 > 0", "a part of light left is read"),
    ("IF lightLeft > 0", "IF echo(lightRight) > 0", "light right is the index of an array"),
    ("  READ Genes + state", "  READ echo(0)", "sonar front is the location of READ"),
    ("  target = Nothing\n", "", UNSET),
    ("IF antennas = %00 THEN", "IF AntennaLeft = 0 THEN", "pins are read"),
    (UNLIT, f"{UNLIT}  PAUSE 1\n", "PAUSE is carried out"),
    (UNLIT, "Stuck:\n  litLeft = 0\n  GOTO Stuck\n", "does not return"),
    (UNLIT, "Deep:\n  GOSUB Deep\n  litLeft = 0\n", "deeper than the chip"),
    ("FOR sonar = Front TO Left ", "FOR sonar = Front TO echo(0) ", "is the end of FOR"),
    ("SayWho:\n", "SayWho:\n  WRITE 41, 0\n", "the program has WRITE"),
    ("  antennas.BIT0 =", "  echo(0) = echo(0) / 2\n  antennas.BIT0 =", "while sensing"),
    ("SonarFront, 1, echo(Front)", "SonarFront, 1, distance", UNSET),
    ("SonarFront, 1, echo(Front)", "SonarFront, 1, echo(1)", "not one sensor's alone"),
    ("  GOSUB Sense\n", "  GOSUB Sense\n  echo(0) = 1\n", "directly after sensing"),
    ("  GOSUB Sense\n", "  GOSUB Sense\n  GOSUB Sense\n", "2 calls of a routine"),
    (UNLIT, "  litLeft = echo(0) // 3\n", "arithmetic, with //"),
    (UNLIT, f"{UNLIT}  IF echo(0) - echo(1) > 9 THEN litLeft = 1\n", "arithmetic, with -"),
    (UNLIT, f"{UNLIT}  state = echo(0)\n  IF state < 9 THEN litLeft = 1\n", "a part of sonar"),
    (UNLIT, f"{UNLIT}  command = echo(0)\n  IF command < 9 THEN litLeft = 1\n", "a part of"),
    (UNLIT, "  LOOKUP echo(0), [0, 1], litLeft\n", "is the index of LOOKUP"),
    (UNLIT, "  LOOKDOWN echo(0), < [10, 99], litLeft\n", "LOOKDOWN is carried out"),
    (UNLIT, "  BRANCH echo(0), [Hunt]\n  litLeft = 0\n", "is the index of BRANCH"),
    (UNLIT, "  PUT 3, echo(0)\n  GET 3, litLeft\n", "PUT is carried out"),
    (UNLIT, f"{UNLIT}  IF echo(0) < request(0) THEN litLeft = 1\n", UNSET),
    (UNLIT, f"{UNLIT}  IF echo(0) < decisions THEN litLeft = 1\n", UNSET),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "reason"), UNKNOWN)
def test_what_is_not_understood_is_unproven(
    old: str, new: str, reason: str, questions: dict[str, Question], tokenizer: Tokenizer
) -> None:
    proof = prove(with_source(questions["predator"].subject, tokenizer, (old, new)))
    assert proof.verdict is UNPROVEN, proof.text()
    assert reason in proof.text()
    assert not proof.proven
    assert reason in proof.trial().reason


LATCHED = "  commandLatch = command "
TOLD = "  GOSUB Decide\n  GOSUB Tell\n"
COUNTED = "  decisions = decisions + 1"

BEYOND = [
    (LATCHED, "  IF command > 0 THEN commandLatch = command ", "always set the command lines"),
    (LATCHED, "  commandLatch.BIT0 = command ", "always set the command lines"),
    (LATCHED, f"{LATCHED}\n  commandLatch = echo(0)\n'", "always set the command lines"),
    (LATCHED, f"{LATCHED}\n  state = echo(0)\n'", "a known number as its state"),
    (LATCHED, f"  DIRC = 15\n{LATCHED}", "directions of pins are changed"),
    (LATCHED, f"  OUTC = 15\n{LATCHED}", "pins are changed that are no command lines"),
    (TOLD, "  GOSUB Decide\n  IF echo(0) = 777 THEN commandLatch = 5\n  GOSUB Tell\n",
     "after the decision, IF may depend on what was sensed"),
    (TOLD, "  GOSUB Decide\n  IF nearest // 3 = 0 THEN Hunt\n  GOSUB Tell\n", "IF may depend on"),
    (TOLD, "  GOSUB Decide\n  IF AntennaLeft = 0 THEN Hunt\n  GOSUB Tell\n", "pins are read"),
    (TOLD, "  GOSUB Decide\n  BRANCH command, [Hunt]\n  GOSUB Tell\n", UNSET),
    (TOLD, f"{TOLD}  GOSUB Decide\n", "IF may depend on"),
    (TOLD, "  GOSUB Decide\n  OUTA = OUTA ^ 1\n  GOSUB Tell\n", "LET may depend on"),
    (TOLD, "  GOSUB Decide\n  commandLatch = command & 3\n  GOSUB Tell\n", "LET may depend on"),
    (TOLD, "  GOSUB Decide\n  commandLatch.LOWBIT(command) = 0\n  GOSUB Tell\n", "beside the"),
    (TOLD, f"{TOLD}  SERIN Port, Baud, 9, Hunt, [command]\n", "SERIN is carried out"),
    (TOLD, f"{TOLD}  GOSUB Hunt\n", "out of a routine, so calls pile up"),
    (TOLD, f"{TOLD}  RETURN\n", "RETURN from where nobody has called"),
    (TOLD, f"{TOLD}Stuck:\n  GOTO Stuck\n", "after the decision, nothing is sensed again"),
    ("  PAUSE GoTime", "  PAUSE lightLeft", "PAUSE may depend on"),
    ("  LOW StepLine", "  LOW command", "LOW may depend on"),
    (COUNTED, f"  antennas = antennas | 4\n{COUNTED}", "may store something beside the antennas"),
    (COUNTED, f"  antennas.LOWBIT(facing) = 1\n{COUNTED}", "store something beside the antennas"),
    (COUNTED, f"  antennas = 4\n{COUNTED}", "store something beside the antennas"),
    (COUNTED, f"  SHIFTIN 12, 13, 0, [antennas]\n{COUNTED}", "store something beside the antennas"),
    (COUNTED, f"  I2CIN 0, 160, 0, [STR request\\2]\n{COUNTED}", "something beside the antennas"),
]  # fmt: skip
"""What the routine that decides does not show: the answer is another one, or is told otherwise."""


@pytest.mark.parametrize(("old", "new", "reason"), BEYOND)
def test_an_answer_that_is_not_what_the_robot_does_is_unproven(
    old: str, new: str, reason: str, questions: dict[str, Question], tokenizer: Tokenizer
) -> None:
    proof = prove(with_source(questions["predator"].subject, tokenizer, (old, new)), sample=9)
    assert proof.verdict is UNPROVEN, proof.text()
    assert reason in proof.text()


HARMLESS = [
    (TOLD, "  GOSUB Decide\n  decisions = nearest + echo(0)\n  GOSUB Tell\n"),
    (TOLD, "  GOSUB Decide\n  OUTB = 0\n  nearest = state\n  GOSUB Tell\n"),
    (f"{TOLD}  GOSUB Report\n", "  GOSUB Decide\n  GOSUB Report\n  GOSUB Tell\n"),
    (COUNTED, f"  antennas = %0011\n{COUNTED}"),
    ("IF StepLine = 0 THEN RETURN", "IF StepLine = 0 AND StepLine < 1 THEN RETURN"),
]


@pytest.mark.parametrize(("old", "new"), HARMLESS)
def test_what_is_counted_and_said_after_the_decision_does_no_harm(
    old: str, new: str, questions: dict[str, Question], tokenizer: Tokenizer
) -> None:
    proof = prove(with_source(questions["predator"].subject, tokenizer, (old, new)), sample=99)
    assert (proof.verdict, proof.tried) == (PASS, 99), proof.text()


@pytest.mark.parametrize(
    "case",
    ["predator-free-running", "predator-silent", "predator-srf04", "predator-other-pins",
     "predator-srf04-bs2", "prey-free-running", "prey-silent"],
)  # fmt: skip
def test_robots_of_other_make_can_be_proven(case: str) -> None:
    proof = prove(subject_of(built(case), case), sample=99)
    assert (proof.verdict, proof.tried) == (PASS, 99), proof.text()


def test_a_reason_has_its_line(questions: dict[str, Question], tokenizer: Tokenizer) -> None:
    subject = questions["predator"].subject
    source = subject.sources["main"].replace("= echo(sonar)\n", "= echo(sonar) * 2\n")
    compiled = tokenizer.compile(source, "main.bsp")
    line = 1 + source[: source.index("= echo(sonar) * 2")].count("\n")
    proof = prove(with_image(subject, compiled.image), source_map=compiled.source_map)
    assert proof.reasons == (f"line {line}: sonar front is used in arithmetic, with *",)


SAME = [
    ("lightLeft MAX lightRight", "lightRight MAX lightLeft"),
    ("litLeft = 1 AND litRight = 1 THEN", "litRight AND litLeft = 1 THEN"),
    ("IF nearest < EchoFrontFar THEN", "IF NOT nearest >= EchoFrontFar THEN"),
    ("IF nearest < EchoSideNear THEN", "IF nearest <= EchoSideNear - 1 THEN"),
    ("nearest         VAR     Word", "nearest         VAR     lightLeft"),
]
"""The last keeps two things in one word, the one after the other."""


@pytest.mark.parametrize(("old", "new"), SAME)
def test_another_program_that_decides_alike_is_proven(
    old: str, new: str, questions: dict[str, Question], tokenizer: Tokenizer
) -> None:
    subject = with_source(questions["predator"].subject, tokenizer, (old, new))
    assert subject.images["main"].eeprom != questions["predator"].subject.images["main"].eeprom
    assert prove(subject).proven


@pytest.mark.parametrize("state", [0, 8, 16, 45, 63])
def test_a_wrong_gene_fails_where_it_occurs(state: int, questions: dict[str, Question]) -> None:
    """A gene that no reading leads to cannot be proven wrong by readings: see `by_state`."""
    subject = questions["predator"].subject
    image = subject.images["main"]
    eeprom = bytearray(image.eeprom)
    first = bytes(subject.genome.commands()) if subject.genome else b""
    eeprom[image.eeprom.index(first) + state] ^= 1
    proof = prove(with_image(subject, Image(image.model, bytes(eeprom))))
    assert proof.verdict is (PASS if state == 63 else FAIL)
    assert proof.difference is None or proof.difference.expected[0] == state


def test_a_robot_with_other_limits_is_another_question(questions: dict[str, Question]) -> None:
    """The simulator's side is divided by its own numbers."""
    other = PREDATOR.replace("side_far_in = 36", "side_far_in = 36.01")
    assert other != PREDATOR
    robot = parse_robot(other, "other.toml")
    proof = prove(replace(questions["predator"].subject, robot=robot))
    assert proof.verdict is FAIL


def test_a_number_on_the_left_is_the_same(
    questions: dict[str, Question], tokenizer: Tokenizer
) -> None:
    changes = [
        ("IF nearest < LampFrontNear", "IF LampFrontNear > nearest"),
        ("IF nearest < EchoFrontNear", "IF EchoFrontNear - 1 >= nearest"),
        ("IF lightLeft > 0", "IF 1 <= lightLeft"),
    ]
    before = questions["predator"]
    after = Question(with_source(before.subject, tokenizer, *changes))
    assert after.criticals == before.criticals


def test_swapped_sonars_fail(questions: dict[str, Question], tokenizer: Tokenizer) -> None:
    """Which sonar a word belongs to is told by the pin, not by the names in the source."""
    right, left = "PULSIN SonarRight, 1, echo(Right)", "PULSIN SonarLeft, 1, echo(Left)"
    subject = with_source(
        questions["predator"].subject,
        tokenizer,
        (right, right.replace("(Right)", "(2)")),
        (left, left.replace("(Left)", "(Right)")),
    )
    assert prove(subject).verdict is FAIL


# -- No cell is missed ------------------------------------------------------------------------


def small_criticals(dice: random.Random, sensors: int, largest: int) -> Criticals:
    """Critical numbers and pairs of a small space, by chance."""
    criticals = Criticals()
    for sensor in range(sensors):
        for _ in range(dice.randrange(3)):
            symbol = dice.choice(("<", "<=", ">", ">=", "=", "<>"))
            criticals.constant(sensor, symbol, dice.randrange(largest + 1))
    for pair in combinations(range(sensors), 2):
        if dice.random() < 0.6:
            criticals.pair(*pair)
    return criticals


def comparisons(criticals: Criticals, counts: tuple[int, ...]) -> tuple[object, ...]:
    """All that a decider may know of some counts."""
    numbers = [counts[n] >= cut for n, cuts in sorted(criticals.cuts.items()) for cut in cuts]
    pairs = [(counts[a] < counts[b], counts[a] == counts[b]) for a, b in sorted(criticals.pairs)]
    return (*numbers, *pairs)


@pytest.mark.parametrize("seed", range(25))
def test_every_point_of_a_small_space_is_decided_like_its_cell(seed: int) -> None:
    """All points, told apart by the comparisons themselves: each way has a cell, and one way."""
    dice = random.Random(seed)
    sensors, largest = (4, 5) if seed % 2 else (3, 7)
    criticals = small_criticals(dice, sensors, largest)
    partition = Partition(sensors, criticals, [()], largest)
    cells = [partition[cell][0] for cell in range(len(partition))]
    assert all(0 <= count <= largest for counts in cells for count in counts)
    named = {name_of(partition, counts): comparisons(criticals, counts) for counts in cells}
    assert len(named) == len(cells), "two representatives of one cell"
    for point in product(range(largest + 1), repeat=sensors):
        assert named[name_of(partition, point)] == comparisons(criticals, point)
    points = product(range(largest + 1), repeat=sensors)
    assert {name_of(partition, point) for point in points} == set(named), "an empty cell"


def name_of(partition: Partition, counts: tuple[int, ...]) -> tuple[object, ...]:
    """Which cell some counts are in."""
    return tuple(
        group.cell_of([counts[sensor] for sensor in group.sensors]) for group in partition.groups
    )


@pytest.mark.parametrize("seed", range(10))
def test_the_number_of_cells_is_the_formula(seed: int) -> None:
    dice = random.Random(seed)
    cuts = {dice.randrange(1, 12) for _ in range(dice.randrange(5))}
    group = Group(range(dice.randrange(1, 6)), cuts, largest=dice.randrange(1, 12))
    assert len(group.cells) == len(set(group.cells)) == group.counted()


def test_more_cells_than_can_be_tried_are_refused_at_once(
    questions: dict[str, Question], tokenizer: Tokenizer
) -> None:
    """Six sonars in one group, with so many numbers that listing all cells would never end."""
    numbers = "".join(f"      IF distance = {n} THEN sonar = sonar\n" for n in range(2, 60, 3))
    old = "      IF distance = 0 THEN distance = NoEcho\n      IF distance < nearest"
    subject = with_source(questions["prey"].subject, tokenizer, (old, numbers + old))
    proof = prove(subject, sample=9)
    assert proof.verdict is UNPROVEN
    assert "cells, more than" in proof.text()


def test_groups_are_joined_through_others() -> None:
    assert joined(4, {(2, 3), (0, 3), (0, 1)}) == ((0, 1, 2, 3),)
    assert joined(3, set()) == ((0,), (1,), (2,))


def test_any_reading_is_decided_like_its_cell(questions: dict[str, Question]) -> None:
    """The same for the images themselves, with readings by chance."""
    dice = random.Random(7)
    for question in questions.values():
        partition = question.partition
        listed = [set(group.cells) for group in partition.groups]
        for _ in range(1500):
            common = dice.randrange(65_536)
            counts = [
                dice.choice((common, dice.randrange(65_536), dice.randrange(8_000), 0, 65_535))
                for _ in question.places.words
            ]
            like = counts.copy()
            for group, cells in zip(partition.groups, listed, strict=True):
                cell = group.like([counts[sensor] for sensor in group.sensors])
                assert cell in cells
                for sensor, count in zip(group.sensors, cell, strict=True):
                    like[sensor] = count
            touched = dice.choice((POSITIONS[0], *POSITIONS))
            decided = question.decide(tuple(counts), touched)
            assert decided == question.decide(tuple(like), touched), (counts, like)


# -- What it rests on -------------------------------------------------------------------------


@pytest.mark.parametrize("role", ["predator", "prey"])
def test_a_chip_with_its_clock_decides_the_same(role: str, questions: dict[str, Question]) -> None:
    """The routine called without a bench, against the whole emulated chip."""
    question, dice = questions[role], random.Random(8)
    places, image = question.places, question.subject.images["main"]
    chip = Chip("main", [image], Clock())
    chip.machine.pc = places.entry
    chip.machine.gosubs[:] = [places.call]
    chip.on_address(places.stop, lambda stopped: stopped.clock.stop())
    counted = chip.cover().counts
    start, now = chip.snapshot(), chip.clock.state()
    for _ in range(500):
        counts, touched = question.partition[dice.randrange(len(question.partition))]
        chip.clock.restore(now)
        chip.restore(start)
        for word, count in zip(places.words, counts, strict=True):
            chip.registers.write(16, word, count)
        for bit, bent in zip(places.antennas, touched, strict=True):
            chip.registers.write(1, bit, not bent)
        chip.run(1_000_000_000)
        assert chip.pc == places.stop
        observed = question.decide(counts, touched)
        assert observed is not None
        assert observed[1] == chip.pins.latch & 7
    # All that was carried out had been followed, and no more.
    assert {address for _, address in counted} - {places.stop} == question.visited


def traced(function: Callable[..., object]) -> tuple[set[object], Criticals]:
    trace = Trace(("a", "b", "c"))
    found = trace.follow(function, *(trace.word(n) for n in range(3)))
    return found, trace.criticals


def test_the_trace_takes_every_way() -> None:
    def decide(a: int, b: int, c: int) -> int:
        least = a if a < b else b
        if least == 0:
            return 1
        return 2 if 9 <= least and least != c else (3 if b > 20 else 4)

    found, criticals = traced(decide)
    assert found == {1, 2, 3, 4}
    assert criticals.cuts == {0: {1, 9}, 1: {1, 9, 21}}
    assert criticals.pairs == {(0, 1), (0, 2), (1, 2)}


REFUSED: list[Callable[..., object]] = [
    lambda a, b, c: a + 1,
    lambda a, b, c: 5 - b,
    lambda a, b, c: a & 1,
    lambda a, b, c: (1, 2, 3)[c],
    lambda a, b, c: int(a),
    lambda a, b, c: -a < b,
    lambda a, b, c: range(a),
    lambda a, b, c: {a: 1},
]
"""Functions that do more with a word than compare it."""


@pytest.mark.parametrize("function", REFUSED)
def test_the_trace_refuses_all_but_comparisons(function: Callable[..., object]) -> None:
    with pytest.raises(UnprovenError, match="more than compare"):
        traced(function)


def test_the_trace_refuses_to_compare_with_what_is_no_number() -> None:
    with pytest.raises(UnprovenError, match=r"a is compared with 1\.5, no number"):
        traced(lambda a, b, c: a < 1.5)


def test_a_word_is_equal_to_itself() -> None:
    trace = Trace(("a",))
    word, same = trace.word(0), trace.word(0)
    assert word == same
    assert word <= same
    assert not word < same
