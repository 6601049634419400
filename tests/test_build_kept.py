"""A build takes nothing of the user's away: not a folder, not an edit, not a link."""

import os
import stat
from pathlib import Path

import pytest

from cgagen import cli
from cgagen.build import FILES, write_build
from cgagen.build.folder import _exchanged
from cgagen.errors import FolderError

ROOT = Path(__file__).parent.parent
BUILT = {
    path.name: path.read_bytes()
    for path in (ROOT / "firmware" / "prey").iterdir()
    if path.name in FILES
}
MEANT = ("main.bsp", "locomotion.bs2", "wiring.txt", "bench.toml", "robot.toml", "main.bin")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    write_build(tmp_path / "out", BUILT)
    return tmp_path / "out"


def tree(folder: Path) -> dict[str, bytes | None]:
    return {
        str(path.relative_to(folder)): path.read_bytes() if path.is_file() else None
        for path in sorted(folder.rglob("*"))
    }


@pytest.mark.parametrize("name", MEANT)
def test_an_edit_is_named_and_kept(folder: Path, name: str) -> None:
    (folder / name).write_bytes(BUILT[name] + b"\n")
    before = tree(folder)
    with pytest.raises(FolderError, match=f"{name}: changed since cgagen has built this"):
        write_build(folder, BUILT)
    assert tree(folder) == before
    write_build(folder, BUILT, force=True)
    assert tree(folder) == BUILT


def test_all_edits_are_named(folder: Path) -> None:
    for name in MEANT:
        (folder / name).write_text("mine")
    with pytest.raises(FolderError) as caught:
        write_build(folder, BUILT)
    assert all(name in str(caught.value) for name in MEANT)


def test_what_says_the_same_already_is_no_edit(folder: Path) -> None:
    """As where a genome in the folder was edited, and the build is of that."""
    new = {**BUILT, "wiring.txt": b"new"}
    (folder / "wiring.txt").write_bytes(b"new")
    write_build(folder, new)
    assert tree(folder) == new


@pytest.mark.parametrize("name", [*MEANT, "build.json", "best.genome"])
@pytest.mark.parametrize("force", [False, True])
def test_a_folder_with_a_name_of_ours_stays(folder: Path, name: str, force: bool) -> None:
    (folder / name).unlink(missing_ok=True)
    (folder / name).mkdir()
    (folder / name / "thesis.txt").write_text("years of work")
    before = tree(folder)
    with pytest.raises(FolderError, match="is no file, and a build has one of that name"):
        write_build(folder, BUILT, force)
    assert tree(folder) == before


def test_a_device_or_pipe_with_a_name_of_ours_stays(folder: Path) -> None:
    (folder / "memory.txt").unlink()
    os.mkfifo(folder / "memory.txt")
    with pytest.raises(FolderError, match="is no file"):
        write_build(folder, BUILT, force=True)
    assert stat.S_ISFIFO((folder / "memory.txt").stat().st_mode)


def test_a_link_with_a_name_of_ours_stays_one(folder: Path, tmp_path: Path) -> None:
    (folder / "main.bsp").rename(tmp_path / "elsewhere.bsp")
    (folder / "main.bsp").symlink_to("../elsewhere.bsp")
    new = {**BUILT, "main.bsp": b"new"}
    write_build(folder, new)
    assert os.readlink(folder / "main.bsp") == "../elsewhere.bsp"
    assert (tmp_path / "elsewhere.bsp").read_bytes() == b"new"
    assert tree(folder) == new


def test_modes_stay(folder: Path) -> None:
    folder.chmod(0o700)
    write_build(folder, BUILT)
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700


def test_the_verb_refuses_before_its_work(
    tmp_path: Path,
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def work(*_: object) -> None:
        raise AssertionError("it has begun")

    (folder / "main.bsp").write_text("mine")
    with monkeypatch.context() as inside:
        inside.setattr("cgagen.build.make_build", work)
        assert cli.main(["build", "--robot", "servobot-prey", "-o", str(folder)]) == 3
    assert "main.bsp: changed since" in capsys.readouterr().err
    assert cli.main(["build", "--robot", "servobot-prey", "-o", str(folder), "--force"]) == 0
    assert (folder / "main.bsp").read_bytes() != b"mine"
    before = tree(folder)
    assert cli.main(["build", "--robot", "servobot-prey", "-o", str(folder)]) == 0
    assert tree(folder) == before


def test_two_folders_change_places_at_once(tmp_path: Path) -> None:
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "which").write_text(name)
    if not _exchanged(tmp_path / "a", tmp_path / "b"):
        pytest.skip("this system, or its disk, has no exchange of names")
    assert (tmp_path / "a" / "which").read_text() == "b"
    assert not _exchanged(tmp_path / "a", tmp_path / "none")
