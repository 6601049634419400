"""An output that is a folder, or ends in a slash, goes into that folder under a name of ours."""

from collections.abc import Callable
from pathlib import Path

import pytest

from cgagen.cli import main
from cgagen.pytest_plugin.options import OPTIONS
from tests.plugin_runs import inside
from tests.subjects import FIRMWARE

PREDATOR = str(FIRMWARE / "predator")
GENOME = str(FIRMWARE / "reference.genome")
BLINK = "' {$STAMP BS2}\nHIGH 3\nEND\n"
READING = ["--build", PREDATOR, "--reading", "0,0,0/--/0,0"]
MARK = ["--sensor", "front", "--distance", "24", "--table", "OUT"]
Run = Callable[..., tuple[int, str]]


@pytest.fixture
def run(tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Run:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "blink.bs2").write_text(BLINK)
    (tmp_path / "marks.csv").write_text("sensor,distance_in,count\nfront,24,4425\nfront,12,2212\n")

    def call(*words: str) -> tuple[int, str]:
        return main(list(words)), capfd.readouterr().err

    return call


CASES = [
    (["compile", "blink.bs2", "-o", "OUT"], ["blink.bin"]),
    (["compile", "blink.bs2", "--map", "OUT"], ["blink.map.csv"]),
    (["emulate", "blink.bs2", "--vcd", "OUT"], ["blink.vcd"]),
    (["emulate", "blink.bs2", "--trace", "OUT"], ["blink.csv"]),
    (["emulate", "blink.bs2", "--coverage", "OUT"], ["blink.info", "blink.info.txt"]),
    (["verify", *READING, "--report", "OUT"], ["hil-report.html", "hil-report.json"]),
    (
        ["trace", "record", GENOME, "--steps", "2", "-o", "OUT"],
        ["rig.dbc", "trace.log", "trace.log.json"],
    ),
    (
        ["calibrate", "marks.csv", "--robot", "servobot-predator", "-o", "OUT"],
        ["servobot-predator.toml"],
    ),
    (
        ["monitor", "--port", f"emu:{PREDATOR}", "--for", "100ms", "--input", "", "--log", "OUT"],
        ["monitor.log"],
    ),
    (
        ["robot", "sensors", "--port", f"emu:{PREDATOR}", "--reset", "--readings", "1", *MARK],
        ["marks.csv"],
    ),
]


@pytest.mark.parametrize(("words", "names"), CASES, ids=[" ".join(case[0][:2]) for case in CASES])
@pytest.mark.parametrize("folder", ["new/deep/", "there", "there/"])
def test_a_folder_gets_our_name(
    tmp_path: Path, run: Run, words: list[str], names: list[str], folder: str
) -> None:
    (tmp_path / "there").mkdir()
    code, err = run(*[folder if word == "OUT" else word for word in words])
    assert code in (0, 11), err  # a single reading proves nothing
    assert sorted(one.name for one in (tmp_path / folder).iterdir()) == names


def test_a_folder_for_nothing_goes_again(tmp_path: Path, run: Run) -> None:
    (tmp_path / "bad.bs2").write_text(BLINK.replace("HIGH", "HIHG"))
    assert run("compile", "bad.bs2", "-o", "new/deep/")[0] == 6
    assert not (tmp_path / "new").exists()
    (tmp_path / "there").mkdir()
    assert run("compile", "bad.bs2", "-o", "there/")[0] == 6
    assert (tmp_path / "there").is_dir()


def test_without_a_slash_a_new_name_is_a_file(tmp_path: Path, run: Run) -> None:
    assert run("compile", "blink.bs2", "-o", "image")[0] == 0
    assert (tmp_path / "image").is_file()
    code, err = run("compile", "blink.bs2", "-o", "image/")
    assert (code, "image: the folder cannot be made" in err) == (3, True)


def test_the_plugin_makes_a_folder_that_ends_in_a_slash(tmp_path: Path) -> None:
    assert {"report", "coverage"} <= {one.name for one in OPTIONS}
    (tmp_path / "test_it.py").write_text(
        "def test_it(hil_target, hil_stimuli, hil_check):\n"
        "    hil_check(hil_target, hil_stimuli[:1])\n"
    )
    words = (f"--hil-build={FIRMWARE / 'prey'}", "--hil-report=r/", "--hil-coverage=c/")
    ended = inside(tmp_path, *words)
    assert ended.returncode == 0, ended.stdout
    names = sorted(one.name for folder in "rc" for one in (tmp_path / folder).iterdir())
    assert names == ["hil-coverage.info", "hil-coverage.txt", "hil-report.html", "hil-report.json"]
