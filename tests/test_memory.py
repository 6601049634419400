"""The memory report: every bit accounted for, calls never counted too shallow."""

import json
from pathlib import Path

import pytest

from cgagen.errors import BudgetError, SourceError
from cgagen.memory import MemoryReport, report
from cgagen.stamp.chips import EEPROM_BYTES
from cgagen.tokenizer import Tokenizer

HEAD = "' {$STAMP BS2}\n' {$PBASIC 2.5}\n"

ROBOT = (
    HEAD
    + """Led    PIN  3
Rows   CON  2
leg    VAR  Byte
width  VAR  Word
phase  VAR  Nib
flag   VAR  Bit

' the table: one row per state
Genes  DATA %101, 1, 2, 3   ' first row
       DATA "it's", 0
Pulses DATA WORD 1000, WORD $1234(Rows), (5)
Far    DATA @100, 9, 7(Rows * 2)

Main:
  DO
    GOSUB Walk
    IF leg = 3 THEN Other
  LOOP

Walk:                       ' GOSUB Main: would be a cycle, were it not a comment
  FOR leg = 0 TO 3
    GOSUB Pulse
  NEXT
  RETURN

Pulse:
  PULSOUT Led, width
  IF flag = 1 THEN RETURN
  PAUSE 20
  RETURN

Other:
  READ Genes, leg
  GOTO Main
"""
)

TEXT = """\
main.bs2 (BS2): 2048 bytes of EEPROM

  program                     60 bytes    2.9 %
  DATA                        25 bytes    1.2 %
  free                      1963 bytes   95.8 %

  program by routine        line    bits   bytes
  (header, 2 GOSUBs)                  42     5.2
  Main                        16      99    12.4
  Walk                        22     133    16.6
  Pulse                       28     132    16.5
  Other                       34      74     9.2

  DATA by label             line address   bytes
  Genes                       11       0       9
  Pulses                      13       9      11
  Far                         14     100       5

26 bytes of RAM

  used                         4 bytes: 1 word, 1 byte, 1 nibble, 1 bit
  free                        22 bytes

GOSUB depth: 2 of 4: Main > Walk > Pulse
"""


def sizes(tokenizer: Tokenizer, rest: str, head: str = HEAD) -> MemoryReport:
    return report(tokenizer.compile(head + rest, "main.bs2"))


def test_the_report_reads_well(tokenizer: Tokenizer) -> None:
    text = report(tokenizer.compile(ROBOT, "main.bs2")).to_text()
    assert text == TEXT


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_line_ends_change_nothing(tokenizer: Tokenizer, end: str) -> None:
    compiled = tokenizer.compile(ROBOT.replace("\n", end), "main.bs2")
    assert report(compiled).to_text() == TEXT


def test_every_vector_is_accounted_for(tokenizer: Tokenizer) -> None:
    vectors = json.loads((Path(__file__).parent / "vectors" / "tokens.json").read_text())
    for vector in vectors:
        compiled = tokenizer.compile(vector["source"], vector["id"])
        found = report(compiled)
        bits = found.header_bits + sum(part.bits for part in found.parts)
        assert bits == 8 * found.program_bytes, vector["id"]
        assert all(part.bits >= 0 for part in found.parts), vector["id"]
        assert found.free_bytes == EEPROM_BYTES - found.program_bytes - found.data_bytes
        if found.data is not None:
            assert sum(block.bytes for block in found.data) == found.data_bytes, vector["id"]


def test_most_data_of_the_vectors_is_told_apart(tokenizer: Tokenizer) -> None:
    vectors = json.loads((Path(__file__).parent / "vectors" / "tokens.json").read_text())
    with_data = [vector for vector in vectors if vector["data_bytes"]]
    found = [report(tokenizer.compile(vector["source"], vector["id"])).data for vector in with_data]
    assert with_data
    assert all(found)


@pytest.mark.parametrize(
    ("rest", "expected"),
    [
        ('d DATA "a:b", "c"\nHIGH 1\n', [("d", 0, 4)]),
        ("d DATA 1\nDATA 2\ne DATA 3\nHIGH 1\n", [("d", 0, 2), ("e", 2, 1)]),
        ("DATA 1, 2\nd DATA 3\nHIGH 1\n", [("(no label)", 0, 2), ("d", 2, 1)]),
        ("d DATA (20)\ne DATA d, e\nHIGH 1\n", [("d", 0, 20), ("e", 20, 2)]),
        ('d DATA CLS, "a", CR, e\ne DATA 1\nHIGH 1\n', [("d", 0, 4), ("e", 4, 1)]),
        ("n CON 3\nm CON n * 2 + 1\nd DATA 0(m)\nHIGH 1\n", [("d", 0, 7)]),
        ("d DATA @$10, %11, -1, 'x\nHIGH 1\n", None),  # refused by the tokenizer
        ('d DATA WORD "a", WORD (3), "xyz"(2)\nHIGH 1\n', None),  # may be beyond the reader
        ("d DATA @50, 1\ne DATA @40, 2\nHIGH 1\n", [("d", 50, 1), ("e", 40, 1)]),
    ],
)
def test_data_is_told_apart_or_not_at_all(
    tokenizer: Tokenizer, rest: str, expected: list[tuple[str, int, int]] | None
) -> None:
    try:
        found = sizes(tokenizer, rest)
    except SourceError:
        assert expected is None
        return
    if expected is not None:
        assert found.data is not None
        assert [(block.name, block.address, block.bytes) for block in found.data] == expected
    elif found.data is not None:
        assert sum(block.bytes for block in found.data) == found.data_bytes


def test_data_that_is_compiled_on_condition(tokenizer: Tokenizer) -> None:
    rest = "#DEFINE small = 1\n#IF small #THEN\nd DATA 1\n#ELSE\nd DATA 1, 2\n#ENDIF\nHIGH 1\n"
    found = sizes(tokenizer, rest)
    assert [(block.name, block.address, block.bytes) for block in found.data or ()] == [("d", 0, 1)]
    assert found.data_bytes == 1
    assert "DATA by label" in found.to_text()


def subs(*pairs: tuple[str, str]) -> str:
    """Return routines: (name, what it does before its RETURN)."""
    return "".join(f"{name}:\n  {body}\n  RETURN\n" for name, body in pairs)


@pytest.mark.parametrize(
    ("rest", "depth"),
    [
        ("HIGH 1\n", 0),
        ("GOSUB a\nEND\n" + subs(("a", "HIGH 1")), 1),
        ("GOSUB a\nEND\n" + subs(("a", "GOSUB b"), ("b", "GOSUB c"), ("c", "HIGH 1")), 3),
        # on a condition, in one line or in a block
        ("IF IN0 = 1 THEN GOSUB a\nEND\n" + subs(("a", "IF IN1 THEN GOSUB b"), ("b", "LOW 1")), 2),
        ("IF IN0 = 1 THEN\n GOSUB a\nENDIF\nEND\n" + subs(("a", "HIGH 1")), 1),
        # ON x GOSUB counts, with several targets
        ("ON B0 GOSUB a, b\nEND\n" + subs(("a", "HIGH 1"), ("b", "GOSUB a")), 2),
        # one routine jumps into another, which calls
        ("GOSUB a\nEND\na:\n HIGH 1\n GOTO c\n" + subs(("b", "LOW 1"), ("c", "GOSUB b")), 2),
        # one routine runs on into the next
        ("GOSUB a\nEND\na:\n HIGH 1\n" + subs(("c", "GOSUB b"), ("b", "LOW 1")), 2),
        # a conditional RETURN does not end the routine
        ("GOSUB a\nEND\na:\n IF IN0 THEN RETURN\n" + subs(("c", "GOSUB b"), ("b", "LOW 1")), 2),
        # by BRANCH, BUTTON, a time-out of SERIN
        ("GOSUB a\nEND\na:\n BRANCH B0, [c]\n RETURN\n" + subs(("b", ""), ("c", "GOSUB b")), 2),
        (
            "GOSUB a\nEND\na:\n SERIN 1, 84, 9, c, [B0]\n RETURN\n"
            + subs(("b", ""), ("c", "GOSUB b")),
            2,
        ),
        # never called: not counted
        ("HIGH 1\nEND\n" + subs(("a", "GOSUB b"), ("b", "LOW 1")), 0),
        # several statements a line, labels among them, upper and lower case
        ("GOSUB A : HIGH 1 : END\na: GOSUB b : RETURN\nB: LOW 1 : RETURN\n", 2),
        # words in texts and comments are no calls
        ('DEBUG "GOSUB a: b"\nEND \' GOSUB a\na: HIGH 1\nRETURN\n', 0),
        # recursion, direct, mutual, and by jumping back instead of returning
        ("GOSUB a\nEND\n" + subs(("a", "GOSUB a")), None),
        ("GOSUB a\nEND\n" + subs(("a", "GOSUB b"), ("b", "GOSUB a")), None),
        ("m:\nGOSUB a\nGOTO m\na:\n HIGH 1\n GOTO m\n", None),
        ("m:\nDO\n GOSUB a\nLOOP\na:\n IF IN0 THEN m\n RETURN\n", None),
        # a label inside a loop: the way back up is seen
        ("GOSUB in\nEND\na:\nDO\n GOSUB b\nin:\n HIGH 1\nLOOP\n" + subs(("b", "LOW 1")), 2),
        # labels inside a block: a way from before the block leads behind it
        (
            "GOSUB s\nEND\ns:\nIF IN0 THEN\n HIGH 1\ny:\n GOTO e\nz:\n LOW 1\nENDIF\n"
            "GOSUB a\ne:\nRETURN\n" + subs(("a", "HIGH 2")),
            2,
        ),
    ],
)
def test_depth_of_calls(tokenizer: Tokenizer, rest: str, depth: int | None) -> None:
    found = sizes(tokenizer, rest)
    assert found.gosub_depth == depth
    if depth is None:
        assert "without bound" in found.to_text()
        with pytest.raises(BudgetError, match="calls itself"):
            found.check()
    else:
        assert f"GOSUB depth: {depth} of 4" in found.to_text()
        found.check(max_gosub_depth=depth)
        if depth:
            with pytest.raises(BudgetError, match=f"calls are {depth} deep"):
                found.check(max_gosub_depth=depth - 1)


def test_code_before_the_first_label_has_a_name(tokenizer: Tokenizer) -> None:
    found = sizes(tokenizer, "HIGH 1\nGOSUB a\nEND\n" + subs(("a", "LOW 1")))
    assert [part.name for part in found.parts] == ["(start)", "a"]
    assert found.call_chain == ("(start)", "a")


def test_words_of_one_line_are_not_labels(tokenizer: Tokenizer) -> None:
    found = sizes(tokenizer, "a: DO : HIGH 1 : LOOP : END : STOP\nb: RETURN : c:\n")
    assert [part.name for part in found.parts] == ["a", "b", "c"]


def test_ram_is_counted_in_whole_bytes(tokenizer: Tokenizer) -> None:
    found = sizes(tokenizer, "w VAR Word(5)\nb VAR Byte(3)\nn VAR Nib\nt VAR Bit(5)\nHIGH 1\n")
    assert (found.ram_used_bytes, found.ram_free_bytes) == (15, 11)  # 10 + 3 + 9 bits
    found.check(min_free_ram_bytes=11)
    with pytest.raises(BudgetError, match="leaves 11 of 26 RAM bytes free, 12 are asked for"):
        found.check(min_free_ram_bytes=12)


def test_a_program_that_is_too_long_is_told_where_it_is_long(tokenizer: Tokenizer) -> None:
    found = sizes(tokenizer, "a:\nHIGH 1\nbig:\n" + "PULSOUT 1, 1000\n" * 450 + "c: LOW 1\n")
    assert found.free_percent < 20
    found.check(min_free_percent=found.free_percent)
    with pytest.raises(BudgetError, match=r"main\.bs2: .* 20 % .* most is in big \(line 5, "):
        found.check(min_free_percent=20)


def test_data_takes_of_what_is_free(tokenizer: Tokenizer) -> None:
    without = sizes(tokenizer, "HIGH 1\n").free_bytes
    assert sizes(tokenizer, "d DATA 1, (99)\nHIGH 1\n").free_bytes == without - 100


def test_the_json_says_what_the_text_says(tokenizer: Tokenizer) -> None:
    data = json.loads(json.dumps(report(tokenizer.compile(ROBOT, "main.bs2")).to_json()))
    assert (data["free_bytes"], data["ram_free_bytes"], data["gosub_depth"]) == (1963, 22, 2)
    assert [part["name"] for part in data["parts"]] == ["Main", "Walk", "Pulse", "Other"]
    assert data["variables"] == {"bits": 1, "nibbles": 1, "bytes": 1, "words": 1}
