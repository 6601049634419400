"""The verbs evolve and resume, on a toy world; the real one has its own tests."""

import json
from pathlib import Path

import pytest

from cgagen import cli, genome
from cgagen.verbs import evolve, progress
from tests.toy_run import ToyWorld

FEW = ["--generations", "25", "--population", "8"]


@pytest.fixture(autouse=True)
def toy(monkeypatch, tmp_path):
    monkeypatch.setattr("sim.model.World", lambda *parts, **options: ToyWorld())
    monkeypatch.setattr(evolve, "note_compiling", lambda note: None)
    monkeypatch.chdir(tmp_path)


def test_evolve_then_resume(capsys, tmp_path):
    assert cli.main(["evolve", *FEW, "--seed", "3"]) == 0
    said = capsys.readouterr()
    best = tmp_path / "runs/servobot-predator-seed3/best.genome"
    assert f"cgagen build {best.relative_to(tmp_path)}" in said.out
    rows = said.out.splitlines()
    assert [row.split()[0] for row in rows[1:5]] == ["1", "10", "20", "25"]
    assert said.err == ""
    one = genome.load(best)
    assert (one.origin.seed, one.origin.trial) == (3, 1)
    assert one.interface is not None
    assert "sonar" in one.interface
    assert cli.main(["resume", "runs/servobot-predator-seed3"]) == 0
    again = capsys.readouterr()
    assert "complete" in again.err
    assert again.out == said.out


def test_json(capsys):
    assert cli.main(["--json", "evolve", *FEW, "--trials", "2", "--workers", "1"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert [trial["trial"] for trial in data["trials"]] == [1, 2]
    assert data["trials"][0]["fitness"][-1]["generation"] == 25
    assert len(data["best"]["bits"]) == 192


def test_several_trials_are_a_table(capsys):
    assert cli.main(["evolve", *FEW, "--trials", "3", "--workers", "1", "--run", "r"]) == 0
    rows = capsys.readouterr().out.splitlines()
    assert [row.split()[0] for row in rows[1:4]] == ["1", "2", "3"]


def test_options_of_the_world_are_recorded(tmp_path):
    words = ["--go-on", "--no-masking", "--light", "ambient", "--walls", "stop"]
    assert cli.main(["evolve", *FEW, *words, "--steps", "50", "--run", "r"]) == 0
    text = (tmp_path / "r/0-run.toml").read_text()
    for line in (
        'after_capture = "go_on"',
        "masking = false",
        'light = "ambient"',
        'walls = "stop"',
        "steps = 50",
    ):
        assert line in text.splitlines()


@pytest.mark.parametrize(
    ("words", "code", "sentence"),
    [
        (["--population", "8", "--elite", "8"], 2, "elite is 8"),
        (["--mutation", "2"], 2, "--mutation"),
        (["--generations", "0"], 2, "--generations"),
        (["--light", "dim"], 2, "--light"),
        (["--robot", "none.toml"], 3, "none.toml"),
        (["--robot", "servobot-prey"], 3, "predator"),
        (["--prey-policy", "lazy"], 3, "lazy"),
    ],
)
def test_bad_input_is_a_sentence_and_leaves_no_folder(capsys, tmp_path, words, code, sentence):
    assert cli.main(["evolve", *words]) == code
    assert sentence in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_a_folder_in_the_way(capsys, tmp_path):
    (tmp_path / "r").mkdir()
    (tmp_path / "r/notes.txt").write_text("mine")
    assert cli.main(["evolve", *FEW, "--run", "r"]) == 3
    assert "notes.txt" in capsys.readouterr().err
    assert [path.name for path in (tmp_path / "r").iterdir()] == ["notes.txt"]
    assert cli.main(["resume", "r"]) == 3
    assert cli.main(["resume", "nowhere"]) == 3


def test_progress_without_a_terminal_is_a_line_now_and_then(capsys, monkeypatch):
    monkeypatch.setattr(progress, "LINE_EVERY_S", 0.0)
    assert cli.main(["evolve", *FEW, "--run", "a"]) == 0
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 25
    assert "generation 25 of 25" in lines[-1]
    for quiet in ("--no-progress", "--quiet"):
        assert cli.main([quiet, "evolve", *FEW, "--run", f"b{quiet}"]) == 0
        assert capsys.readouterr().err == ""


def test_progress_on_a_terminal(capsys, monkeypatch):
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    assert cli.main(["evolve", *FEW, "--run", "a"]) == 0
    assert "25/25" in capsys.readouterr().err


def test_another_world_step_is_not_mixed_in(capsys, monkeypatch):
    assert cli.main(["evolve", *FEW, "--run", "r"]) == 0
    monkeypatch.setattr("sim.jit.kernel_digest", lambda: "0" * 16)
    capsys.readouterr()
    (Path("r") / "best.genome").unlink()
    assert cli.main(["resume", "r"]) == 3
    assert "world step has changed" in capsys.readouterr().err


def test_the_first_call_on_a_machine_says_that_it_compiles(capsys, monkeypatch):
    from cgagen.verbs import world_options

    monkeypatch.setattr(evolve, "note_compiling", world_options.note_compiling)
    monkeypatch.setattr("sim.jit.is_compiled", lambda: False)
    assert cli.main(["evolve", *FEW, "--run", "r"]) == 0
    assert "once on this machine" in capsys.readouterr().err
