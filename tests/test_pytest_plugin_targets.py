"""The plugin and its targets: wrong decisions, what a target cannot do, and sick benches."""

import json
import shutil
from pathlib import Path
from xml.etree import ElementTree

import pytest

from hil.simulated import commands_by_state
from hil.subject import read_subject
from tests.plugin_runs import FIRMWARE, inside


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
    words = ("--rootdir", str(tmp_path.parent), "--junitxml=j.xml")
    ended = inside(tmp_path, *words, CGAGEN_HIL_BUILD="build")
    (case,) = ElementTree.parse(tmp_path / "j.xml").iter("testcase")
    told = {one.get("name"): one.get("value") for one in case.iter("property")}
    assert told == {
        "hil_level": "exhaustive",
        "hil_target": "emulator",
        "hil_verdict": "FAIL",
        "hil_decisions": "1",
        "hil_image": read_subject(build).images["main"].digest,
        "hil_genome": subject.robot.digest,
        "hil_robot": subject.robot.digest,
        "hil_seed": "1",
    }
    words = ended.stdout.splitlines()
    at = words.index("smallest reading: 0,0,0,0,0,0/--")
    assert words[at - 1].startswith("FAIL: the program answers state 0 with command 0, ")
    assert words[at + 1 : at + 3] == [
        "expected: state 0, command 1 WAIT",
        "observed: state 0, command 0 FORWARD",
    ]
    assert words[at + 3].startswith("decided in main.bsp:")
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
