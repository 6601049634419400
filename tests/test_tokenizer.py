"""The tokenizer: every vector byte for byte, and every refusal in its place."""

import json
import re
from pathlib import Path
from typing import Any

import pytest

from cgagen.errors import SourceError
from cgagen.stamp.packets import packets_of
from cgagen.tokenizer import Tokenizer
from tests.compile_cases import HEAD, LED, LED_TAIL

VECTORS = json.loads((Path(__file__).parent / "vectors" / "tokens.json").read_text())


def test_there_are_91_vectors() -> None:
    assert len({vector["id"] for vector in VECTORS}) == 91


@pytest.mark.parametrize("vector", VECTORS, ids=lambda vector: str(vector["id"]))
def test_a_vector_reproduces(tokenizer: Tokenizer, vector: dict[str, Any]) -> None:
    compiled = tokenizer.compile(vector["source"], vector["id"])
    eeprom = bytearray(2048)
    tail = bytes.fromhex(vector["program_tail_hex"])
    eeprom[2048 - len(tail) :] = tail
    for address, byte in vector["data_bytes"].items():
        eeprom[int(address)] = int(byte, 16)
    assert compiled.image.model.directive == vector["model"]
    assert compiled.image.eeprom == bytes(eeprom)
    assert [packet.hex() for packet in packets_of(compiled.image)] == vector["packets"]
    assert list(compiled.variables) == vector["var_counts"]
    assert compiled.start_bit == vector["start_bit"]
    assert compiled.gosub_slots == vector["start_bit"] // 14 - 1
    assert compiled.program_bytes == vector["program_bytes"]
    rows = compiled.source_map.statements
    assert [[row.offset, row.bit] for row in rows] == vector["xref"]
    lines = vector["source"].split("\n")
    for row in rows:
        assert vector["source"][row.offset :].startswith(lines[row.line - 1][row.column - 1 :])


REFUSED = [
    # (source after HEAD, code, line, column, length, words)
    ("x VAR Word\nx = foo + 1\n", 110, 4, 5, 3, "Undefined symbol (foo)"),
    ("foo = 1\n", 174, 3, 1, 3, "Label is missing ':' (foo)"),
    ("PUT 1, 2\n", 174, 3, 1, 3, "(PUT)"),
    ("GOTO nowhere\n", 111, 3, 6, 7, "Undefined label (nowhere)"),
    ("d DATA (2049)\n", 114, 3, 9, 4, "Location is out of range (2049)"),
    ("w VAR Word(14)\n", 126, 3, 12, 2, "Out of variable space (14)"),
    ("i VAR Nib\nFOR i = 0 TO 3\n", 169, 4, 1, 3, "'FOR' without 'NEXT' (FOR)"),
    ("DO\n", 170, 3, 1, 2, "'DO' without 'LOOP'"),
    ("IF IN0 = 1 THEN\n", 168, 3, 1, 2, "'IF' without 'ENDIF'"),
    ("NEXT\n", 132, 3, 1, 4, "(NEXT)"),
    ("LOOP\n", 164, 3, 1, 4, "(LOOP)"),
    ("ENDIF\n", 160, 3, 1, 5, "(ENDIF)"),
    ("a CON 70000\n", 109, 3, 7, 6, "Constant exceeds 16 bits (70000)"),
    ("a23456789012345678901234567890123:\n", 106, 3, 1, 33, "Symbol exceeds 32 characters"),
    ("x PIN 16\n", 175, 3, 7, 2, "Pin number"),
    ("x VAR Word\nx = 1 / 0 CON\n", None, 4, None, None, ""),
    ("HIGH 1\r\n\r\n  HIGH foo\r\n", 110, 5, 8, 3, "(foo)"),
    ("HIGH 1\r\rHIGH foo\r", 110, 5, 6, 3, "(foo)"),
    ("a:\nGOSUB a\n" * 1 + "GOSUB a\n" * 255, 145, 259, 1, 5, "Limit of 255 GOSUBs exceeded"),
    ('#ERROR "too many"\n', 199, 3, 1, 17, "199-too many"),
]


@pytest.mark.parametrize(
    ("rest", "code", "line", "column", "length", "words"), REFUSED, ids=lambda case: repr(case)[:20]
)
def test_a_refusal_has_its_place(
    tokenizer: Tokenizer,
    rest: str,
    code: int | None,
    line: int,
    column: int | None,
    length: int | None,
    words: str,
) -> None:
    with pytest.raises(SourceError) as caught:
        tokenizer.compile(HEAD + rest, "main.bsp")
    error = caught.value
    assert error.line == line
    assert code is None or (error.code, error.column, error.length) == (code, column, length)
    assert str(error).startswith(f"main.bsp:{error.line}:{error.column}: {error.code}-")
    assert words in str(error)
    assert "\n" not in str(error)


@pytest.mark.parametrize(
    ("source", "code"),
    [
        (HEAD + "d DATA @2030, 1, 2, 3\n" + "HIGH 1\n" * 20, 124),
        (HEAD + "".join(f"c{n} CON {n}\n" for n in range(1100)) + "HIGH 1\n", 128),
        ("HIGH 1\n", 156),
        ("", 156),
        (HEAD + "' nothing\n", 157),
    ],
)
def test_an_error_without_a_place_names_no_line(
    tokenizer: Tokenizer, source: str, code: int
) -> None:
    with pytest.raises(SourceError) as caught:
        tokenizer.compile(source, "main.bsp")
    assert (caught.value.code, caught.value.line, caught.value.column) == (code, None, None)
    assert str(caught.value).startswith(f"main.bsp: {code}-")


def test_other_targets_are_refused_where_they_are_named(tokenizer: Tokenizer) -> None:
    with pytest.raises(SourceError, match=r"p:1:11: 204-.*\(BS1\)"):
        tokenizer.compile("' {$STAMP BS1}\nHIGH 1\n", "p")
    with pytest.raises(SourceError, match=r"p:2:12: 187-"):
        tokenizer.compile("' {$STAMP BS2}\n' {$PBASIC 3.0}\nHIGH 1\n", "p")


def test_a_full_eeprom_and_too_many_elements_are_located(tokenizer: Tokenizer) -> None:
    with pytest.raises(SourceError) as full:
        tokenizer.compile(HEAD + "PULSOUT 1, 1000\n" * 800)
    assert full.value.code == 127
    assert full.value.line is not None
    assert full.value.line > 400
    with pytest.raises(SourceError, match="107-Too many elements"):
        tokenizer.compile(HEAD + "x VAR Word\n" + "x=x+1\n" * 2200)


# --- silent changes -------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("rest", "line", "column", "words"),
    [
        ('DEBUG "caf\u00e9"\n', 3, 11, "U+00E9"),
        ('DEBUG "\u03c0"\n', 3, 8, "U+03C0"),
        ("HIGH 1\x00\nHIGH 2\n", 3, 7, "control character 0"),
        ("HIGH 1\n\tHIGH\x032\n", 4, 6, "control character 3"),
        ("HIGH\f1\n", 3, 5, "control character 12"),
        ("HIGH 1\n\x1aHIGH 2\n", 4, 1, "control character 26"),
        ('DEBUG "a\x1a"\n', 3, 9, "control character 26"),
        ("HIGH 1 ' {$PORT \x07}\n", 3, 17, "control character 7"),
        ("HIGH 1 ' {$PORT COM\u00e9}\n", 3, 20, "U+00E9"),
        ("H\u0130GH 1\n", 3, 2, "U+0130"),
        ("HIGH 1\x7f\n", 3, 7, "control character 127"),
        ('DEBUG "\ud800"\n', 3, 8, "U+D800"),
    ],
)
def test_what_would_change_silently_is_refused(
    tokenizer: Tokenizer, rest: str, line: int, column: int, words: str
) -> None:
    with pytest.raises(SourceError) as caught:
        tokenizer.compile(HEAD + rest, "p")
    assert (caught.value.line, caught.value.column, caught.value.code) == (line, column, 0)
    assert words in str(caught.value)
    str(caught.value).encode()  # can be printed


def test_foreign_letters_in_comments_change_nothing(tokenizer: Tokenizer) -> None:
    plain = tokenizer.compile(HEAD + "HIGH 3 ' 5 us\n")
    foreign = tokenizer.compile(HEAD + "HIGH 3 ' 5 \u00b5s \x07\x00 \U0001f916\n")
    assert foreign.image.eeprom == plain.image.eeprom
    assert foreign.source.endswith("\U0001f916\n")
    assert foreign.warnings == ()


@pytest.mark.parametrize("end", ["\n", "\r", "\r\n"])
@pytest.mark.parametrize(
    ("rest", "place", "what"),
    [
        ("HIGH 1{}\x1a", (4, 1), "Ctrl-Z"),
        ("HIGH 1{}\x1a{}\x1a\x1a \t{}", (4, 1), "Ctrl-Z"),
        ("HIGH 1\x1a{}", (3, 7), "Ctrl-Z"),
        ("HIGH 1{}\f{}", (4, 1), "a form feed"),
        ("\f{}HIGH 1{} \f\t{}", (3, 1), "a form feed"),
    ],
)
def test_a_control_character_between_statements_is_a_blank(
    tokenizer: Tokenizer, rest: str, place: tuple[int, int], what: str, end: str
) -> None:
    said: list[str] = []
    with Tokenizer(warn=said.append) as telling:
        compiled = telling.compile(HEAD + rest.format(*[end] * 9), "p")
    assert compiled.image.eeprom == tokenizer.compile(HEAD + "HIGH 1\n").image.eeprom
    assert [one[:2] for one in compiled.warnings] == [place]
    line, column = place
    assert said == [f"p:{line}:{column}: warning: {what} is taken for a blank; leave it out"]


@pytest.mark.parametrize("size", [65_535, 65_536, 4_000_000])
def test_a_source_that_cannot_be_numbered_is_refused(tokenizer: Tokenizer, size: int) -> None:
    source = LED + "'" * (size - len(LED) - 1) + "\n"
    if size == 65_535:
        assert tokenizer.compile(source).image.eeprom.endswith(LED_TAIL)
    else:
        with pytest.raises(SourceError, match="65,535"):
            tokenizer.compile(source, "long.bs2")


@pytest.mark.parametrize(
    "rest",
    [
        "HIGH 16",
        "x CON 16\nHIGH x",
        "IF IN0 = 1 THEN LOW 16",
        "PULSOUT 16, 5",
        "PULSIN 65535, 1, B0",
        "RCTIME 16, 1, W0",
        "COUNT 16, 1, W0",
        "PWM 16, 1, 1",
        "FREQOUT 16, 1, 1",
        "FREQOUT 16, 1, 1, 1",
        "DTMFOUT 16, [1]",
        "XOUT 1, 16, [0\\1]",
        "SHIFTOUT 16, 1, 0, [1]",
        "SHIFTIN 1, 16, 0, [B0]",
        "BUTTON 16, 0, 0, 0, B0, 0, x\nx:",
        "SEROUT 17, 84, [1]",
        "SEROUT 1\\16, 84, [1]",
        "SERIN 17, 84, [B0]",
        "INPUT 20",
        "TOGGLE 16",
    ],
)
def test_a_pin_that_no_chip_has_is_refused(tokenizer: Tokenizer, rest: str) -> None:
    with pytest.raises(SourceError, match=r"p:\d+:\d+: [A-Z]+ names pin \d+; give one of 0 to"):
        tokenizer.compile(HEAD + rest + "\n", "p")


@pytest.mark.parametrize(
    "rest",
    [
        "LCDCMD 16, 1",
        "LCDOUT 16, 1, [1]",
        "I2COUT 16, 1, 1, [1]",
        "OWOUT 16, 1, [1]",
        "POLLIN 16, 1",
    ],
)
def test_pins_of_the_bs2p_are_judged_too(tokenizer: Tokenizer, rest: str) -> None:
    with pytest.raises(SourceError, match="names pin 16"):
        tokenizer.compile(HEAD.replace("BS2}", "BS2p}") + rest + "\n", "p")


@pytest.mark.parametrize(
    "rest",
    [
        "HIGH 15",
        "SEROUT 16, 84, [16]",
        "SERIN 16, 84, [B0]",
        "SERIN 16\\15, 84, [B0]",
        "SEROUT 16, 84, 100, [1]",
        "HIGH B0 + 16",
        "HIGH 8 + 8",  # computed at run time
        'DEBUG "HIGH 16", CR',
        "PULSOUT 15, 65535",
        "FREQOUT 1, 16, 17, 18",
        "OUTS = 16",
        "x CON 16\nDEBUG DEC x",
        "IF IN0 = 16 THEN HIGH 1",
        "FOR B0 = 16 TO 20 : HIGH B0 : NEXT",
        "SHIFTOUT 1, 2, 0, [16\\16]",
        "XOUT 1, 2, [16\\17]",
    ],
)
def test_legal_pins_raise_no_alarm(tokenizer: Tokenizer, rest: str) -> None:
    assert tokenizer.compile(HEAD + rest + "\n").program_bytes > 0


@pytest.mark.parametrize(
    ("code", "place", "words"),
    [
        ("w VAR Word(2)\nDEBUG STR w\\3", "4:11", "STR w names a word, which .* the byte OUTH"),
        ("DEBUGIN WAITSTR W2", "3:17", "WAITSTR W2 names .* DIRH"),
        ("x VAR Byte\ny VAR Word\nz VAR y\nSERIN 1, 84, [x, str z\\4]", "6:22", "STR z"),
        ('HIGH 1 : DEBUG "STR", CR, STR ? OUTS', "3:33", "STR OUTS names .* INH"),
        ("w VAR Word\nDEBUG DEC 3,\n  STR w", "5:7", "STR w"),
    ],
)
def test_a_string_of_words_is_a_warning(
    tokenizer: Tokenizer, code: str, place: str, words: str
) -> None:
    """The tokenizer says so of nibbles and bits alone (136-Expected a byte variable)."""
    said: list[str] = []
    with Tokenizer(warn=said.append) as telling:
        compiled = telling.compile(HEAD + code + "\n", "p")
    assert len(said) == len(compiled.warnings) == 1
    assert re.match(rf"p:{place}: warning: {words}", said[0])
    assert compiled.warnings[0][:2] == tuple(map(int, place.split(":")))


def test_the_image_of_a_string_of_words_is_the_tokenizers(tokenizer: Tokenizer) -> None:
    """It reads the byte whose number the word has: W0, word 3 of RAM, the byte 3 of RAM."""
    word = tokenizer.compile(HEAD + "w VAR Word\nDEBUG STR w\\2\n")
    byte = tokenizer.compile(HEAD + "w VAR Word\nDEBUG STR OUTH\\2\n")
    assert word.image.eeprom == byte.image.eeprom


@pytest.mark.parametrize(
    "code",
    [
        "b VAR Byte(3)\nw VAR Word\nDEBUG STR b\\w",
        "w VAR Word\nh VAR w.HIGHBYTE\nDEBUG STR h, DEC w",
        'w VAR Word\nDEBUG "STR w", CR \' STR w',
        "#IF 0 #THEN\nw VAR Word\nDEBUG STR w\n#ENDIF\nDEBUG STR B0\\2",
        "str1 VAR Word\nDEBUG DEC str1",
    ],
)
def test_a_string_of_bytes_raises_no_alarm(tokenizer: Tokenizer, code: str) -> None:
    compiled = tokenizer.compile(HEAD + code + "\n")
    assert compiled.program_bytes > 0
    assert compiled.warnings == ()


# --- what else a source says -----------------------------------------------------------------


def test_further_files_and_the_port_are_reported(tokenizer: Tokenizer) -> None:
    compiled = tokenizer.compile(
        "' {$STAMP BS2p, sensors.bsp, \"two words.bsp\"}\n' {$PORT COM3}\nHIGH 1\n"
    )
    assert compiled.project_files == ("sensors.bsp", "two words.bsp")
    assert (compiled.port, compiled.language, compiled.debugs) == ("COM3", 200, False)
    assert tokenizer.compile(HEAD + 'DEBUG "x"').debugs
