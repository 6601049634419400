"""Which robot a genome is for: what was named, the run or build around it, or what ships."""

import re
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from cgagen.build import make_build, write_build
from cgagen.cli import main
from cgagen.errors import CgagenError, FolderError, GenomeError, RobotError, RunError
from cgagen.files import digest
from cgagen.genome import Genome, to_text
from cgagen.robot import ROBOTS_FOLDER, Robot, load_robot
from cgagen.robot.reader import parse_robot
from cgagen.run import Inputs, RunRecord, RunSettings
from cgagen.run.folder import write_beginning
from cgagen.tokenizer import Tokenizer
from cgagen.whose import home_of
from cgagen.whose import match as robot_of

SHIPPED = load_robot("servobot-predator")
MINE = parse_robot(
    SHIPPED.text.replace('"servobot-predator"', '"Lab hexapod"', 1)
    .replace("pin = 10 ", "pin = 12 ")
    .replace("pin = 11 ", "pin = 13 "),
    "mine.toml",
)
PREY = load_robot("servobot-prey")
TABLE = Genome("001" * 64, MINE.name, MINE.interface)
"""It names the robot and not its digest, as one that was written by hand."""


def a_run(folder: Path, robot: Robot = MINE) -> Path:
    """Write the beginning of a run and a genome; returns the genome's file."""
    arena = (ROBOTS_FOLDER / "colony.toml").read_text()
    inputs = Inputs(robot.text, PREY.text, arena, robot.name, robot.interface, robot.digest)
    folder.mkdir(parents=True, exist_ok=True)
    write_beginning(folder, RunRecord(RunSettings(), inputs, (("cgagen", "0"), ("world", "0"))))
    path = folder / "best.genome"
    path.write_text(to_text(TABLE))
    return path


def a_build(folder: Path, tokenizer: Tokenizer) -> Path:
    write_build(folder, make_build(MINE, TABLE, tokenizer).files(), False)
    return folder / "best.genome"


def test_a_run_and_its_trials_say_the_robot(tmp_path: Path) -> None:
    for folder in (tmp_path / "run", tmp_path / "run" / "trial-2"):
        found = robot_of(TABLE, a_run(folder))
        assert (found.robot.digest, found.note) == (MINE.digest, None)
        assert found.home is not None
        assert found.home.prey is not None
        assert found.home.prey.digest == PREY.digest
        assert found.home.record is not None


def test_a_build_says_the_robot_and_takes_in_other_genomes(
    tmp_path: Path, tokenizer: Tokenizer
) -> None:
    path = a_build(tmp_path / "build", tokenizer)
    assert robot_of(TABLE, path).robot.digest == MINE.digest
    copied = path.with_name("other.genome")
    copied.write_text(to_text(replace(TABLE, bits="010" * 64)))
    assert robot_of(TABLE, copied).robot.digest == MINE.digest


def test_a_robot_that_kept_the_name_of_one_that_ships_is_its_own(tmp_path: Path) -> None:
    """A copy with other pins under the old name must not become the one that ships."""
    mine = parse_robot(SHIPPED.text.replace("pin = 10 ", "pin = 12 "), "mine.toml")
    genome = Genome("001" * 64, SHIPPED.name, SHIPPED.interface)
    assert robot_of(genome, a_run(tmp_path, mine)).robot.digest == mine.digest
    assert robot_of(genome, tmp_path / "elsewhere" / "best.genome").robot.digest == SHIPPED.digest


def test_a_link_lies_where_it_leads_to(tmp_path: Path) -> None:
    link = tmp_path / "mine.genome"
    link.symlink_to(a_run(tmp_path / "run"))
    assert robot_of(TABLE, link).robot.digest == MINE.digest


def test_bare_characters_are_for_the_robot_of_their_folder(tmp_path: Path) -> None:
    assert robot_of(Genome("001" * 64), a_run(tmp_path)).robot.digest == MINE.digest


def test_a_genome_of_another_robot_is_told(tmp_path: Path) -> None:
    path = a_run(tmp_path)
    other = robot_of(Genome("001" * 64, SHIPPED.name, SHIPPED.interface), path)
    assert (other.robot.digest, other.home) == (SHIPPED.digest, None)
    assert other.note is not None
    assert "is for servobot-predator; " in other.note
    assert "1-predator.toml is Lab hexapod" in other.note
    with pytest.raises(GenomeError, match=r"'nobody' does not ship.*is Lab hexapod; pass its file"):
        robot_of(replace(TABLE, robot="nobody"), path)


def test_a_name_in_a_genome_is_never_a_path(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "near.toml").write_text(MINE.text)
    monkeypatch.chdir(tmp_path)
    with pytest.raises(GenomeError, match="does not ship with cgagen, and no run or build"):
        robot_of(replace(TABLE, robot="near.toml"), tmp_path / "g.genome")


def test_what_is_named_counts_and_differs_aloud(tmp_path: Path) -> None:
    path = a_run(tmp_path)
    same, other = tmp_path / "same.toml", tmp_path / "other.toml"
    same.write_text(MINE.text)
    other.write_text(MINE.text.replace("pin = 12 ", "pin = 10 "))
    assert robot_of(TABLE, path, str(same)).note is None
    found = robot_of(TABLE, path, str(other))
    assert found.robot.digest == load_robot(str(other)).digest
    assert found.note is not None
    assert f"--robot {other} is not the robot in {path.parent / '1-predator.toml'}" in found.note


@pytest.mark.parametrize("name", ["1-predator.toml", "1-prey.toml", "1-arena.toml", "0-run.toml"])
def test_a_changed_run_is_refused_until_a_robot_is_named(tmp_path: Path, name: str) -> None:
    path = a_run(tmp_path)
    (tmp_path / name).write_bytes((tmp_path / name).read_bytes() + b"\n")
    with pytest.raises(RunError, match=rf"{name}: .*; or name the robot with --robot"):
        robot_of(TABLE, path)
    mine = tmp_path / "mine.toml"
    mine.write_text(MINE.text)
    assert robot_of(TABLE, path, str(mine)).robot.digest == MINE.digest


@pytest.mark.parametrize("spoil", ["changed", "missing", "binary", "record"])
def test_a_changed_build_is_refused_until_a_robot_is_named(
    tmp_path: Path, tokenizer: Tokenizer, spoil: str
) -> None:
    path = a_build(tmp_path / "build", tokenizer)
    robot, record = path.with_name("robot.toml"), path.with_name("build.json")
    match spoil:
        case "changed":
            robot.write_text(MINE.text + "\n")
        case "missing":
            robot.unlink()
        case "binary":
            robot.write_bytes(b"\xff")
        case _:
            record.write_text("{}")
    with pytest.raises(FolderError, match=r"or name the robot with --robot"):
        robot_of(TABLE, path)
    assert robot_of(TABLE, path, "servobot-predator").robot.digest == SHIPPED.digest


def test_a_preys_build_says_nothing_of_a_genome(tmp_path: Path, tokenizer: Tokenizer) -> None:
    write_build(tmp_path / "prey", make_build(PREY, None, tokenizer).files(), False)
    assert home_of(tmp_path / "prey" / "x.genome") is None
    genome = Genome("001" * 64, SHIPPED.name, SHIPPED.interface)
    assert robot_of(genome, tmp_path / "prey" / "x.genome").robot.digest == SHIPPED.digest


def test_folders_without_a_record_are_no_home(tmp_path: Path) -> None:
    path = a_run(tmp_path / "run")
    moved = tmp_path / "moved.genome"
    shutil.copy(path, moved)
    assert home_of(moved) is None
    with pytest.raises(CgagenError, match="--robot FILE"):
        robot_of(TABLE, moved)


def run_of(folder: Path, text: str) -> Path:
    """Write the beginning of a run with a robot's text as it stands, and a genome."""
    arena = (ROBOTS_FOLDER / "colony.toml").read_text()
    inputs = Inputs(text, PREY.text, arena, MINE.name, MINE.interface, digest(text))
    write_beginning(folder, RunRecord(RunSettings(), inputs, (("cgagen", "0"), ("world", "0"))))
    path = folder / "best.genome"
    path.write_text(to_text(TABLE))
    return path


def test_a_run_whose_robot_has_a_rest_behind_echoes_is_used_as_it_is(tmp_path: Path) -> None:
    path = run_of(tmp_path, re.sub(r"trigger_gap_ms = \d+", "rest_ms = 5", MINE.text))
    assert robot_of(TABLE, path).robot.echo == MINE.echo


def test_a_run_whose_robot_cannot_be_read_is_no_dead_end(tmp_path: Path, capsys) -> None:
    """It is refused with what to do, and run and genome are still described."""
    path = run_of(tmp_path, MINE.text.replace("trigger_gap_ms", "gap_of_old_ms"))
    with pytest.raises(RobotError) as refused:
        robot_of(TABLE, path)
    sentence = str(refused.value)
    assert sentence.startswith(f"{tmp_path / '1-predator.toml'}: [echo] ")
    assert sentence.endswith("; change a copy of that file, and name the copy with --robot")
    assert main(["info", str(path)]) == 0
    told = capsys.readouterr()
    assert f"a genome for {MINE.name}" in told.out
    assert sentence in told.err
    assert main(["info", str(tmp_path)]) == 0
    told = capsys.readouterr()
    assert "best genome: " in told.out
    assert sentence in told.err
    copy = tmp_path / "copy.toml"
    copy.write_text(MINE.text)
    assert robot_of(TABLE, path, str(copy)).robot.digest == MINE.digest
