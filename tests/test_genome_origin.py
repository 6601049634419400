"""What a genome's file says of where it comes from, after its bits were edited by hand."""

import json
import shutil
from pathlib import Path

import pytest

from cgagen.cli import main
from cgagen.genome import Genome, Origin, Standing, load, origin_text, parse, to_text
from tests.subjects import FIRMWARE

REFERENCE = FIRMWARE / "reference.genome"
ORIGIN = Origin(seed=7, trial=1, generation=120, fitness=722.8, robot_digest="ab" * 32)
BITS = "01" * 96


def edited(folder: Path) -> Path:
    """The reference genome with one bit changed, as an editor would, and nothing else."""
    path = folder / "mine.genome"
    text = REFERENCE.read_text()
    assert "\n100 000" in text
    path.write_text(text.replace("\n100 000", "\n101 000", 1))
    return path


def test_what_was_evolved_carries_the_digest_of_its_bits() -> None:
    one = load(REFERENCE)
    assert (one.origin.digest, one.standing) == (one.digest, Standing.ATTESTED)
    assert origin_text(one) == "seed 7, trial 1, generation 120, fitness 722.8"
    assert to_text(one) == REFERENCE.read_text()


def test_an_edit_leaves_nothing_of_the_origin_but_what_it_was_made_from(tmp_path: Path) -> None:
    one, before = load(edited(tmp_path)), load(REFERENCE)
    assert one.standing is Standing.EDITED
    assert one.evolved == Origin(edited_from=before.digest)
    again = parse(to_text(one), "again")
    assert (again.standing, again.origin) == (Standing.EDITED, Origin(edited_from=before.digest))
    assert parse(to_text(again), "again") == again
    for word in ("fitness", "generation", "seed", "robot_digest"):
        assert word not in to_text(one)


@pytest.mark.parametrize(
    ("origin", "standing", "told"),
    [
        (Origin(), Standing.NONE, ""),
        (ORIGIN, Standing.UNATTESTED, "fitness 722.8; unattested: the file does not say"),
        (Origin(robot_digest="cd"), Standing.UNATTESTED, ""),
    ],
)
def test_older_files_load_and_are_told_apart(origin: Origin, standing: Standing, told: str) -> None:
    one = parse(to_text(Genome(BITS, origin=origin)), "old")
    assert (one.standing, one.origin) == (standing, origin)
    assert told in origin_text(one)


def test_info_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = edited(tmp_path)
    assert main(["info", str(path)]) == 0
    out = capsys.readouterr().out
    assert "edited since it was evolved as 8e241ca1" in out
    assert "722.8" not in out
    assert main(["--json", "info", str(path)]) == 0
    origin = json.loads(capsys.readouterr().out)["origin"]
    assert origin == {"standing": "edited since", "edited_from": load(REFERENCE).digest}
    assert main(["info", str(REFERENCE)]) == 0
    assert "generation 120, fitness 722.8" in capsys.readouterr().out


def test_a_build_does_not_copy_what_is_false(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """In the copied genome, in build.json, on the terminal, and in the report about it."""
    path, folder = edited(tmp_path), tmp_path / "build"
    assert main(["build", str(path), "-o", str(folder)]) == 0
    said = capsys.readouterr()
    assert f"note: {path}: edited since it was evolved as 8e241ca1" in said.err
    assert "(edited since it was evolved as 8e241ca1" in said.out
    copied = load(folder / "best.genome")
    assert copied.evolved == Origin(edited_from=load(REFERENCE).digest)
    row = json.loads((folder / "build.json").read_text())["genome"]
    assert (row["origin"], row["edited_from"]) == ("edited since", load(REFERENCE).digest)
    page = tmp_path / "page.html"
    main(["verify", "--build", str(folder), "--reading", "0,0,0/--/0,0", "--report", str(page)])
    assert "edited since it was evolved as 8e241ca1" in page.read_text()
    assert "722.8" not in page.read_text()


def test_info_names_the_files_of_a_build_that_were_changed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "build"
    shutil.copytree(FIRMWARE / "predator", folder)
    assert main(["info", str(folder)]) == 0
    assert "edited since" not in capsys.readouterr().out
    (folder / "main.bsp").write_text((folder / "main.bsp").read_text() + "' mine\n")
    (folder / "wiring.txt").unlink()
    assert main(["info", str(folder)]) == 0
    assert "edited since it was built: main.bsp, wiring.txt" in capsys.readouterr().out


def test_a_run_ties_what_it_says_to_the_bits(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    few = ["--generations", "2", "--population", "4", "--starts", "1", "--fixed-starts", "2"]
    run = tmp_path / "run"
    assert main(["evolve", *few, "--steps", "3", "--run", str(run)]) == 0
    best = run / "best.genome"
    assert load(best).standing is Standing.ATTESTED
    assert main(["info", str(run)]) == 0
    assert "edited since" not in capsys.readouterr().out
    text, first = best.read_text(), load(best).bits[:3]
    bits = {"0": "1", "1": "0"}[first[0]] + first[1:]
    best.write_text(text.replace(f"\n{first} ", f"\n{bits} ", 1))
    assert main(["info", str(run)]) == 0
    assert "best.genome (edited since it was evolved as " in capsys.readouterr().out
