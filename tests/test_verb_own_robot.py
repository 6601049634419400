"""A robot of one's own, under its own name, in a folder with blanks: as its owner types it."""

import json
import shlex
from collections.abc import Callable
from pathlib import Path

import pytest

from cgagen.cli import main
from cgagen.pytest_plugin.options import HilConfig
from cgagen.pytest_plugin.ours import subject_for
from cgagen.robot import ROBOTS_FOLDER, load_robot

SMALL = ["--generations", "3", "--population", "8", "--fixed-starts", "4", "--starts", "2"]
Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def lab(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a copy of the predator that has another name and other pins."""
    folder = tmp_path / "my lab's"
    folder.mkdir()
    text = (ROBOTS_FOLDER / "servobot-predator.toml").read_text()
    text = text.replace('"servobot-predator"', '"Lab-hexapod"', 1)
    text = text.replace("pin = 10 ", "pin = 12 ").replace("pin = 11 ", "pin = 13 ")
    (folder / "my robot.toml").write_text(text)
    monkeypatch.chdir(folder)
    return folder


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    def call(*words: str) -> tuple[int, str, str]:
        code = main(list(words))
        out = capsys.readouterr()
        return code, out.out, out.err

    return call


@pytest.fixture
def genome(lab: Path, run: Run) -> str:
    code, _, err = run(
        "evolve", "--robot", "my robot.toml", "--run", "runs/first try", *SMALL, "--no-masking"
    )
    assert code == 0, err
    return "runs/first try/best.genome"


def next_lines(out: str) -> list[list[str]]:
    """Return the commands of a verb's `next:` lines, as a shell takes them apart."""
    lines = [line for line in out.splitlines() if line.startswith("next:")]
    commands = [shlex.split(line.removeprefix("next:"), comments=True) for line in lines]
    assert all(words[0] == "cgagen" for words in commands)
    return [words[1:] for words in commands]


def test_every_next_line_works_as_it_stands(lab: Path, run: Run) -> None:
    waiting = [["evolve", "--robot", "my robot.toml", "--run", "-a run", *SMALL]]
    done = []
    while waiting:
        words = waiting.pop(0)
        done.append(words[0])
        # Only the port is added: nothing is plugged in here.
        code, out, err = run(*words, *(["--port", "emu"] if words[0] == "flash" else []))
        assert (code, "Error" in err) == (0, False), (words, err)
        waiting += next_lines(out)
    assert done == ["evolve", "build", "verify", "flash"]
    record = json.loads((lab / "build" / "Lab-hexapod" / "build.json").read_text())
    assert record["robot"]["digest"] == load_robot("my robot.toml").digest


def test_quiet_leaves_out_what_is_next(genome: str, run: Run) -> None:
    assert next_lines(run("build", genome, "-o", "b1")[1])
    code, out, err = run("-q", "build", genome, "-o", "b2")
    assert (code, next_lines(out), err) == (0, [], "")
    assert "next:" not in run("-q", "resume", "runs/first try")[1]


def test_every_verb_of_a_genome_takes_the_robot_from_its_run(genome: str, run: Run) -> None:
    digest = load_robot("my robot.toml").digest
    assert run("info", genome)[0] == 0
    assert json.loads(run("--json", "simulate", genome, "--steps", "2")[1])["robot"] == (
        "Lab-hexapod"
    )
    code, out, err = run("--json", "verify", genome, "--level", "smoke")
    assert (code, json.loads(out)["robot"]["name"]) == (0, "Lab-hexapod"), err
    code, _, err = run("trace", "record", genome, "-o", "hunt.log", "--steps", "3")
    assert code == 0, err
    assert json.loads(Path("hunt.log.json").read_text())["robot"]["digest"] == digest
    assert run("verify", genome, "--trace", "hunt.log", "--level", "smoke")[0] == 0
    for source in (["--level", "smoke"], ["--sweep"], ["--from", "hunt.log"]):
        code, _, err = run("trace", "record", genome, "-o", "more.csv", "--force", *source)
        assert code == 0, err


def test_the_plugin_takes_the_robot_from_the_run(genome: str) -> None:
    wanted = HilConfig(("emulator",), genome, None, None, "smoke", 1, False)
    subject = subject_for(wanted, "named")
    assert subject.robot.digest == load_robot("my robot.toml").digest


def test_a_trace_carries_a_robot_that_does_not_ship(genome: str, run: Run) -> None:
    run("trace", "record", genome, "-o", "hunt.log", "--steps", "3")
    Path("my robot.toml").unlink()
    assert run("trace", "convert", "hunt.log", "hunt.csv")[0] == 0
    assert run("trace", "show", "hunt.csv")[0] == 0
    assert json.loads(run("--json", "info", "hunt.csv")[1])["robot"] == "Lab-hexapod"
    sidecar = Path("hunt.log.json")
    sidecar.write_text(sidecar.read_text().replace("pin = 12 ", "pin = 14 "))
    code, _, err = run("trace", "show", "hunt.log")
    assert (code, "its file is not what its digest says" in err) == (3, True)


def test_the_runs_world_counts_unless_another_is_named(genome: str, run: Run) -> None:
    """The share of captures is the one that `evolve` has printed, with the run's own options."""
    assert "note: the world is the run's: masking False" in run("info", genome)[2]
    assert "masking" not in run("info", genome, "--masking")[2]
    data = json.loads(run("--json", "info", genome)[1])
    assert data["starts"] == int(SMALL[SMALL.index("--fixed-starts") + 1])
    best = json.loads(run("--json", "resume", "runs/first try")[1])["best"]
    assert data["captured"] == best["captured"] * data["starts"]


def test_programs_do_not_follow_a_run_in_what_the_robot_file_says(genome: str, run: Run) -> None:
    said = "masking: as the robot's file has it, not the run"
    assert said in run("build", genome)[2]
    assert said in run("simulate", genome, "--emulated", "--steps", "1")[2]
