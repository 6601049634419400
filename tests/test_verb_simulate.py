"""`cgagen simulate` and `cgagen info` as a user calls them."""

import json
from pathlib import Path

import pytest

from cgagen.cli import main
from tests.subjects import FIRMWARE

GENOME = str(FIRMWARE / "reference.genome")


def run(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str, str]:
    code = main(list(words))
    out = capsys.readouterr()
    return code, out.out, out.err


def test_the_papers_test_ends_in_a_capture(capsys: pytest.CaptureFixture[str]) -> None:
    """Ref: S1 IV, figures 7 and 8: a late generation catches the prey within 100 steps."""
    code, out, _ = run(capsys, "simulate", GENOME)
    assert code == 0
    lines = out.splitlines()
    assert lines[-1] == f"captured at step {len(lines) - 2}"


def test_json_and_text_tell_the_same(capsys: pytest.CaptureFixture[str]) -> None:
    _, text, _ = run(capsys, "simulate", GENOME, "--steps", "20")
    _, out, _ = run(capsys, "--json", "simulate", GENOME, "--steps", "20")
    data = json.loads(out)
    assert len(data["steps"]) == 20 == len(text.splitlines()) - 2
    for line, step in zip(text.splitlines()[1:], data["steps"], strict=False):
        words = line.replace("(", " ").replace(",", " ").split()
        reading = step["reading"]
        assert words[:4] == [str(number) for number in (step["step"], *list(reading.values())[:3])]
        assert step["movement"] in words
        assert step["state"] == 8 * OBSTACLES.index(step["obstacle"]) + TARGETS.index(
            step["target"]
        )


SITUATIONS = "near_right far_right near_left far_left near_front middle_front far_front".split()
OBSTACLES, TARGETS = ["no_object", *SITUATIONS], ["no_target", *SITUATIONS]


def test_a_step_is_the_gene_of_its_state(capsys: pytest.CaptureFixture[str]) -> None:
    _, shown, _ = run(capsys, "--json", "info", GENOME)
    commands = json.loads(shown)["commands"]
    _, out, _ = run(capsys, "--json", "simulate", GENOME, "--past-capture", "--steps", "150")
    steps = json.loads(out)["steps"]
    assert len(steps) == 150
    assert all(commands[step["state"]] == step["command"] for step in steps)
    held = [step for step in steps if step["captured"]]
    assert len({tuple(step["predator"]) for step in held}) == 1, "both stay after the capture"


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["--predator", "1,2"], 2, "X,Y,DEG"),
        (["--predator", "1,2,nan"], 2, "finite"),
        (["--predator", "5,100,0"], 3, "not inside the arena"),
        (["--predator", "100,100,0", "--prey", "100,100,90"], 3, "one point"),
        (["--prey-policy", "brave"], 3, "brave"),
        (["--robot", "servobot-prey"], 3, "predator is wanted"),
        (["--robot", "no-such.toml"], 3, "no such robot"),
        (["--opponent", "servobot-predator"], 3, "prey is wanted"),
    ],
)
def test_bad_words(
    capsys: pytest.CaptureFixture[str], words: list[str], code: int, said: str
) -> None:
    got, out, err = run(capsys, "simulate", GENOME, *words)
    assert (got, out) == (code, "")
    assert said in err
    assert "Traceback" not in err


def test_info_names_what_was_never_visited(capsys: pytest.CaptureFixture[str]) -> None:
    _, out, _ = run(capsys, "info", GENOME)
    _, shown, _ = run(capsys, "--json", "info", GENOME)
    data = json.loads(shown)
    visited = sum(count > 0 for count in data["visits"])
    assert data["visited"] == visited
    assert f"{visited} of 64 states are visited" in out
    assert f"{64 - visited} never are" in out
    assert out.count(" -") >= 64 - visited
    assert data["captured"] >= 90


def test_info_of_everything_else(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from cgagen.robot import ROBOTS_FOLDER

    monkeypatch.chdir(tmp_path)
    assert (
        "the prey servobot-prey"
        in run(capsys, "info", str(ROBOTS_FOLDER / "servobot-prey.toml"))[1]
    )
    assert "300 x 300" in run(capsys, "info", str(ROBOTS_FOLDER / "colony.toml"))[1]
    assert "EEPROM" in run(capsys, "info", str(FIRMWARE / "prey"))[1]
    words = ["--generations", "1", "--population", "4", "--run", "r"]
    assert run(capsys, "-q", "evolve", *words)[0] == 0
    assert "population 4" in run(capsys, "info", "r")[1]
    (tmp_path / "x.genome").write_text("01" * 95 + "0")
    code, _, err = run(capsys, "info", "x.genome")
    assert code == 3
    assert "191" in err
    assert run(capsys, "info", "nothing")[0] == 3
    (tmp_path / "empty").mkdir()
    assert run(capsys, "info", "empty")[0] == 3
