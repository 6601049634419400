"""What the plugin writes takes the place of nothing that is not of its kind and ours."""

import os
from pathlib import Path

import pytest

from tests.output_cases import is_null_device, null_device
from tests.plugin_runs import FIRMWARE, inside

BUILD = f"--hil-build={FIRMWARE / 'prey'}"
MINE = '{"name": "mine"}\n'


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "test_it.py").write_text(
        "from pathlib import Path\n\n\n"
        "def test_it(hil_target, hil_stimuli, hil_check):\n"
        "    Path('has_run').touch()\n"
        "    hil_check(hil_target, hil_stimuli[:2])\n"
    )
    return tmp_path


@pytest.mark.parametrize(
    ("option", "name"),
    [
        ("--hil-report=package.json", "package.json"),
        ("--hil-report=page.html", "page.html"),
        ("--hil-coverage=lines.info", "lines.info"),
        ("--hil-coverage=lines.info", "lines.txt"),
        ("--hil-coverage=cov", "cov/hil-coverage.info"),
        ("--hil-report=.", "hil-report.json"),
    ],
)
def test_files_of_others_are_named_before_the_tests(folder: Path, option: str, name: str) -> None:
    (folder / "cov").mkdir()
    (folder / name).write_text(MINE)
    ended = inside(folder, BUILD, option)
    assert ended.returncode == 4
    assert f"{name}: is there already" in ended.stderr
    assert (folder / name).read_text() == MINE
    assert not (folder / "has_run").exists()
    ended = inside(folder, BUILD, "--hil-level=smoke", option, "--hil-force")
    assert ended.returncode == 0, ended.stdout
    written = (folder / name).read_bytes()
    assert written != MINE.encode()
    assert inside(folder, BUILD, "--hil-level=smoke", option).returncode == 0
    assert (folder / name).read_bytes()[:100] == written[:100]


def test_what_is_read_is_not_written_over(folder: Path) -> None:
    (folder / "k.json").write_text(MINE)
    ended = inside(folder, BUILD, "--hil-kills=k.json", "--hil-report=k.json", "--hil-force")
    assert ended.returncode == 4
    assert (folder / "k.json").read_text() == MINE


def test_records_leave_what_is_not_theirs(folder: Path) -> None:
    words = (BUILD, "--hil-level=smoke", "--hil-record=told")
    assert inside(folder, *words).returncode == 0
    names = sorted(os.listdir(folder / "told"))
    assert "rig.dbc" in names
    assert inside(folder, *words).returncode == 0
    for name in names:
        before = (folder / "told" / name).read_bytes()
        (folder / "told" / name).write_text(MINE)
        ended = inside(folder, *words)
        assert ended.returncode != 0
        assert "--hil-force" in ended.stdout
        assert (folder / "told" / name).read_text() == MINE
        (folder / "told" / name).write_bytes(before)
    (folder / "told" / "rig.dbc").write_text(MINE)
    assert inside(folder, *words, "--hil-force").returncode == 0
    assert (folder / "told" / "rig.dbc").read_text() != MINE


def test_a_device_stays_one(folder: Path) -> None:
    device = null_device(folder / "null")
    (folder / "page.html").symlink_to("null")
    words = ("--hil-report=null", "--hil-report=page.html", "--hil-coverage=null")
    ended = inside(folder, BUILD, "--hil-level=smoke", *words)
    assert ended.returncode == 0, ended.stdout + ended.stderr
    assert is_null_device(device)
    assert not (folder / "null.txt").exists()


def test_the_words_of_a_failure_leave_what_is_not_theirs(folder: Path) -> None:
    (folder / "test_it.py").write_text("def test_it(hil_target):\n    assert 1 == 7\n")
    words = (BUILD, "--hil-artifacts=kept")
    assert inside(folder, *words).returncode == 1
    [one] = (folder / "kept").iterdir()
    assert (one / "failure.txt").read_text().startswith("again: pytest ")
    assert "there already" not in inside(folder, *words).stdout
    (one / "failure.txt").write_text(MINE)
    assert "is there already, and is not the words of a failure" in inside(folder, *words).stdout
    assert (one / "failure.txt").read_text() == MINE
