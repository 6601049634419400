"""The plugin in the runs of others: harmless, and usable from a project of their own."""

import io
import json
import os
import shutil
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path

import pytest

from cgagen.pytest_plugin import ours
from hil.simulated import commands_by_state
from hil.subject import read_subject

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


@dataclass
class Ended:
    """What `run` returns, as far as it is looked at."""

    returncode: int
    stdout: str
    stderr: str


def inside(folder: Path, *words: str, **environment: str) -> Ended:
    """Run pytest likewise in this process: what it imports is here already."""
    # A user's test_robot.py is not ours of that name.
    ours = {name: sys.modules.pop(name) for name in [*sys.modules] if name.startswith("test_")}
    path = list(sys.path)
    out, err = io.StringIO(), io.StringIO()
    plain = ("-q", "-p", "no:cacheprovider", "-p", "no:faulthandler", "--capture=sys")
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(out), redirect_stderr(err):
        patch.chdir(folder)
        for key in [key for key in os.environ if key.startswith("CGAGEN_HIL")]:
            patch.delenv(key)
        for key, value in environment.items():
            patch.setenv(key, value)
        code = int(pytest.main([*plain, "--rootdir", str(folder), *words]))
    sys.path[:] = path
    for name in [name for name in sys.modules if name.startswith("test_")]:
        del sys.modules[name]
    sys.modules.update(ours)
    return Ended(code, out.getvalue(), err.getvalue())


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


def test_a_wrong_decision_on_any_target_comes_with_its_line(tmp_path: Path) -> None:
    build = tmp_path / "build"
    shutil.copytree(FIRMWARE / "prey", build)
    image = bytearray((build / "main.bin").read_bytes())
    subject = read_subject(build)
    answers = image.index(bytes(commands_by_state(subject)))
    image[answers] ^= 1
    (build / "main.bin").write_bytes(image)
    (tmp_path / "test_robot.py").write_text(
        "def test_it(hil_target, hil_stimuli, hil_check):\n"
        "    hil_check(hil_target, hil_stimuli[:1])\n"
    )
    ended = inside(tmp_path, "--rootdir", str(tmp_path.parent), CGAGEN_HIL_BUILD="build")
    words = ended.stdout.splitlines()
    at = words.index("smallest reading: 0,0,0,0,0,0/--")
    assert words[at - 1].startswith("FAIL: the program answers state 0 with command 0, ")
    assert words[at + 1 : at + 3] == [
        "expected: state 0, command 1",
        "observed: state 0, command 0",
    ]
    assert words[at + 3].startswith("main.bsp:")
    assert "DATA" in words[at + 3]
    again = "pytest 'test_robot.py::test_it[emulator-named]' --hil-build build"
    assert words[at + 4] == f"again: {again}"


def test_what_a_target_cannot_do_is_skipped_or_refused(tmp_path: Path) -> None:
    (tmp_path / "test_needs.py").write_text(
        "import pytest\n"
        "@pytest.mark.hil_needs('state')\n"
        "def test_state(hil_target): pass\n"
        "@pytest.mark.hil_needs('power')\n"
        "def test_power(hil_target): pass\n"
        "@pytest.mark.hil_hardware\n"
        "def test_wire(hil_target): pass\n"
        "@pytest.mark.hil_needs('power')\n"
        "def test_alone(): pass\n"
        "def test_trace(hil_trace): pass\n"
    )
    words = (f"--hil-build={FIRMWARE / 'prey'}", "--hil-target", "simulator")
    ended = inside(tmp_path, *words, "--strict-markers", "-k", "state or power")
    assert "1 passed, 1 skipped" in ended.stdout, ended.stdout
    ended = inside(tmp_path, *words, "--hil-require", "-k", "power")
    assert "simulator cannot show: power" in ended.stdout
    assert ended.returncode == 1
    ended = inside(tmp_path, "-k", "wire")
    assert "2 skipped" in ended.stdout, ended.stdout
    ended = inside(tmp_path, *words, "-k", "wire or trace")
    assert "2 skipped" in ended.stdout, ended.stdout
    ended = inside(tmp_path, *words, "--hil-require", "-k", "wire or trace")
    assert "2 errors" in ended.stdout, ended.stdout
    assert "needs a target on a wire; name one" in ended.stdout
    assert "needs a trace; name one" in ended.stdout
    ended = inside(tmp_path, "-k", "alone")
    assert "ask for the fixture hil_target" in ended.stdout


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
    ended = inside(tmp_path, "--hil-seed=-1")
    assert (ended.returncode, "seed is -1; it is a number" in ended.stderr) == (4, True)


OWN_TESTS = """
import pytest

@pytest.mark.hil_req("MINE")
def test_readings(hil_check, hil_target, hil_stimuli):
    hil_check(hil_target, hil_stimuli[:3])

def test_wrong(hil_target):
    from hil.target import Stimulus
    assert hil_target.decide(Stimulus((0,) * 6)).command == 7

@pytest.mark.hil_vectors("VECTORS")
def test_vectors(hil_vectors, hil_check, hil_registers):
    hil_check(hil_registers, hil_vectors)

def test_trace(hil_trace):
    pass

def test_folder(hil_artifacts, hil_vcd, hil_subject):
    from hil.emulated import robot_bench
    bench = robot_bench(hil_subject.robot, hil_subject.images)
    hil_vcd(bench, "own bench")
    bench.run(1_000_000)
    (hil_artifacts / "note.txt").write_text("kept")
"""


def test_what_a_run_leaves_behind_and_the_same_bytes_again(tmp_path: Path) -> None:
    vectors = str(FIRMWARE.parent / "hil" / "traces" / "vectors-prey.csv")
    (tmp_path / "test_own.py").write_text(OWN_TESTS.replace("VECTORS", vectors))
    (tmp_path / "ids.toml").write_text('MINE = "decides"\nOTHER = "is not tried"\n')
    left = []
    for name in ("one", "two"):
        out = tmp_path / name
        out.mkdir()
        words = (f"--hil-record={out}/told", "--hil-vcd=fail", f"--hil-artifacts={out}/kept")
        words += (f"--hil-report={out}", f"--hil-coverage={out}/lines.info")
        words += ("--hil-requirements=ids.toml", f"--hil-build={FIRMWARE / 'prey'}")
        ended = inside(tmp_path, *words)
        assert "1 failed, 3 passed, 1 skipped" in ended.stdout, ended.stdout
        assert "coverage prey/main.bsp: " in ended.stdout
        files = sorted(path for path in out.rglob("*") if path.is_file())
        left.append({str(path.relative_to(out)): path.read_bytes() for path in files})
    assert left[0] == left[1]
    told = left[0]
    kept = {name for name in told if name.startswith("kept")}
    wrong = "kept/test_own.py-test_wrong-emulator-named"
    assert kept == {
        f"{wrong}/failure.txt",
        f"{wrong}/target-decisions.jsonl",
        f"{wrong}/target.vcd",
        "kept/test_own.py-test_folder-named/note.txt",
    }
    assert b"assert 1 == 7" in told[f"{wrong}/failure.txt"]
    assert b"again: pytest 'test_own.py::test_wrong" in told[f"{wrong}/failure.txt"]
    assert b"main_line" in told[f"{wrong}/target.vcd"]
    records = {name for name in told if name.startswith("told")}
    assert "told/test_own.py-test_readings-named-emulator-target.log.json" in records
    assert "told/test_own.py-test_vectors-named-vectors-prey.csv-registers.jsonl" in records
    report = json.loads(told["hil-report.json"])
    assert report["verdict"] == "FAIL"
    assert [(row["id"], row["verdict"]) for row in report["requirements"]] == [
        ("MINE", "PASS"),
        ("OTHER", "UNPROVEN"),
    ]
    assert str(tmp_path) not in told["hil-report.html"].decode()
    assert told["lines.info"].startswith(b"TN:\nSF:prey/main.bsp\n")
    replayed = inside(
        tmp_path,
        *(f"--hil-build={FIRMWARE / 'prey'}", "-k", "test_trace"),
        "--hil-trace=one/told/test_own.py-test_readings-named-emulator-target.log",
    )
    assert "1 passed" in replayed.stdout, replayed.stdout


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


def test_what_cannot_be_written_is_a_sentence(tmp_path: Path) -> None:
    (tmp_path / "test_it.py").write_text("def test_it(hil_oracle): pass\n")
    words = (f"--hil-build={FIRMWARE / 'prey'}", "--hil-report=no/r.html")
    ended = inside(tmp_path, *words)
    assert (ended.returncode, "there is no folder no" in ended.stderr) == (4, True)
    ended = inside(tmp_path, words[0], "--hil-kills=no.json")
    assert (ended.returncode, "no.json: is no kill matrix" in ended.stderr) == (4, True)
    (tmp_path / "taken").write_text("")
    ended = inside(tmp_path, words[0], "--hil-coverage=taken/lines.info")
    assert (ended.returncode, "not written: taken: " in ended.stdout) == (4, True), ended.stdout
    assert "INTERNALERROR" not in ended.stdout


SICK = """
import pytest
from cgagen.errors import RigError

class Sick:
    url, caps, stale, ills, resets = "sick", frozenset(), 0, ILLS, 0
    def reset(self): self.resets += 1
    def decide(self, stimulus):
        if self.ills:
            self.ills -= 1
            raise RigError("the cable is loose")
        return self.oracle.decide(stimulus)

@pytest.fixture
def hil_target(hil_oracle):
    sick = Sick()
    sick.oracle = hil_oracle
    return sick

def test_check(hil_target, hil_check, hil_stimuli):
    hil_check(hil_target, hil_stimuli[:3])

def test_decide(hil_target, hil_stimuli):
    assert hil_target.decide(hil_stimuli[0]).state == WANTED
"""


@pytest.mark.parametrize(
    ("ills", "wanted", "reruns", "outcome", "verdict"),
    [
        (2, 0, 2, "2 passed", "PASS"),
        (2, 0, 1, "2 failed", "BLOCKED"),
        (0, 1, 9, "1 failed", "FAIL"),
    ],
)
def test_a_sick_bench_is_asked_again_and_a_wrong_decision_is_not(
    tmp_path: Path, ills: int, wanted: int, reruns: int, outcome: str, verdict: str
) -> None:
    text = SICK.replace("ILLS", str(ills)).replace("WANTED", str(wanted))
    (tmp_path / "test_sick.py").write_text(text)
    build = f"--hil-build={FIRMWARE / 'prey'}"
    ended = inside(tmp_path, build, f"--hil-reruns={reruns}", "--hil-report=r.json")
    assert outcome in ended.stdout, ended.stdout
    assert json.loads((tmp_path / "r.json").read_text())["verdict"] == verdict


def test_workers_of_xdist_share_one_report(tmp_path: Path) -> None:
    (tmp_path / "test_own.py").write_text(
        "import pytest\n"
        "@pytest.mark.parametrize('part', range(4))\n"
        "def test_part(part, hil_check, hil_oracle, hil_stimuli):\n"
        "    hil_check(hil_oracle, hil_stimuli[part::4])\n"
    )
    reports = []
    for ran, more in ((inside, ()), (run, ("-n", "2"))):
        ended = ran(tmp_path, f"--hil-build={FIRMWARE / 'prey'}", "--hil-report=r.json", *more)
        assert "4 passed" in ended.stdout, ended.stdout
        reports.append(json.loads((tmp_path / "r.json").read_text()))
    alone, shared = (report["robots"] for report in reports)
    assert alone == shared
    assert len(alone[0]["trials"]) == 4
    assert sum(row["readings"][0] for row in alone[0]["states"]) > 500
