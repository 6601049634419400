"""What a folder, or a bare image, stands for where a verb wants one file."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from cgagen.cli import main
from cgagen.tokenizer import compile_source
from tests.subjects import FIRMWARE

BLINK = '\' {$STAMP BS2}\nHIGH 3\nDEBUG "on"\nEND\n'
Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(capfd: pytest.CaptureFixture[str]) -> Run:
    def call(*words: str) -> tuple[int, str, str]:
        code = main(list(words))
        out = capfd.readouterr()
        return code, out.out, out.err

    return call


def image_beside(folder: Path, name: str, text: str) -> Path:
    """Write a source and its image; returns the image."""
    (folder / name).write_text(text)
    image = (folder / name).with_suffix(".bin")
    image.write_bytes(compile_source(text, name).image.eeprom)
    return image


@pytest.mark.parametrize("verb", [["info"], ["emulate"], ["flash", "--dry-run"]])
def test_the_source_beside_an_image_says_its_model(
    tmp_path: Path, run: Run, verb: list[str]
) -> None:
    image = image_beside(tmp_path, "blink.BS2", BLINK)
    code, out, err = run(*verb, str(image))
    assert (code, bool(out)) == (0, True), err
    (tmp_path / "blink.BS2").write_text(BLINK.replace("HIGH", "LOW"))
    code, out, err = run(*verb, str(image))
    assert (code, out) == (2, "")
    assert "blink.BS2 makes another image than blink.bin" in err
    assert "add --model with one of BS2, BS2e" in err


def test_two_sources_of_one_image_are_not_chosen_among(tmp_path: Path, run: Run) -> None:
    image = image_beside(tmp_path, "blink.bs2", BLINK)
    other = BLINK.replace("BS2", "BS2e")
    assert compile_source(other, "x").image.eeprom == image.read_bytes()
    (tmp_path / "blink.bse").write_text(other)
    code, _, err = run("flash", "--dry-run", str(image))
    assert code == 2
    assert "blink.bs2 and blink.bse both make" in err
    told = json.loads(run("--json", "flash", "--dry-run", str(image), "--model", "BS2e")[1])
    assert told["blink"]["model"] == "BS2e"


def test_a_bare_image_is_sent_whole_whoever_says_its_model(tmp_path: Path, run: Run) -> None:
    image = image_beside(tmp_path, "blink.bs2", BLINK)
    plans = []
    for model in ([], ["--model", "BS2"]):
        code, out, err = run("--json", "flash", "--dry-run", str(image), *model)
        assert code == 0
        assert ("is for a BS2, as blink.bs2 beside it says" in err) == (model == [])
        plans.append(json.loads(out)["blink"]["packets"])
    assert plans[0] == plans[1]


def test_a_build_is_emulated_by_its_bench(run: Run) -> None:
    by_folder = run("emulate", str(FIRMWARE / "predator"), "--for", "300ms", "--input", "")
    by_file = run(
        "emulate", str(FIRMWARE / "predator" / "bench.toml"), "--for", "300ms", "--input", ""
    )
    assert by_folder == by_file
    assert "#1 M servobot-predator" in by_folder[1]


@pytest.mark.parametrize(
    ("verb", "code", "said"),
    [
        (["emulate", "RUN"], 3, "is a run, and has no programs; build them first: cgagen build"),
        (["emulate", "EMPTY"], 3, "is a folder without a bench.toml; name a build, a bench"),
        (["emulate", "EMPTY", "--port", "tcp:0"], 3, "is a folder without a bench.toml"),
        (["compile", "BUILD"], 3, "name one of its sources: BUILD/main.bsp, BUILD/locomotion.bs2"),
        (["compile", "EMPTY"], 3, "EMPTY: is a folder; name a PBASIC source"),
        (["verify", "BUILD"], 3, "is a build, not a genome; try it as it is with `cgagen verify"),
        (["build", "EMPTY"], 3, "is a folder, and no run; give the best.genome of a run"),
        (["simulate", "YOUNG"], 3, "has no best.genome yet; continue the run with `cgagen resume"),
        (["flash", "RUN"], 3, "is no build"),
        (["build", "BUILD/robot.toml"], 3, "BUILD/robot.toml: is a robot, not a genome; give the"),
        (["simulate", "BUILD/main.bin"], 3, "main.bin: is an image, not a genome"),
        (["verify", "BUILD/main.bsp"], 3, "main.bsp: is a PBASIC source, not a genome"),
        (["verify", "BUILD/build.json"], 3, "build.json: is a build's record, not a genome"),
    ],
)
def test_folders_that_are_no_such_thing(
    tmp_path: Path, run: Run, monkeypatch: pytest.MonkeyPatch, verb: list[str], code: int, said: str
) -> None:
    for name in ("EMPTY", "RUN", "YOUNG"):
        (tmp_path / name).mkdir()
    for name in ("RUN", "YOUNG"):
        (tmp_path / name / "0-run.toml").touch()
    (tmp_path / "RUN" / "best.genome").touch()
    shutil.copytree(FIRMWARE / "predator", tmp_path / "BUILD")
    monkeypatch.chdir(tmp_path)
    got, out, err = run(*verb)
    assert (got, out) == (code, "")
    assert said in err


def test_a_run_stands_for_its_best_genome(tmp_path: Path, run: Run) -> None:
    folder = str(tmp_path / "run")
    words = ["--generations", "2", "--population", "4", "--fixed-starts", "2", "--starts", "1"]
    assert run("evolve", "--run", folder, *words)[0] == 0
    for verb in (["simulate", "--steps", "2"], ["build", "-o", str(tmp_path / "build")]):
        by_folder = run(*verb, folder, "--json")
        by_file = run(*verb, f"{folder}/best.genome", "--json")
        assert by_folder == by_file
        assert by_folder[0] == 0
    assert json.loads(run("--json", "info", folder)[1])["kind"] == "run"
