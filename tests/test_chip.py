"""Programs whose end state follows from the documents, instruction by instruction and compiled."""

from dataclasses import replace

import pytest

from cgagen.emulator.chip import Chip, End
from cgagen.emulator.clock import Clock
from cgagen.emulator.unknowns import CHOICES
from cgagen.errors import ExecutionError
from cgagen.stamp.chips import chip
from cgagen.stamp.image import Image
from cgagen.tokenizer import Tokenizer
from tests.chip_programs import SECOND_NS, chip_of

BYTE, WORD, NIB = "b VAR Byte\n", "w VAR Word\n", "n VAR Nib\n"


CONFORMANCE = [
    # source, registers expected; words come first in the file, then bytes, then nibbles
    ("passes at least once", WORD + BYTE + "FOR w = 10 TO 10\nb = b + 1\nNEXT",
     {"B2": 1, "W0": 11}),
    ("down", WORD + BYTE + "FOR w = 3 TO 1\nb = b + 1\nNEXT", {"B2": 3, "W0": 0}),
    ("past 0", WORD + BYTE + "FOR w = 2 TO 0\nb = b + 1\nNEXT", {"B2": 3, "W0": 65535}),
    ("step", WORD + BYTE + "FOR w = 1 TO 10 STEP 4\nb = b + 1\nNEXT", {"B2": 3, "W0": 13}),
    ("step down", WORD + BYTE + "FOR w = 9 TO 1 STEP 4\nb = b + 1\nNEXT", {"B2": 3, "W0": 65533}),
    ("minus 1", WORD + BYTE + "FOR w = 5 TO 9 STEP -1\nb = b + 1\nNEXT", {"B2": 1, "W0": 4}),
    ("byte wraps out", BYTE + WORD + "FOR b = 10 TO 300\nw = w + 1\nNEXT", {"B2": 0, "W0": 246}),
    ("nibble", NIB + WORD + "FOR n = 0 TO 14\nw = w + 1\nNEXT", {"W0": 15, "B2": 15}),
    ("end moves", WORD + "e VAR Word\ne = 9\nFOR w = 1 TO e\ne = 4\nNEXT", {"W0": 5}),
    ("step moves", WORD + "e VAR Word\nFOR w = 1 TO 100 STEP e\ne = e + 1\nNEXT", {"W0": 106}),
    ("counter set", WORD + "FOR w = 1 TO 9\nw = 8\nIF w = 8 THEN done\nNEXT\ndone:", {"W0": 8}),
    ("left to right", WORD + "w = 2 + 3 * 4 - 6 / 7", {"W0": 2}),
    ("brackets", WORD + "w = 2 + (3 * (4 - (6 / 3)))", {"W0": 8}),
    ("cut to size", BYTE + NIB + "b = 259\nn = 18", {"B0": 3, "B1": 2}),
    ("negative", WORD + BYTE + "w = -5\nb = -5\nw = ABS w", {"W0": 5, "B2": 251}),
    ("array", "a VAR Byte(4)\n" + NIB + "FOR n = 0 TO 3\na(n) = n * n\nNEXT",
     {"B0": 0, "B1": 1, "B2": 4, "B3": 9}),
    ("array runs on", "a VAR Byte(2)\nc VAR Byte\na(2) = 7", {"B2": 7}),
    ("array wraps", "a VAR Byte(2)\n" + NIB + "a(28) = 9\nn = OUTA", {"OUTS": 9, "B2": 9}),
    ("bits of a word", WORD + "w.LOWBIT(9) = 1\nw.NIB3 = 5", {"W0": 0x5200}),
    ("if and or", WORD + "w = 5\nIF w > 3 AND w < 5 OR NOT w = 6 THEN w = 77", {"W0": 77}),
    ("if a number", WORD + BYTE + "w = 2\nIF w THEN b = 1\nIF NOT w THEN b = b + 2", {"B2": 3}),
    ("unsigned", WORD + BYTE + "w = -1\nIF w > 5 THEN b = 1", {"B2": 1}),
    ("elseif", WORD + "w = 2\nIF w = 1 THEN\nw = 10\nELSEIF w = 2 THEN\nw = 20\nELSE\n"
     "w = 30\nENDIF",
     {"W0": 20}),
    ("select", WORD + BYTE + "w = 7\nSELECT w\nCASE < 5\nb = 1\nCASE 6 TO 8\nb = 2\n"
     "CASE ELSE\nb = 3\n"
     "ENDSELECT", {"B2": 2}),
    ("while", WORD + "DO WHILE w < 7\nw = w + 2\nLOOP", {"W0": 8}),
    ("until", WORD + "DO\nw = w + 1\nLOOP UNTIL w = 3", {"W0": 3}),
    ("exit", WORD + "DO\nw = w + 1\nIF w = 4 THEN EXIT\nLOOP", {"W0": 4}),
    ("branch", WORD + BYTE + "w = 1\nBRANCH w, [x, y]\nb = 1\nx: b = b + 10\ny: b = b + 100",
     {"B2": 100}),
    ("branch past", WORD + BYTE + "w = 2\nBRANCH w, [x, y]\nb = 1\nx: b = b + 10\ny: b = b + 100",
     {"B2": 111}),
    ("lookup", WORD + BYTE + "w = 2\nb = 9\nLOOKUP w, [5, 6, w + 5], b", {"B2": 7}),
    ("lookup past", WORD + BYTE + "w = 3\nb = 9\nLOOKUP w, [5, 6, 7], b", {"B2": 9}),
    ("lookdown", WORD + BYTE + "w = 6\nb = 9\nLOOKDOWN w, [5, 6, 6], b", {"B2": 1}),
    ("lookdown below", WORD + BYTE + "w = 6\nb = 9\nLOOKDOWN w, < [5, 6, 8], b", {"B2": 2}),
    ("lookdown none", WORD + BYTE + "w = 4\nb = 9\nLOOKDOWN w, [5, 6, 6], b", {"B2": 9}),
    ("gosub", WORD + "GOSUB x\nGOSUB x\nSTOP\nx: w = w + 1\nGOSUB y\nRETURN\ny: w = w + 10\nRETURN",
     {"W0": 22}),
    ("on gosub", WORD + BYTE + "b = 1\nON b GOSUB x, y\nw = w + 1\nb = 2\n"
     "ON b GOSUB x, y\nw = w + 1\n"
     "STOP\nx: w = w + 10\nRETURN\ny: w = w + 100\nRETURN", {"W0": 102}),
    ("data", WORD + BYTE + "t DATA 5, Word 1000, 7\nREAD t + 1, Word w\nREAD t + 3, b",
     {"W0": 1000, "B2": 7}),
    ("write", WORD + BYTE + "WRITE 3, 258, 9\nREAD 3, b\nREAD 4, w", {"B2": 2, "W0": 9}),
    ("write a word", WORD + BYTE + "WRITE 3, Word 259\nREAD 3, Word w\nREAD 2048 + 3, b",
     {"W0": 259, "B2": 3}),
    ("random repeats", WORD + "v VAR Word\nRANDOM w\nRANDOM v\nw = w - v", {"W0": 0}),
    ("pins", "HIGH 3\nLOW 4\nTOGGLE 3\nTOGGLE 5\nOUTPUT 6\nINPUT 4\nREVERSE 4\nREVERSE 6",
     {"OUTS": 0b100000, "DIRS": 0b111000}),
    ("pin name", "p PIN 5\n" + WORD + "p = 1\nOUTPUT p\nw = p + 1", {"OUT5": 1, "W0": 2}),
]  # fmt: skip


@pytest.mark.parametrize("compile_after", [None, 0])
@pytest.mark.parametrize(
    ("source", "expected"), [row[1:] for row in CONFORMANCE], ids=[row[0] for row in CONFORMANCE]
)
def test_conformance(
    tokenizer: Tokenizer, source: str, expected: dict[str, int], compile_after: int | None
) -> None:
    made = chip_of(tokenizer, source, compile_after=compile_after)
    made.run(SECOND_NS)
    assert made.ended in (End.END, End.STOP)
    assert {name: made.registers[name] for name in expected} == expected


@pytest.mark.parametrize(
    "source",
    [
        WORD + "FOR w = 0 TO 65535\nNEXT",
        WORD + "FOR w = 0 TO 65535 STEP 3000\nNEXT",
        BYTE + "FOR b = 0 TO 300\nNEXT",
    ],
)
def test_loops_that_never_end(tokenizer: Tokenizer, source: str) -> None:
    """Ref: S2 p. 193 to 196."""
    made = chip_of(tokenizer, source)
    made.run(60 * SECOND_NS)
    assert made.ended is None
    assert made.instructions > 50_000


def test_a_fifth_gosub_loses_the_first(tokenizer: Tokenizer) -> None:
    """Five deep; four returns come back, the fifth finds nothing and begins anew (S2 p. 210)."""
    source = (
        "w VAR Word\nb VAR Byte\n"
        "b = b + 1\nIF b = 2 THEN done\nGOSUB one\nw = w + 1\nSTOP\n"
        "one: GOSUB two\nw = w + 2\nRETURN\ntwo: GOSUB three\nw = w + 4\nRETURN\n"
        "three: GOSUB four\nw = w + 8\nRETURN\nfour: GOSUB five\nw = w + 16\nRETURN\n"
        "five: RETURN\ndone: STOP"
    )
    for compile_after in (None, 0):
        made = chip_of(tokenizer, source, compile_after=compile_after)
        made.run(SECOND_NS)
        assert made.registers["W0"] == 2 + 4 + 8 + 16
        assert made.registers["B2"] == 2


def test_return_with_nothing_to_return_to_keeps_the_variables(tokenizer: Tokenizer) -> None:
    made = chip_of(tokenizer, "w VAR Word\nw = w + 1\nIF w = 3 THEN done\nRETURN\ndone: STOP")
    made.run(SECOND_NS)
    assert (made.ended, made.registers["W0"]) == (End.STOP, 3)


def test_reset_begins_anew_but_for_the_eeprom(tokenizer: Tokenizer) -> None:
    made = chip_of(
        tokenizer, "w VAR Word\nREAD 0, w\nWRITE 0, w + 1\nHIGH 2\nPAUSE 100\nw = 99\nSTOP"
    )
    made.run(50_000_000)
    assert (made.pins.directions, made.eeprom()[0]) == (4, 1)
    made.reset(hold_ns=1_000_000)
    assert (made.pins.directions, made.pins.wires[2].level) == (0, None)
    made.run(made.clock.now_ns + 50_000_000)
    assert (made.registers["W0"], made.eeprom()[0]) == (1, 2)


def test_when_it_ended_is_kept_until_a_reset(tokenizer: Tokenizer) -> None:
    made = chip_of(tokenizer, "PAUSE 5\nSTOP")
    made.run(SECOND_NS)
    ended_ns, state = made.ended_ns, made.snapshot()
    assert ended_ns is not None
    assert 5_000_000 < ended_ns < 5_500_000
    made.reset()
    assert made.ended_ns is None
    made.restore(state)
    assert made.ended_ns == ended_ns


def test_a_loop_that_does_nothing_is_the_end(tokenizer: Tokenizer) -> None:
    made = chip_of(tokenizer, "HIGH 1\nDO\nLOOP")
    made.run(SECOND_NS)
    assert made.ended is End.LOOP


def test_what_is_no_program_is_refused_with_its_place() -> None:
    image = Image(chip("BS2"), bytes(2046) + b"\xff\xff")
    with pytest.raises(ExecutionError, match="slot 0, stream bit"):
        Chip("chip", [image], Clock()).run(SECOND_NS)


def test_choices_reach_the_program(tokenizer: Tokenizer) -> None:
    source = "w VAR Word\nv VAR Word\nx VAR Word\nw = 7 / v\nIF NOT v = 0 THEN x = 1\nRANDOM v"
    for compile_after in (None, 0):
        made = chip_of(tokenizer, source, compile_after=compile_after)
        made.run(SECOND_NS)
        assert [made.registers[f"W{n}"] for n in range(3)] == [65535, 1, 0]
        other = replace(CHOICES, quotient_by_zero=3, true_word=1, random_inverts=False)
        made = chip_of(tokenizer, source, unknowns=other, compile_after=compile_after)
        made.run(SECOND_NS)
        assert [made.registers[f"W{n}"] for n in range(3)] == [3, 0, 1]
