"""`cgagen verify` as its users call it."""

import json
import re
import shutil
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result

import hil.verify
from cgagen.cli import cgagen, main
from cgagen.errors import CgagenError, MismatchError
from cgagen.serve import serve
from cgagen.tokenizer import Tokenizer
from cgagen.verbs.console import Console
from hil.emulated import robot_bench
from hil.subject import read_subject
from tests.firmware_cases import PREDATOR, srf04, with_model
from tests.subjects import FIRMWARE

GENOME = str(FIRMWARE / "reference.genome")
TRACES = Path(__file__).parent.parent / "hil" / "traces"
HUNT = str(TRACES / "hunt.log")
CALM = "0,0,0/--/0,0"


def call(*words: str) -> Result:
    return CliRunner().invoke(cgagen, list(words), obj=Console.of_process())


def verify(*words: str) -> tuple[int, dict[str, Any]]:
    result = call("--json", "verify", *words)
    return result.exit_code, json.loads(result.stdout)


@pytest.fixture
def build(tmp_path: Path) -> Path:
    folder = tmp_path / "build"
    shutil.copytree(FIRMWARE / "predator", folder)
    return folder


def test_the_reference_passes() -> None:
    result = call("verify", GENOME)
    assert result.exit_code == 0, result.output
    assert result.stdout.splitlines()[-1] == "PASS"
    assert "again: cgagen verify" in result.stdout


def test_a_prey_passes_without_a_genome() -> None:
    code, data = verify("--robot", "servobot-prey")
    assert (code, data["verdict"]) == (0, "PASS")
    assert {one["verdict"] for one in data["trials"].values()} == {"PASS"}
    assert data["trials"]["table"]["tried"].keys() == {str(state) for state in range(11)}


@pytest.mark.parametrize(("mode", "code"), [("ground", 11), ("open", 9)])
def test_srf04s_on_a_bs2_pass_when_their_mode_pins_are_grounded(
    mode: str, code: int, tmp_path: Path
) -> None:
    """An open one lets the echo begin before PULSIN looks, on all but the lowest pins."""
    robot, folder = tmp_path / "slow.toml", str(tmp_path / "build")
    text = srf04(PREDATOR, {4: (12, 4), 5: (13, 5), 6: (14, 6)})
    text = text.replace('kind = "srf04"', f'kind = "srf04"\nmode = "{mode}"')
    robot.write_text(with_model(text, "main", "BS2", 2000), "utf-8")
    assert call("build", GENOME, "--robot", str(robot), "-o", folder).exit_code == 0
    words = (GENOME, "--robot", str(robot), "--build", folder, "--reading", "368,900,0/--/0,0")
    found, data = verify(*words)
    seen = data["trials"]["emulator"]["verdict"]
    assert (found, seen) == (code, {9: "FAIL", 11: "PASS"}[code])  # all but a reading: not tried


@pytest.mark.parametrize(("built", "named"), [("predator", "prey"), ("prey", "predator")])
def test_a_build_of_the_other_role_is_a_mismatch(built: str, named: str) -> None:
    result = call("verify", "--build", str(FIRMWARE / built), "--robot", f"servobot-{named}")
    assert isinstance(result.exception, MismatchError)
    told = str(result.exception)
    assert f"is a build for servobot-{built} " in told
    assert f"named beside it is servobot-{named} " in told


def test_a_hand_edited_source_fails_with_a_reading_and_a_line(build: Path) -> None:
    source = build / "main.bsp"
    old, new = "IF nearest < EchoFrontNear THEN", "IF nearest <= EchoFrontNear THEN"
    source.write_text(source.read_text().replace(old, new))
    code, data = verify(GENOME, "--build", str(build))
    assert (code, data["verdict"]) == (9, "FAIL")
    verdicts = {name: trial["verdict"] for name, trial in data["trials"].items()}
    assert verdicts["sources"] == verdicts["source registers"] == "FAIL"
    assert verdicts["emulator"] == "PASS"
    small = data["smallest"]
    assert small["reading"] == "1966,0,0/--/0,0"
    assert small["lines"][0]["text"].strip().startswith(new)
    assert data["again"].endswith("--reading 1966,0,0/--/0,0")


def test_edited_sources_are_tried_by_their_pins_and_their_pulses(build: Path) -> None:
    """Sensing that was edited is not seen from registers, nor legs by any decision."""
    for name, old, new in (
        ("main.bsp", "PULSIN SonarLeft, 1, echo(Left)", "PULSIN SonarLeft, 1, echo(Right)"),
        ("locomotion.bs2", "SwingE          DATA    221", "SwingE          DATA    211"),
    ):
        text = (build / name).read_text("ascii")
        assert text.count(old) == 1, text
        (build / name).write_text(text.replace(old, new), "ascii")
    code, data = verify("--build", str(build))
    verdicts = {name: trial["verdict"] for name, trial in data["trials"].items()}
    failed = {name for name, verdict in verdicts.items() if verdict == "FAIL"}
    assert (code, failed) == (9, {"sources", "source emulator", "source movements"})
    assert verdicts["emulator"] == verdicts["movements"] == "PASS"
    assert data["smallest"]["reading"] == "0,0,1965/--/0,0"
    assert "ROTATE_RIGHT was asked for" in data["trials"]["source movements"]["reason"]


def test_a_changed_byte_in_an_image_fails_and_the_command_shows_it_again(build: Path) -> None:
    image = build / "main.bin"
    eeprom = bytearray(image.read_bytes())
    at = (FIRMWARE / "predator" / "main.bin").read_bytes().index(bytes([4, 0, 0, 5, 0, 3, 0, 6]))
    eeprom[at] ^= 1
    image.write_bytes(eeprom)
    code, data = verify(GENOME, "--build", str(build), "--reading", CALM)
    assert (code, data["smallest"]["reading"]) == (9, CALM)
    assert data["smallest"]["expected"]["command"] ^ data["smallest"]["observed"]["command"] == 1
    again = data["again"].split()[1:]
    assert verify(*again[1:])[0] == 9


def test_a_target_that_is_absent_is_blocked() -> None:
    result = call("verify", GENOME, "--reading", CALM, "--target", "serial:/dev/no-such-port")
    assert result.exit_code == 7, result.output
    assert "cannot be opened" in result.stdout
    assert result.stdout.splitlines()[-1] == "BLOCKED"


def test_it_is_a_proof_by_default(tmp_path: Path) -> None:
    page = tmp_path / "verify.html"
    result = call("verify", GENOME, "--report", str(page), "--json")
    assert result.exit_code == 0, result.output
    data = json.loads(result.stdout)
    cells = data["trials"]["cells"]
    assert sum(cells["agreed"].values()) == data["proof"]["cells"] == 55_296
    assert cells["note"].startswith("PASS: proven for every reading, by all 55,296 cells")
    assert data["trials"]["emulator"]["left_out"] == 0
    assert data["again"].endswith("--level exhaustive --seed 1")
    assert "proven for every reading" in page.read_text("utf-8")
    assert "a sample" not in page.read_text("utf-8")


def test_a_program_that_is_not_understood_is_unproven(build: Path, tokenizer: Tokenizer) -> None:
    source = build / "main.bsp"
    old, new = "  litLeft = 0\n", "  litLeft = 0 & echo(0)\n"
    assert old in source.read_text()
    source.write_text(source.read_text().replace(old, new))
    (build / "main.bin").write_bytes(tokenizer.compile(source.read_text(), "m").image.eeprom)
    result = call("verify", GENOME, "--build", str(build), "--level", "exhaustive")
    assert result.exit_code == 11, result.output
    assert result.stdout.splitlines()[-1] == "UNPROVEN"
    assert re.search(r"cells: line \d+: sonar front is used in arithmetic", result.stdout)


def test_a_trace_that_was_changed_fails_with_its_line(tmp_path: Path) -> None:
    table = (TRACES / "vectors.csv").read_text("utf-8").splitlines()
    at = next(n for n, line in enumerate(table) if ",0,4" in line)
    table[at] = table[at].replace(",0,4", ",0,5")
    trace = tmp_path / "changed.csv"
    trace.write_text("\n".join(table) + "\n", "utf-8")
    code, data = verify(GENOME, "--trace", str(TRACES / "hunt.log"), "--trace", str(trace))
    verdicts = {name: trial["verdict"] for name, trial in data["trials"].items()}
    assert (code, verdicts.pop("changed.csv on emulator")) == (9, "FAIL")
    assert set(verdicts.values()) == {"PASS"}
    assert verdicts["hunt.log on emulator"] == "PASS"
    assert f"line {at + 1}" in data["trials"]["changed.csv on emulator"]["reason"]
    assert f"--trace {trace}" in data["again"]


def test_a_trace_of_another_genome_is_refused_before_the_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    genome = tmp_path / "other.genome"
    text = Path(GENOME).read_text("utf-8")
    genome.write_text(re.sub(r"^100 000", "101 000", text, count=1, flags=re.MULTILINE), "utf-8")
    monkeypatch.setattr(hil.verify, "try_sources", None)  # what is tried first
    result = call("verify", str(genome), "--build", str(FIRMWARE / "predator"), "--trace", HUNT)
    assert "hunt.log: its decisions are those of genome" in str(result.exception)


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("--report", "r.pdf"), "ends in .html or .json"),
        (("--report", "no/such/r.html"), "there is no folder"),
        (("--kills", GENOME, "--report", "r.html"), "is no kill matrix"),
    ],
)
def test_wrong_files_are_refused_before_the_work(words: tuple[str, ...], sentence: str) -> None:
    result = call("verify", GENOME, *words)
    assert isinstance(result.exception, CgagenError)
    assert sentence in str(result.exception)


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ((), "give a genome"),
        ((GENOME, "--reading", "1,2"), "is not like 1843"),
        ((GENOME, "--target", "carrier-pigeon"), "no such target"),
        ((GENOME, "--reading", "1,2/--/0,0"), "is not of a servobot-predator"),
    ],
)
def test_wrong_words_are_refused(words: tuple[str, ...], sentence: str) -> None:
    result = call("verify", *words)
    assert result.exit_code == 2
    assert sentence in result.output


def test_both_controllers_on_wires() -> None:
    """One emulated robot behind two ports, and one reading, so that it is quick."""
    subject = read_subject(FIRMWARE / "prey")
    bench = robot_bench(subject.robot, subject.images)
    places = dict.fromkeys(("main", "locomotion"), "rfc2217:0")
    with serve(bench, places) as server:
        target, legs = (f"serial-reset:{one.url}" for one in server.endpoints)
        words = ("--build", str(FIRMWARE / "prey"), "--reading", "0,0,0,0,0,0/--")
        result = call("verify", *words, "--target", target, "--legs", legs)
    assert result.exit_code == 11, result.output
    assert re.search(r"\nlegs +PASS +8 +8 ", result.stdout)
    assert re.findall(r"\n(\w+) +NOT TRIED ", result.stdout) == [
        "cells",
        "movements",
        "timing",
        "conduct",
    ]
    assert f"--target {target} --legs {legs}" in result.stdout


def test_legs_are_on_a_serial_port() -> None:
    result = call("verify", "--build", str(FIRMWARE / "prey"), "--legs", "emulator")
    assert result.exit_code == 2
    assert "say serial:PORT or serial-reset:PORT" in result.stderr


def test_a_build_whose_robot_was_edited_is_not_proven(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """One PULSOUT count of a trim is within what the check of the pulses forgives."""
    build = tmp_path / "build"
    shutil.copytree(FIRMWARE / "predator", build)
    robot = build / "robot.toml"
    text = robot.read_text("utf-8")
    robot.write_text(text + "# mine\n", "utf-8")
    assert main(["verify", "--build", str(build), "--level", "smoke"]) == 11
    said = capsys.readouterr().out
    assert "robot file" in said
    assert "NOT TRIED" in said
    assert "edited since the programs were built" in said
