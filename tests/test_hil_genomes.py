"""`pytest hil/` judges a genome by its firmware, not by what the reference genome happens to do."""

import json
import random
from pathlib import Path

import pytest

from cgagen.genome import from_commands
from cgagen.robot import load_robot
from hil.stimuli import every_state
from tests.plugin_runs import FIRMWARE, inside

HIL = Path(__file__).parents[1] / "hil"
ASKING = [str(HIL / f"test_{name}.py") for name in ("decisions", "proof")]
"""Files whose tests are of what is on trial; those of rigs and traces add wires, not genes."""

REACHED = sorted(every_state(load_robot("servobot-predator")))


def without_command_4() -> list[int]:
    """A genome with all eight commands, and 4 among those states alone that never occur."""
    chance = random.Random(5)
    genes = [chance.choice((0, 1, 2, 3, 5, 6, 7)) for _ in range(64)]
    return [gene if state in REACHED else 4 for state, gene in enumerate(genes)]


GENOMES = {
    "one command is missing": without_command_4(),
    "random": [random.Random(9).randrange(8) for _ in range(64)],
    "all 000": [0] * 64,
    "all 111": [7] * 64,
}


@pytest.mark.parametrize("name", GENOMES)
def test_a_sound_genome_passes(name: str, tmp_path: Path) -> None:
    path = tmp_path / "my.genome"
    path.write_text(from_commands(GENOMES[name]).bits)
    ended = inside(tmp_path, *ASKING, f"--hil-genome={path}", "--hil-level=smoke")
    assert ended.returncode == 0, ended.stdout
    assert " passed" in ended.stdout
    assert "emulator: 119 decisions" in ended.stdout
    assert "FAIL" not in ended.stdout


def test_what_is_tried_of_the_reference_says_nothing_of_another_firmware(tmp_path: Path) -> None:
    """Its tests run; no requirement of what was named stands on them."""
    words = [
        str(HIL / "test_images.py"),
        f"{HIL / 'test_decisions.py'}::test_every_gene_is_in_the_table",
    ]
    report = tmp_path / "r.json"
    ended = inside(
        tmp_path, *words, f"--hil-build={FIRMWARE / 'predator'}", f"--hil-report={report}"
    )
    assert ended.returncode == 0, ended.stdout
    assert "9 tests are of the reference firmware alone" in ended.stdout, ended.stdout
    rows = {row["id"]: row for row in json.loads(report.read_text())["requirements"]}
    assert {name: row["verdict"] for name, row in rows.items()} == {"TABLE": "PASS"}
    ended = inside(tmp_path, *words, f"--hil-report={report}")
    rows = {row["id"]: row for row in json.loads(report.read_text())["requirements"]}
    assert (rows["TABLE"]["verdict"], rows["IMAGES"]["verdict"]) == ("PASS", "PASS")
