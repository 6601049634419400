"""Line ends: LF, CR, CR LF and a mixture of them are the same program, and the same refusal."""

import itertools
import json
import re
from pathlib import Path

import pytest

from cgagen.errors import SourceError
from cgagen.stamp.chips import CHIPS
from cgagen.stamp.compiled import Compiled
from cgagen.tokenizer import Tokenizer
from tests.pbasic_random import RandomProgram

HERE = Path(__file__).parent
ENDS = {"LF": ["\n"], "CR": ["\r"], "mixed": ["\r\n", "\n", "\r", "\r", "\n"]}
EMPTY = ["'", "' ", "'\t", "'{", "' {", "'{ ", " '", "''", "'$"]
"""Comments with nothing in them, as published programs have them."""

PROGRAMS = {
    **{
        str(path.relative_to(HERE.parent)): path.read_bytes().decode("cp1252")
        for folder in (HERE / "programs", HERE.parent / "firmware")
        for path in sorted(folder.rglob("*.b[sp]?"))
    },
    **{
        vector["id"]: vector["source"]
        for vector in json.loads((HERE / "vectors" / "tokens.json").read_text())
    },
    **{
        f"random {model.name} {seed}": RandomProgram(seed, model).source()
        for model in CHIPS
        for seed in range(4)
    },
}


def ended(source: str, ends: list[str]) -> str:
    """Return a source with other line ends, in turn; a CR never meets an LF that is not its own."""
    turn = itertools.cycle(ends)
    *lines, last = re.split(r"\r\n|\r|\n", source)
    text = ""
    for line in lines:
        end = next(turn)
        text += line + ("\r" if end == "\n" and not line and text.endswith("\r") else end)
    return text + last


def facts(compiled: Compiled) -> tuple[object, ...]:
    """Return all that a source means, without places that count characters."""
    rows = [(one.line, one.column, one.bit) for one in compiled.source_map.statements]
    return (compiled.image, rows, compiled.variables, compiled.project_files, compiled.port,
            compiled.language, compiled.debugs, compiled.warnings)  # fmt: skip


def words_at(compiled: Compiled) -> list[str]:
    """Return the word that each statement of the source map begins with."""
    return [
        re.split(r"\W", compiled.source[one.offset :] + " ")[0]
        for one in compiled.source_map.statements
    ]


def test_there_are_programs() -> None:
    assert len(PROGRAMS) > 250


@pytest.mark.parametrize("name", PROGRAMS)
def test_line_ends_make_no_difference(tokenizer: Tokenizer, name: str) -> None:
    source = ended(PROGRAMS[name], ["\r\n"])
    wanted = tokenizer.compile(source)
    for ends in ENDS.values():
        other = tokenizer.compile(ended(source, ends))
        assert facts(other) == facts(wanted)
        assert words_at(other) == words_at(wanted)
    unended = tokenizer.compile(source.rstrip("\r\n"))
    assert facts(unended) == facts(wanted)


@pytest.mark.parametrize("name", list(PROGRAMS)[::9])
def test_an_empty_comment_makes_no_difference(tokenizer: Tokenizer, name: str) -> None:
    lines = ended(PROGRAMS[name], ["\n"]).split("\n")
    wanted = tokenizer.compile("\n".join(lines)).image
    comments = itertools.cycle(EMPTY)
    for ends in (["\r\n"], *ENDS.values()):
        for at in (0, 1, 2):
            more = [*lines[:at], next(comments), *lines[at:]]
            assert tokenizer.compile(ended("\n".join(more), ends)).image == wanted


@pytest.mark.parametrize("comment", EMPTY)
@pytest.mark.parametrize("ends", [["\r\n"], *ENDS.values()], ids=["CR LF", *ENDS])
def test_a_directive_behind_an_empty_comment_is_seen(
    tokenizer: Tokenizer, comment: str, ends: list[str]
) -> None:
    plain = "' {$STAMP BS2}\n' {$PBASIC 2.5}\n' {$PORT COM3}\nx VAR Byte\nDO\n HIGH 1\nLOOP\n"
    wanted = tokenizer.compile(plain)
    for at in range(4):
        lines = plain.split("\n")
        lines.insert(at, comment)
        compiled = tokenizer.compile(ended("\n".join(lines), ends))
        assert compiled.image == wanted.image
        assert (compiled.language, compiled.port) == (250, "COM3")
    behind_code = plain.replace("' {$PBASIC", f"x VAR Byte {comment}\n' {{$PBASIC")
    behind_code = behind_code.replace("x VAR Byte\nDO", "DO")
    assert tokenizer.compile(ended(behind_code, ends)).image == wanted.image


@pytest.mark.parametrize("ends", [["\r\n"], *ENDS.values()], ids=["CR LF", *ENDS])
@pytest.mark.parametrize(
    ("source", "place"),
    [
        ("' {$STAMP BS2}\n'\nHIGH 1\nGOTO nowhere\n", (4, 6, 111)),
        ("'\n' {$STAMP BS2}\n\n\nHIGH", (5, 5, 141)),
        ("' {$STAMP BS2}\n' {$PBASIC 2.5}\nIF B0 = 1 THEN\nHIGH 1\n", (3, 1, 168)),
        ("' {$STAMP BS2}\n'\nHIGH 16\n", (3, 1, 0)),
        ("' {$STAMP BS2}\n'\nDEBUG \"caf\u00e9\"\n", (3, 11, 0)),
    ],
)
def test_a_refusal_has_the_same_place(
    tokenizer: Tokenizer, source: str, place: tuple[int, int, int], ends: list[str]
) -> None:
    with pytest.raises(SourceError) as caught:
        tokenizer.compile(ended(source, ends))
    assert (caught.value.line, caught.value.column, caught.value.code) == place
