"""The plugin in the runs of others: harmless, and usable from a project of their own."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

FIRMWARE = Path(__file__).parent.parent / "firmware"

USER_TEST = """
def test_first_gene(hil_subject, hil_oracle, hil_target):
    from hil.stimuli import neutral
    stimulus = neutral(hil_subject.robot)
    assert hil_target.decide(stimulus).command == hil_oracle.decide(stimulus).command
"""


def run(folder: Path, *words: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run pytest in a folder, as its owner would."""
    kept = {key: value for key, value in os.environ.items() if not key.startswith("CGAGEN_HIL")}
    return subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *words],
        cwd=folder,
        env={**kept, **environment},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


def test_it_is_loaded_and_imports_nothing_of_ours(tmp_path: Path) -> None:
    (tmp_path / "test_it.py").write_text(
        "import sys\n"
        "def test_it(request):\n"
        "    assert request.config.pluginmanager.hasplugin('cgagen-hil')\n"
        "    rooms = {'numpy', 'numba', 'hil', 'sim', 'serial', 'cgagen.robot'}\n"
        "    assert not rooms & set(sys.modules)\n"
    )
    ended = run(tmp_path)
    assert ended.returncode == 0, ended.stdout
    assert "1 passed" in ended.stdout
    assert "trial" not in ended.stdout


@pytest.mark.parametrize("room", ["hil", "sim"])
def test_a_project_with_a_folder_of_our_name_runs(tmp_path: Path, room: str) -> None:
    (tmp_path / room).mkdir()
    (tmp_path / room / "__init__.py").write_text("OWN = True\n")
    (tmp_path / "test_own.py").write_text(
        f"import {room}\n"
        "import pytest\n"
        "@pytest.fixture\n"
        "def hil_target():\n"
        "    return 'own'\n"
        "def test_own(hil_target):\n"
        f"    assert {room}.OWN and hil_target == 'own'\n"
    )
    ended = run(tmp_path)
    assert ended.returncode == 0, ended.stdout
    assert "1 passed" in ended.stdout
    (tmp_path / "test_ours.py").write_text("def test_ours(hil_subject):\n    pass\n")
    ended = run(tmp_path, "test_ours.py")
    assert ended.returncode != 0
    assert f"a folder {room}/ of your own hides ours" in ended.stdout + ended.stderr
    assert "INTERNALERROR" not in ended.stdout + ended.stderr


def test_a_user_tries_a_build_from_a_project_of_their_own(tmp_path: Path) -> None:
    (tmp_path / "test_robot.py").write_text(USER_TEST)
    ended = run(tmp_path, "--hil-build", str(FIRMWARE / "prey"))
    assert ended.returncode == 0, ended.stdout
    assert "1 passed" in ended.stdout
    ended = run(tmp_path, CGAGEN_HIL_BUILD=str(FIRMWARE / "prey"), CGAGEN_HIL_TARGET="serial:/no")
    assert ended.returncode == 1
    assert "/no: cannot be opened" in ended.stdout
    ended = run(tmp_path, "--hil-build", str(FIRMWARE / "prey"), CGAGEN_HIL_LEVEL="deep")
    assert "the level is one of smoke, boundary" in ended.stdout + ended.stderr


def test_what_a_target_cannot_do_is_skipped_or_refused(tmp_path: Path) -> None:
    (tmp_path / "test_needs.py").write_text(
        "import pytest\n"
        "@pytest.mark.hil_needs('state')\n"
        "def test_state(hil_target): pass\n"
        "@pytest.mark.hil_needs('power')\n"
        "def test_power(hil_target): pass\n"
        "@pytest.mark.hil_hardware\n"
        "def test_wire(hil_target): pass\n"
    )
    words = ("--hil-build", str(FIRMWARE / "prey"), "--hil-target", "simulator")
    ended = run(tmp_path, *words, "--strict-markers", "-k", "state or power")
    assert "1 passed, 1 skipped" in ended.stdout, ended.stdout
    ended = run(tmp_path, *words, "--hil-require", "-k", "power")
    assert "simulator cannot show: power" in ended.stdout
    assert ended.returncode == 1
    ended = run(tmp_path, "-k", "wire")
    assert "2 skipped" in ended.stdout, ended.stdout
