"""The plugin beside decisions: the other program of a build, and chips beside a wire."""

import json
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from xml.etree import ElementTree

import pytest

from cgagen.serve import serve
from hil.emulated import robot_bench
from hil.equivalence import Trial, Verdict
from hil.subject import read_subject
from tests.plugin_runs import FIRMWARE, inside
from tests.subjects import subject

ONE_LINE = """
def test_my_robot(hil_target, hil_stimuli, hil_check):
    hil_check(hil_target, hil_stimuli)
"""

FEW = """
import pytest
@pytest.fixture(scope="session")
def hil_stimuli(hil_subject):
    from hil.stimuli import every_state
    return list(every_state(hil_subject.robot).values())[:3]
"""

CHIPS = ("main", "locomotion")


def mixed(folder: Path) -> Path:
    """Make a predator's build with a prey's locomotion controller, sound in itself."""
    shutil.copytree(FIRMWARE / "predator", folder)
    for name in ("locomotion.bs2", "locomotion.bin"):
        shutil.copy(FIRMWARE / "prey" / name, folder / name)
    record = json.loads((folder / "build.json").read_text())
    other = json.loads((FIRMWARE / "prey" / "build.json").read_text())
    record["programs"]["locomotion"] = other["programs"]["locomotion"]
    (folder / "build.json").write_text(json.dumps(record))
    assert read_subject(folder).images["locomotion"].digest == image_of("prey", "locomotion")
    return folder


def image_of(role: str, chip: str) -> str:
    return subject(role).images[chip].digest


@pytest.mark.parametrize("level", ["smoke", "exhaustive"])
def test_a_build_with_the_legs_of_another_robot_fails(tmp_path: Path, level: str) -> None:
    """Whatever is decided is right there, and what is walked is not."""
    (tmp_path / "test_robot.py").write_text(ONE_LINE)
    words = (f"--hil-build={mixed(tmp_path / 'mixed')}", f"--hil-level={level}")
    ended = inside(tmp_path, *words, "--hil-report=r.json")
    assert ended.returncode == 1, ended.stdout
    assert "locomotion.bs2: FORWARD was asked for: not FORWARD" in ended.stdout
    assert "PASS servobot-predator on emulator: " in ended.stdout
    assert json.loads((tmp_path / "r.json").read_text())["verdict"] == "FAIL"


def test_both_images_are_tried_once(tmp_path: Path) -> None:
    (tmp_path / "test_robot.py").write_text(ONE_LINE + ONE_LINE.replace("my", "the"))
    words = (f"--hil-build={FIRMWARE / 'prey'}", "--hil-level=smoke", "--hil-report=r.json")
    ended = inside(tmp_path, *words)
    assert ended.returncode == 0, ended.stdout
    report = json.loads((tmp_path / "r.json").read_text())
    (robot,) = report["robots"]
    targets = [row["target"] for row in robot["trials"].values()]
    for one in ("sources", "emulator:locomotion", "emulator:timing", "emulator:conduct"):
        assert targets.count(one) == 2, targets
    assert (report["verdict"], robot["timing"] is not None) == ("PASS", True)


@contextmanager
def served() -> Iterator[list[str]]:
    """Serve both ports of the reference prey, emulated."""
    one = subject("prey")
    bench = robot_bench(one.robot, one.images)
    with serve(bench, dict.fromkeys(CHIPS, "rfc2217:0")) as server:
        yield [f"serial-reset:{one.url}" for one in server.endpoints]


def test_a_chip_that_is_not_asked_is_a_row_and_the_whole_unproven(tmp_path: Path) -> None:
    (tmp_path / "test_robot.py").write_text(
        ONE_LINE.replace("hil_stimuli)\n", "hil_stimuli[:3])\n")
    )
    build = f"--hil-build={FIRMWARE / 'prey'}"
    with served() as (main, _):
        words = (build, f"--hil-target={main}", "--hil-flash=never")
        ended = inside(tmp_path, *words, "--hil-report=r.json", "--junitxml=j.xml")
        refused = inside(tmp_path, *words, "--hil-require")
    assert "NOT TRIED servobot-prey, legs: whose bytes are in the locomotion" in ended.stdout
    assert "with --hil-legs serial:PORT" in ended.stdout
    assert "UNPROVEN: 1 of what was to be shown was not tried" in ended.stdout
    report = json.loads((tmp_path / "r.json").read_text())
    assert (report["verdict"], report["robots"][0]["verdict"]) == ("UNPROVEN", "UNPROVEN")
    (case,) = ElementTree.parse(tmp_path / "j.xml").iter("testcase")
    told = {one.get("name"): one.get("value") for one in case.iter("property")}
    assert str(told["hil_not_tried"]).startswith("legs: whose bytes are in the locomotion")
    assert refused.returncode == 1
    assert "legs: whose bytes are in the locomotion" in refused.stdout


@pytest.mark.parametrize("verdict", ["PASS", "FAIL", "BLOCKED"])
def test_what_legs_on_a_wire_do_counts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, verdict: str
) -> None:
    """How legs walk is `hil.wired_walks`'; here it is looked at what its answer leads to."""
    (tmp_path / "test_robot.py").write_text(FEW + ONE_LINE)
    monkeypatch.setattr("hil.beside.beside_decisions", lambda *_: iter(()))
    walked = Trial("serial:legs", Verdict(verdict), "the legs say so", {0: 1}, {0: 1})
    monkeypatch.setattr("hil.beside.try_legs", lambda url, _: {"serial:legs": walked}[url])
    build = f"--hil-build={FIRMWARE / 'prey'}"
    with served() as (main, _):
        words = (build, f"--hil-target={main}", "--hil-legs=serial:legs", "--hil-flash=never")
        ended = inside(tmp_path, *words, "--hil-level=smoke", "--hil-report=r.json")
    assert ended.returncode == int(verdict != "PASS"), ended.stdout
    report = json.loads((tmp_path / "r.json").read_text())
    assert report["verdict"] in {verdict, "FAIL"} - ({"FAIL"} if verdict == "PASS" else set())
    assert report["robots"][0]["trials"]["legs"]["verdict"] == verdict


def test_legs_alone_have_no_effect(tmp_path: Path) -> None:
    ended = inside(tmp_path, "--hil-legs=serial:/no")
    assert ended.returncode == 4
    assert "--hil-legs is for --hil-target serial:PORT or --hil-target can:" in ended.stderr


def test_legs_that_nobody_has_asked_are_a_row(tmp_path: Path) -> None:
    (tmp_path / "test_robot.py").write_text("def test_it(hil_target): pass\n")
    build = f"--hil-build={FIRMWARE / 'prey'}"
    with served() as (main, legs):
        words = (build, f"--hil-target={main}", f"--hil-legs={legs}", "--hil-flash=never")
        ended = inside(tmp_path, *words)
    assert "NOT TRIED servobot-prey, legs: no test has given hil_stimuli" in ended.stdout
