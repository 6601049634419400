"""The proof over the whole sensor space: what it does not understand is no proof."""

import pytest

from cgagen.tokenizer import Tokenizer
from hil.proof import prove
from hil.subject import subject_of
from tests.firmware_cases import built
from tests.proof_cases import PASS, UNPROVEN, questions, with_image, with_source

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
    old: str, new: str, reason: str, tokenizer: Tokenizer
) -> None:
    proof = prove(with_source(questions()["predator"].subject, tokenizer, (old, new)))
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
    (TOLD, "  GOSUB Decide\n  BRANCH command, [Hunt]\n  GOSUB Tell\n", "BRANCH may"),
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
    old: str, new: str, reason: str, tokenizer: Tokenizer
) -> None:
    proof = prove(with_source(questions()["predator"].subject, tokenizer, (old, new)), sample=9)
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
    old: str, new: str, tokenizer: Tokenizer
) -> None:
    proof = prove(with_source(questions()["predator"].subject, tokenizer, (old, new)), sample=99)
    assert (proof.verdict, proof.tried) == (PASS, 99), proof.text()


def test_a_reason_has_its_line(tokenizer: Tokenizer) -> None:
    subject = questions()["predator"].subject
    source = subject.sources["main"].replace("= echo(sonar)\n", "= echo(sonar) * 2\n")
    compiled = tokenizer.compile(source, "main.bsp")
    line = 1 + source[: source.index("= echo(sonar) * 2")].count("\n")
    proof = prove(with_image(subject, compiled.image), source_map=compiled.source_map)
    assert proof.reasons == (f"line {line}: sonar front is used in arithmetic, with *",)


def test_more_cells_than_can_be_tried_are_refused_at_once(tokenizer: Tokenizer) -> None:
    """Six sonars in one group, with so many numbers that listing all cells would never end."""
    numbers = "".join(f"      IF distance = {n} THEN sonar = sonar\n" for n in range(2, 60, 3))
    old = "      IF distance = 0 THEN distance = NoEcho\n      IF distance < nearest"
    subject = with_source(questions()["prey"].subject, tokenizer, (old, numbers + old))
    proof = prove(subject, sample=9)
    assert proof.verdict is UNPROVEN
    assert "cells, more than" in proof.text()


@pytest.mark.parametrize(
    "new",
    [
        f"  commandLatch = 0\n{LATCHED}",
        f"{LATCHED}\n  commandLatch = command\n'",
        "  commandLatch.BIT2 = command >> 2\n  commandLatch.BIT1 = command >> 1\n"
        "  commandLatch.BIT0 = command '",
    ],
)
def test_lines_that_are_read_at_any_time_are_set_at_once(new: str, tokenizer: Tokenizer) -> None:
    """Without a step line nobody waits: a command in between is a command."""
    subject = subject_of(built("predator-free-running"), "free")
    proof = prove(with_source(subject, tokenizer, (LATCHED, new)), sample=9)
    assert proof.verdict is UNPROVEN, proof.text()
    assert "are not set at once" in proof.text()
