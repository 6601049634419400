"""The plugin in the runs of others: harmless, and usable from a project of their own."""

from pathlib import Path

import pytest

from cgagen.pytest_plugin import ours
from tests.plugin_runs import FIRMWARE, inside, run

USER_TEST = """
def test_first_gene(hil_subject, hil_oracle, hil_target):
    from hil.stimuli import neutral
    stimulus = neutral(hil_subject.robot)
    assert hil_target.decide(stimulus).command == hil_oracle.decide(stimulus).command
"""


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
        "@pytest.fixture\n"
        "def hil_trace():\n"
        "    return 'own'\n"
        "def test_two(hil_trace, request):\n"
        "    assert hil_trace == 'own' and request.node.name == 'test_two'\n"
        "@pytest.fixture\n"
        "def hil_board():\n"
        "    return 'own'\n"
        "def test_three(hil_board, request):\n"
        "    assert not request.node.user_properties\n"
        "@pytest.mark.hil_req('THEIRS')\n"
        "def test_four():\n"
        "    pass\n"
        "def test_wrong(hil_target):\n"
        "    raise RuntimeError('their own')\n"
        "def test_last():\n"
        "    pass\n"
    )
    alone, shared = run(tmp_path), run(tmp_path, "-n", "1")
    for ended in (alone, shared):
        assert ended.returncode == 1, ended.stdout + ended.stderr
        assert "1 failed, 5 passed" in ended.stdout, ended.stdout
        assert "RuntimeError: their own" in ended.stdout
        assert "firmware" not in ended.stdout
        assert "hides ours" not in ended.stdout + ended.stderr
    (tmp_path / "test_ours.py").write_text("def test_ours(hil_subject):\n    pass\n")
    ended = run(tmp_path, "test_ours.py")
    assert ended.returncode != 0
    assert f"a folder {room}/ of your own hides ours" in ended.stdout + ended.stderr
    assert "INTERNALERROR" not in ended.stdout + ended.stderr


def test_a_user_tries_a_build_from_a_project_of_their_own(tmp_path: Path) -> None:
    (tmp_path / "test_robot.py").write_text(USER_TEST)
    ended = run(tmp_path, f"--hil-build={FIRMWARE / 'prey'}")
    assert ended.returncode == 0, ended.stdout
    assert "1 passed" in ended.stdout
    ended = inside(
        tmp_path, CGAGEN_HIL_BUILD=str(FIRMWARE / "prey"), CGAGEN_HIL_TARGET="serial:/no"
    )
    assert ended.returncode == 1
    assert "/no: cannot be opened" in ended.stdout
    assert "Error" not in ended.stdout.partition("= ERRORS =")[2].partition("= short")[0]
    ended = inside(tmp_path, CGAGEN_HIL_LEVEL="deep")
    assert "the level is one of smoke, boundary" in ended.stdout
    ended = inside(tmp_path, f"--hil-build={FIRMWARE / 'prey'}", CGAGEN_HIL_LEVEL="deep")
    assert "ERROR: hil: level is deep; the level is one of smoke, boundary" in ended.stderr


def test_without_firmware_there_is_one_sentence_a_test(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As where the package is installed: there are no reference robots."""
    (tmp_path / "test_robot.py").write_text(USER_TEST)
    monkeypatch.setattr(ours, "REFERENCE", Path("none"))
    ended = inside(tmp_path)
    assert "1 error" in ended.stdout, ended.stdout
    assert "\nno firmware was named; give --hil-genome FILE, " in ended.stdout
    assert "/ours.py" not in ended.stdout


def test_command_line_before_ini_file_before_environment(tmp_path: Path) -> None:
    (tmp_path / "pytest.ini").write_text(
        "[pytest]\nhil_level = boundary\nhil_seed = 5\nhil_genome = own/best.genome\n"
        "hil_target = simulator emulator\n"
    )
    (tmp_path / "test_it.py").write_text(
        "from pathlib import Path\n"
        "def test_it(hil_config, pytestconfig):\n"
        "    one = hil_config\n"
        "    assert (one.level, one.seed, one.reruns) == ('exhaustive', 5, 3)\n"
        "    assert one.genome == str(Path(pytestconfig.rootpath) / 'own' / 'best.genome')\n"
        "    assert one.targets == ('simulator', 'emulator')\n"
        "    assert one.require and one.folder == Path('hil-artifacts')\n"
    )
    words = ("--hil-level", "exhaustive", "--hil-require", "--hil-vcd=fail")
    given = {"CGAGEN_HIL_SEED": "9", "CGAGEN_HIL_RERUNS": "3", "CGAGEN_HIL_LEVEL": "smoke"}
    ended = inside(tmp_path, *words, **given)
    assert ended.returncode == 0, ended.stdout
    ended = inside(tmp_path, CGAGEN_HIL_RERUNS="often")
    assert "reruns is often; it is a number from 0" in ended.stdout
    for word in ("\u00b2", "9" * 5_000):
        ended = inside(tmp_path, f"--hil-seed={word}")
        assert (ended.returncode, "; it is a number from 0" in ended.stderr) == (4, True), word
    ended = inside(tmp_path, "--hil-seed=-1")
    assert (ended.returncode, "seed is -1; it is a number" in ended.stderr) == (4, True)


def test_a_long_test_runs_when_it_is_asked_for(tmp_path: Path) -> None:
    (tmp_path / "test_it.py").write_text(
        "import pytest\ndef test_short(): pass\n@pytest.mark.hil_slow\ndef test_long(): pass\n"
        "@pytest.mark.hil_slow\n@pytest.mark.parametrize('n', (1, 2))\ndef test_both(n): pass\n"
    )
    for words, outcome in (
        ((), "1 passed, 3 deselected"),
        (("-m", "hil_slow"), "3 passed, 1 deselected"),
        (("test_it.py::test_long",), "1 passed in"),
        (("test_it.py::test_both",), "2 passed in"),
        (("test_it.py::test_both[2]",), "1 passed in"),
        (("-m", "hil_slow or not hil_slow"), "4 passed"),
    ):
        assert outcome in inside(tmp_path, *words).stdout, words
