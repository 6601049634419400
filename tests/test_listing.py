"""Listings: what they say, and that the tokenizer makes the same image of them."""

import json
from pathlib import Path
from typing import Any

import pytest

from cgagen.errors import ImageError, SourceError
from cgagen.firmware import generate
from cgagen.genome import from_commands
from cgagen.robot import load_robot
from cgagen.stamp.chips import CHIPS, Chip, chip
from cgagen.stamp.decode import decode
from cgagen.stamp.image import Image
from cgagen.stamp.list_items import FORMATTERS
from cgagen.stamp.listing import listing, listing_text
from cgagen.stamp.opcodes import OPERATORS, opcodes_of
from cgagen.stamp.program import Program
from cgagen.stamp.statements import statement_text
from cgagen.tokenizer import Tokenizer
from cgagen.tokenizer.files import read_source
from tests.pbasic_random import RandomProgram
from tests.test_opcodes import operator_codes

HERE = Path(__file__).parent
VECTORS = json.loads((HERE / "vectors" / "tokens.json").read_text())
HEAD = "' {$STAMP BS2}\n' {$PBASIC 2.5}\n"
PROGRAMS_PER_CHIP = 80
TOO_COMPLEX = 144
"""The tokenizer's error for more than eight words of stack."""


def relisted(tokenizer: Tokenizer, source: str) -> Program:
    """Compile, list and compile again: the same bytes and the same use of each, both ways."""
    image = tokenizer.compile(source).image
    program = decode(image.eeprom, image.model, image.flags)
    again = tokenizer.compile(listing_text(program, image), "listing").image
    assert again.eeprom == image.eeprom
    assert again.flags == image.flags
    bare = Image(image.model, image.eeprom)
    text = listing_text(decode(bare.eeprom, bare.model), bare)
    assert tokenizer.compile(text, "listing").image.eeprom == image.eeprom
    return program


def listed(tokenizer: Tokenizer, code: str, head: str = HEAD) -> list[str]:
    """The statements of the listing of some code."""
    image = tokenizer.compile(head + code + "\n").image
    lines = listing(decode(image.eeprom, image.model, image.flags), image)
    return [" ".join(line.text.split()) for line in lines if "{$" not in line.text]


@pytest.mark.parametrize("vector", VECTORS, ids=lambda vector: str(vector["id"]))
def test_a_vector_relists_to_the_same_image(tokenizer: Tokenizer, vector: dict[str, Any]) -> None:
    relisted(tokenizer, vector["source"])


@pytest.mark.parametrize("file", sorted((HERE / "decode").iterdir()), ids=lambda file: file.name)
def test_a_program_relists_to_the_same_image(tokenizer: Tokenizer, file: Path) -> None:
    relisted(tokenizer, read_source(file))


@pytest.mark.parametrize("model", CHIPS, ids=lambda model: model.name)
def test_random_programs_relist_to_the_same_image(tokenizer: Tokenizer, model: Chip) -> None:
    """Every instruction and every operator of the chip is met, in at least 79 of 80 programs."""
    opcodes: set[int] = set()
    operators: set[int] = set()
    refused = []
    for seed in range(PROGRAMS_PER_CHIP):
        try:
            program = relisted(tokenizer, RandomProgram(seed, model).source())
        except SourceError as error:
            if error.code != TOO_COMPLEX or error.args[0].startswith("listing"):
                raise
            refused.append(seed)
            continue
        assert program.model == model
        opcodes |= {instruction.opcode.code for instruction in program.instructions}
        operators |= set().union(*map(operator_codes, program.instructions))
    assert len(refused) <= 1
    assert opcodes == set(opcodes_of(model))
    assert operators == {row.code for row in OPERATORS}


def test_the_firmware_relists_to_the_same_image(tokenizer: Tokenizer) -> None:
    genome = from_commands([state % 8 for state in range(64)], "servobot-predator")
    for name, genes in (("servobot-predator", genome), ("servobot-prey", None)):
        programs = generate(load_robot(name), genes).programs
        assert len(programs) == 2
        for program in programs:
            assert len(relisted(tokenizer, program.source).instructions) > 50


STRUCTURES = [
    ("IF B0 = 1 THEN HIGH 1", ["IF B0 = 1 THEN L83", "GOTO L98", "L83: HIGH 1", "L98:"]),
    ("DO\nHIGH 1\nLOOP", ["L14: HIGH 1", "GOTO L14"]),
    ("DO\nHIGH 1\nLOOP WHILE B0 < 5", ["L14: HIGH 1", "IF B0 < 5 THEN L14"]),
    (
        "DO\nLOOP UNTIL B0 = 5 OR B1",
        ["L14: IF (B0 = 5) OR B1 THEN L104", "GOTO L14", "L104:"],
    ),
    (
        "DO UNTIL B0 = 1\nLOOP",
        ["L14: IF B0 = 1 THEN L83", "GOTO L14", "L83:"],
    ),
    (
        "SELECT B0\nCASE 1 TO 3\nHIGH 1\nCASE ELSE\nLOW 1\nENDSELECT",
        [
            "IF (B0 >= 1) AND (B0 <= 3) THEN L118",
            "GOTO L154",
            "L118: HIGH 1",
            "GOTO L169",
            "L154: LOW 1",
            "L169:",
        ],
    ),
    ("ON B0 GOTO a, b\na:\nb:", ["BRANCH B0, [L63, L63]", "L63:"]),
    ("FOR B0 = 1 TO 9 STEP 2\nNEXT", ["FOR B0 = 1 TO 9 STEP 2", "NEXT"]),
    (
        "FOR B0 = 1 TO 9\nIF B1 THEN EXIT\nNEXT",
        ["FOR B0 = 1 TO 9", "IF B1 THEN L95", "GOTO L116", "L95: GOTO L188", "L116: NEXT", "L188:"],
    ),
    (
        "x:\nON B0 GOSUB a, b\nEND\na:\nRETURN\nb:\nRETURN",
        ["ON B0 GOSUB L120, L127", "END", "L120: RETURN", "L127: RETURN"],
    ),
]


@pytest.mark.parametrize(("code", "lines"), STRUCTURES)
def test_a_structure_is_listed_taken_apart(
    tokenizer: Tokenizer, code: str, lines: list[str]
) -> None:
    assert listed(tokenizer, code) == lines
    relisted(tokenizer, HEAD + code + "\n")


STATEMENTS = [
    ('DEBUG "He said", CR, DEC3 W1, 9', 'DEBUG "He said", CR, DEC3 W1, 9'),
    ('DEBUG "a", 34, "b"', 'DEBUG "a", 34, "b"'),
    ("SEROUT 16, 84, [65]", 'DEBUG "A"'),
    ("SEROUT 16, 85, [65]", 'SEROUT 16, 85, ["A"]'),
    ("DEBUG 233", "DEBUG 233"),
    ("DEBUG ISBIN16 W0, REP 5\\B0, STR B3\\2, STR B3", None),
    (
        'SERIN 1, 84, [WAIT("abc"), STR B0\\3\\13]',
        "SERIN 1, 84, [WAIT (97, 98, 99), STR B0\\3\\13]",
    ),
    ("SERIN 1\\2, 84, 100, a, [SNUM W0]\na:", "SERIN 1\\2, 84, 100, L128, [SNUM W0]"),
    ("W0 = W1 + (B0 * 3) - 1", None),
    ("W0 = (W1 + B0) * 3", "W0 = W1 + B0 * 3"),
    ("W0 = - (W1 + 1)", None),
    ("W0 = -1", "W0 = - 1"),
    ("INS = OUT3(B0) + DIRA", None),
    ("B3.BIT5(W1) = B2.NIB1", None),
    ("XOUT 0, 1, [2\\3]", "XOUT 0, 1, [2\\3\\2]"),
    ("SHIFTOUT 0, 1, 1, [B0]", "SHIFTOUT 0, 1, 1, [B0\\8]"),
    ("DTMFOUT 9, [5]", "DTMFOUT 9, 200, 50, [5]"),
    ("LOOKDOWN B0, [1, 2], B1", "LOOKDOWN B0, = [1, 2], B1"),
    ("READ 3, WORD W1", "READ 3, W1"),
]


@pytest.mark.parametrize(("code", "line"), STATEMENTS)
def test_a_statement_is_listed(tokenizer: Tokenizer, code: str, line: str | None) -> None:
    """None: exactly as it was written."""
    assert listed(tokenizer, code)[0] == (line or code)
    relisted(tokenizer, HEAD + code + "\n")


def test_a_pin_symbol_that_is_read_and_written_is_declared(tokenizer: Tokenizer) -> None:
    lines = listed(tokenizer, "Led PIN 3\nRANDOM Led\nFOR Led = 0 TO 1\nNEXT\nHIGH Led")
    assert lines == ["Pin3 PIN 3", "RANDOM Pin3", "FOR Pin3 = 0 TO 1", "NEXT", "HIGH 3"]


def test_data_keeps_what_is_reserved(tokenizer: Tokenizer) -> None:
    code = 'DATA 1, 0, (3), WORD 1000, @40, "text"(2)\nDATA @60, 0(17)\nHIGH 1'
    assert listed(tokenizer, code)[1:] == [
        "DATA @0, 1, 0",
        "DATA @2, (3)",
        "DATA @5, 232, 3",
        "DATA @40, 116, 101, 120, 116, 116",
        "DATA @60, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0",
        "DATA @76, 0",
    ]
    relisted(tokenizer, HEAD + code + "\n")


def test_a_long_reserve_is_one_line(tokenizer: Tokenizer) -> None:
    assert listed(tokenizer, "HIGH 1\nDATA (40)") == ["HIGH 1", "DATA @0, (40)"]


def test_a_jump_to_the_last_seven_bits(tokenizer: Tokenizer) -> None:
    """They are an END although they look like the padding of the last byte."""
    program = relisted(tokenizer, HEAD + "GOTO a\nHIGH 1\nEND\na:\n")
    assert program.end_bit == 64
    assert program.instructions[-1].address == program.instructions[0].targets[0] == 57


def test_notes_stand_before_their_instruction(tokenizer: Tokenizer) -> None:
    image = tokenizer.compile(HEAD + "HIGH 1\nagain:\nGOTO again\n").image
    program = decode(image.eeprom, image.model, image.flags)
    text = listing_text(program, image, {29: ("1: again", "2: GOTO again")})
    assert text.splitlines()[2:] == [
        "        HIGH 1",
        "        ' 1: again",
        "        ' 2: GOTO again",
        "L29:    GOTO L29",
    ]
    assert tokenizer.compile(text).image == image


def test_every_line_says_where_it_is(tokenizer: Tokenizer) -> None:
    image = tokenizer.compile(HEAD + "HIGH 1\nHIGH 2\nDATA 1\n").image
    lines = listing(decode(image.eeprom, image.model, image.flags), image)
    assert [line.address for line in lines] == [None, None, 14, 29, None]


def test_each_formatter_has_one_word() -> None:
    assert len(FORMATTERS) == len(set(FORMATTERS.values())) == 2 * 6 + 4 * 5 + 4 * 17 + 2
    known = {0x1B6: "DEC", 0x3D6: "DEC3", 0x5B6: "SDEC", 0x1C0: "HEX", 0x3E0: "HEX2"}
    known |= {0xBC0: "IHEX4", 0xF0E: "ISBIN16", 0x10E: "BIN", 0x38E: "BIN8", 0x1106: "NUM"}
    assert {word: FORMATTERS[word] for word in known} == known


def test_a_program_of_end_alone(tokenizer: Tokenizer) -> None:
    image = tokenizer.compile(HEAD + "END\n").image
    bare = Image(image.model, image.eeprom)
    text = listing_text(decode(bare.eeprom, bare.model), bare)
    assert text.splitlines()[2:] == ["        END"]


def bits_changed(image: Image, address: int, bits: str) -> bytes:
    """The image's bytes with other bits from a stream address on."""
    eeprom = bytearray(image.eeprom)
    for index, bit in enumerate(bits, address):
        mask = 1 << 7 - index % 8
        place = 2047 - index // 8
        eeprom[place] = eeprom[place] & ~mask | (mask if bit == "1" else 0)
    return bytes(eeprom)


STRANGE = [
    # (code, stream bit, other bits, what the listing says)
    ("HIGH 1\nGOTO a\na:", 36, "100" + f"{2:011b}", "stream bit 20 .*no statement starts"),
    ("GOSUB a\na:", 14, "000" + f"{1:011b}", "stream bit 28 .*returns to a strange place"),
    ("GOSUB a\na:", 35, f"{2:08b}", "GOSUB has the number 2 out of order"),
    ("FOR B0 = 1 TO 3\nNEXT", 29, "00111", "a NEXT does not fit"),
]


@pytest.mark.parametrize(("code", "bit", "bits", "words"), STRANGE)
def test_what_the_tokenizer_never_makes_is_refused(
    tokenizer: Tokenizer, code: str, bit: int, bits: str, words: str
) -> None:
    image = tokenizer.compile(HEAD + code + "\n").image
    eeprom = bits_changed(image, bit, bits)
    with pytest.raises(ImageError, match=words):
        listing(decode(eeprom, image.model, image.flags), image)


def test_statements_read_well_alone(tokenizer: Tokenizer) -> None:
    """As a trace of the emulator shows them."""
    code = "FOR B0 = 1 TO 3\nBUTTON 1, 0, 9, 1, B1, 1, a\na:\nNEXT"
    image = tokenizer.compile(HEAD + code + "\n").image
    program = decode(image.eeprom, chip("BS2"), image.flags)
    texts = [statement_text(instruction, chip("BS2")) for instruction in program.instructions]
    assert texts == ["B0 = 1", "BUTTON 1, 0, 9, 1, B1, 1, L129", "NEXT", "END"]
