"""A program may be spelled in any way: what it does is judged, and nothing else.

The same instructions under other names, with other comments, blanks and capitals, have the same
verdicts, right or wrong.
"""

import json
import re
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from cgagen.cli import cgagen
from cgagen.firmware.render import shipped_templates
from cgagen.tokenizer import Tokenizer
from hil.equivalence import Verdict
from hil.stimuli import Level
from hil.subject import Subject, subject_of
from hil.verify import verify
from tests.firmware_cases import built
from tests.subjects import FIRMWARE

KEYWORDS = (
    "GOSUB GOTO IF THEN ELSEIF ELSE ENDIF FOR TO STEP NEXT RETURN READ DATA CON VAR PIN LOW HIGH "
    "INPUT PAUSE PULSOUT PULSIN RCTIME SEROUT SERIN LOOKUP AND OR MAX HEX1 HEX2 HEX3 HEX4 DEC STR "
    "WAIT CR Word Byte Nib Bit LOWBIT"
).split()

NAMES = {
    "echo": "pings", "lightLeft": "glowA", "lightRight": "glowB", "state": "which",
    "antennas": "feelers", "obstacle": "wall", "target": "lamp", "decisions": "looks",
    "nearest": "closest", "command": "answer", "request": "heard", "facing": "side",
    "commandLatch": "wires", "commandDirs": "drivers", "commandLines": "wires",
    "Decide": "Think", "Sense": "Look", "Genes": "Evolved", "Answers": "Replies", "Move": "Step1",
    "Banner": "Name", "BannerEnd": "NameEnd", "Report": "Tell2", "Listen": "Hear", "Hunt": "Go1",
    "Flee": "Run1", "Start": "Begin", "Bench": "Hosted", "address": "place", "frames": "rounds",
    "pose": "stance", "Pulses": "Frame", "tries": "attempts", "lastMove": "before",
}  # fmt: skip


def outside(line: str, change: Callable[[str], str]) -> str:
    """A line changed outside of its texts and its comment."""
    parts = re.split(r'("[^"]*")', line)
    for at in range(0, len(parts), 2):
        code, mark, comment = parts[at].partition("'")
        parts[at] = change(code) + mark + comment
        if mark:
            break
    return "".join(parts)


def reindented(text: str) -> str:
    return re.sub(r"^((?:  )+)(?=\S)", lambda found: "\t" * (len(found[1]) // 2), text, flags=re.M)


def flat(text: str) -> str:
    return re.sub(r"^[ \t]+", "", text, flags=re.M)


def recommented(text: str) -> str:
    """No comment but the directives, and the digest where it has to be."""
    lines = []
    for line in text.split("\n"):
        code = line if "{$" in line else outside(line, lambda code: code).partition(" '")[0]
        bare = line.startswith("'") and "{$" not in line
        lines.append(f"' state = obstacle, Source:  {line[9:17]!r} Decide:" if bare else code)
    return "\n".join(lines)


def lowered(text: str) -> str:
    words = re.compile(rf"\b({'|'.join(KEYWORDS)})\b")
    change = lambda code: words.sub(lambda found: found[1].lower(), code)  # noqa: E731
    return "\n".join(outside(line, change) for line in text.split("\n"))


def spaced(text: str) -> str:
    return re.sub(r"(?<![,])\n", "\n\n  \n", text)


def joined(text: str) -> str:
    """A label and the statement behind it on one line."""
    return re.sub(r"^(\w+:)[ \t]*(?:'.*)?\n((?:[ \t]*'.*\n)*)[ \t]+", r"\2\1 ", text, flags=re.M)


def renamed(text: str) -> str:
    words = re.compile(rf"\b({'|'.join(NAMES)})\b")
    change = lambda code: words.sub(lambda found: NAMES[found[1]], code)  # noqa: E731
    return "\n".join(outside(line, change) for line in text.split("\n"))


def all_of_it(text: str) -> str:
    return spaced(lowered(renamed(reindented(recommented(text)))))


SPELLINGS = (reindented, flat, recommented, lowered, spaced, joined, renamed, all_of_it)


def spelled(
    one: Subject, spelling: Callable[[str], str], tokenizer: Tokenizer, *fault: str
) -> Subject:
    """A robot whose programs are spelled otherwise, with a fault in its main one or without."""
    sources, images = {}, {}
    texts = dict(one.sources)
    if fault:
        assert fault[0] in texts["main"]
        texts["main"] = texts["main"].replace(fault[0], fault[1], 1)
    for chip, text in texts.items():
        sources[chip] = spelling(text)
        assert sources[chip] != text
        images[chip] = tokenizer.compile(sources[chip], one.files[chip]).image
    return replace(one, sources=sources, images=images)


def verdicts(one: Subject, tokenizer: Tokenizer) -> dict[str, str]:
    report = verify(one, tokenizer.compile, Level.SMOKE)
    return {name: str(trial.verdict) for name, trial in report.trials.items()}


@pytest.mark.parametrize("spelling", SPELLINGS)
@pytest.mark.parametrize("case", ["predator", "prey-free-running"])
def test_every_spelling_passes(
    case: str, spelling: Callable[[str], str], tokenizer: Tokenizer
) -> None:
    one = spelled(subject_of(built(case), case), spelling, tokenizer)
    found = verdicts(one, tokenizer)
    assert set(found.values()) == {str(Verdict.PASS)}, found


@pytest.mark.parametrize("spelling", [recommented, renamed, all_of_it])
@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("IF nearest < EchoSideFar THEN obstacle = FarLeft", "obstacle = FarLeft"),
        ("state = obstacle * 8 + target", "state = obstacle * 8 + obstacle"),
    ],
)
def test_a_fault_is_seen_in_every_spelling(
    old: str, new: str, spelling: Callable[[str], str], tokenizer: Tokenizer
) -> None:
    plain = subject_of(built("predator"), "predator")
    wrong = verdicts(spelled(plain, lambda text: f"{text}\n", tokenizer, old, new), tokenizer)
    assert wrong["registers"] == wrong["conduct"] == "FAIL"
    assert verdicts(spelled(plain, spelling, tokenizer, old, new), tokenizer) == wrong


def test_templates_of_ones_own_in_another_spelling(tmp_path: Path) -> None:
    """As a user writes them: the names that templates are given stay, all else is another."""
    mine, build = tmp_path / "mine", tmp_path / "build"
    shutil.copytree(shipped_templates(), mine)
    own = re.compile(r"\b(obstacle|target|facing|nearest|polls|tries)\b")

    def change(line: str) -> str:
        return outside(line, lambda code: own.sub(r"my\1", code))

    for file in mine.glob("*.j2"):
        text = file.read_text("utf-8").replace("Source:  {{ source_", "src={{ source_")
        text = text.replace("  state = obstacle", "  STATE  =  obstacle")
        lines = [
            line if "{%" in line or "{{" in line else change(line) for line in text.split("\n")
        ]
        file.write_text(reindented("\n".join(lines)), "utf-8")
    genome = str(FIRMWARE / "reference.genome")
    done = CliRunner().invoke(cgagen, ["build", genome, "-o", str(build), "--templates", str(mine)])
    assert done.exit_code == 0, done.output
    assert "src=" in (build / "main.bsp").read_text()
    done = CliRunner().invoke(cgagen, ["--json", "verify", genome, "--build", str(build)])
    data = json.loads(done.stdout)
    assert (done.exit_code, data["verdict"]) == (0, "PASS"), data["trials"]
