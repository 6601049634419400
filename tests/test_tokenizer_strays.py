"""What the tokenizer passes over: harmless characters are told, others refused."""

import json
import re

import pytest

from cgagen.errors import SourceError
from cgagen.stamp.conditional import live_text
from cgagen.stamp.symbols import symbols_of
from cgagen.tokenizer import Tokenizer
from tests.compile_cases import HEAD
from tests.emulate_cases import Emulate, Program

PROGRAM = HEAD + "main:\nHIGH 3\nLOW 3\nGOTO main\n"


@pytest.mark.parametrize(
    ("source", "place", "char"),
    [
        (PROGRAM + "\x1a" * 128, (7, 1), "Ctrl-Z"),
        (PROGRAM[:-1] + "\x1a", (6, 10), "Ctrl-Z"),
        (PROGRAM + "\x00\x00\x00", (7, 1), "the control character 0"),
        (PROGRAM.replace("main:\n", "\x0cmain:\n"), (3, 1), "a form feed"),
        (PROGRAM.replace("HIGH 3\n", "HIGH 3 \x0c\n"), (4, 8), "a form feed"),
        (PROGRAM.replace("HIGH 3\n", "HIGH 3 \x0b ' on\n"), (4, 8), "the control character 11"),
        ("\x0c" + PROGRAM, (1, 1), "a form feed"),
    ],
)
@pytest.mark.parametrize("end", ["\n", "\r", "\r\n"])
def test_control_characters_at_the_edge_of_a_line_are_blanks(
    tokenizer: Tokenizer, source: str, place: tuple[int, int], char: str, end: str
) -> None:
    source = source.replace("\n", end)
    plain = tokenizer.compile(PROGRAM)
    compiled = tokenizer.compile(source)
    assert compiled.image.eeprom == plain.image.eeprom
    (warning,) = compiled.warnings
    assert (warning.line, warning.column) == place
    assert warning.text == f"{char} is taken for a blank; leave it out"
    # Places are those of the file, and nothing that is read of the source later trips over it.
    assert len(compiled.source) == len(source)
    assert symbols_of(compiled).labels.keys() == {"main"}
    assert [s.line for s in compiled.source_map.statements] == [
        s.line for s in plain.source_map.statements
    ]


@pytest.mark.parametrize(
    ("line", "column"),
    [
        ("HIGH 1 ' page\x0cHIGH 2", 14),
        ("HIGH 1 ' caf\u00e9 \x07 LOW 1", 15),
        ("HIGH 1\x0cHIGH 2", 7),
        ("IF IN0 = 1 THEN\x0cLOW 1 : ENDIF", 16),
        ("' {$PORT COM1\x0c}", 14),
        ('DEBUG "a\x0bb"', 9),
    ],
)
def test_code_behind_a_control_character_is_refused(
    tokenizer: Tokenizer, line: str, column: int
) -> None:
    """The tokenizer ends a comment there, so that what an editor shows as one would be code."""
    with pytest.raises(SourceError, match=r"control character \d+ silently") as caught:
        tokenizer.compile(HEAD + line + "\n", "p")
    assert (caught.value.line, caught.value.column) == (3, column)


@pytest.mark.parametrize(
    ("comment", "column"),
    [
        ("' {$STAMP BS2} {$PBASIC 2.5}", 16),
        ("'{$STAMP BS2}{$PBASIC 2.5}", 14),
        ("HIGH 1 ' { $stamp bs2} ' {$pbasic 2.5}", 26),
    ],
)
def test_a_directive_behind_another_is_not_seen(
    tokenizer: Tokenizer, comment: str, column: int
) -> None:
    compiled = tokenizer.compile(comment + "\nx:\nHIGH 2\n")
    assert compiled.language == 200
    (warning,) = compiled.warnings
    assert (warning.line, warning.column) == (1, column)
    assert "its own line" in warning.text


@pytest.mark.parametrize(
    "line",
    [
        "' say {$STAMP BS2p} or {$PBASIC 2.5}",
        "' {$PORT COM1} $ {x}",
        'DEBUG "{$$}{"',
        "' '{$STAMP BS2} {$PBASIC 2.5}",
    ],
)
def test_what_is_no_directive_raises_no_alarm(tokenizer: Tokenizer, line: str) -> None:
    compiled = tokenizer.compile(HEAD + line + "\nHIGH 1\n")
    assert compiled.warnings == ()
    # ... and is none for our own reading either.
    told = "#SELECT $STAMP\n#CASE BS2\nHIGH 1\n#CASE #ELSE\nLOW 1\n#ENDSELECT\n"
    assert live_text(f"{line}\n{HEAD}{told}").split() == [*live_text(line).split(), "HIGH", "1"]


def test_foreign_letters_behind_a_directive_change_nothing(tokenizer: Tokenizer) -> None:
    source = "' {$STAMP BS2} f\u00fcr K\u00e4fer\n' {$PBASIC 2.5}\nHIGH 1\n"
    assert tokenizer.compile(source).image == tokenizer.compile(HEAD + "HIGH 1\n").image


@pytest.mark.parametrize("end", ["\n", "\r", "\r\n"])
def test_the_longest_source_has_as_many_characters_with_any_line_end(
    tokenizer: Tokenizer, end: str
) -> None:
    """Its places are 16-bit numbers; a comment needs none."""
    few = HEAD + "' a\n" * 16_000 + "HIGH 3\nfoo = 1\n"
    assert 64_000 < len(few) < 65_535
    with pytest.raises(SourceError, match=r"p:16004:1: 174-.*\(foo\)"):
        tokenizer.compile(few.replace("\n", end), "p")
    good = few.replace("foo = 1", "LOW 3").replace("\n", end)
    compiled = tokenizer.compile(good)
    last = compiled.source_map.statements[-1]
    assert (last.line, last.column) == (16_004, 1)
    assert re.match("LOW 3", good[last.offset :])
    many = HEAD + "HIGH 3\n" + ":\n" * 32_800
    with pytest.raises(SourceError, match="more than the 65,535"):
        tokenizer.compile(many.replace("\n", end), "p")


def test_a_tokenizer_tells_each_warning_once() -> None:
    told: list[str] = []
    with Tokenizer(warn=told.append) as own:
        for _ in range(2):
            assert len(own.compile(PROGRAM + "\x1a", "old.bs2").warnings) == 1
        own.compile(PROGRAM, "new.bs2")
    assert told == ["old.bs2:7:1: warning: Ctrl-Z is taken for a blank; leave it out"]


def test_warnings_are_in_the_result_of_a_run(emulate: Emulate, program: Program) -> None:
    path = program(HEAD + "w VAR Word\nDEBUG STR w\\2\n")
    code, out, err = emulate(path, "--json")
    (warning,) = json.loads(out)["warnings"]
    assert code == 0
    assert warning["text"] in err
    assert {**warning, "text": ""} == {"file": str(path), "line": 4, "column": 11, "text": ""}
