"""Options of the plugin that could say two things, or nothing."""

import shutil
from pathlib import Path

import pytest

from cgagen.pytest_plugin.options import FIRMWARE as ON_TRIAL
from cgagen.pytest_plugin.options import OPTIONS, RULES
from hil.simulated import commands_by_state
from hil.subject import read_subject
from tests.plugin_runs import FIRMWARE, inside

DECIDES = """
def test_mine(hil_target, hil_stimuli, hil_check):
    hil_check(hil_target, hil_stimuli)
"""


@pytest.fixture
def beside(tmp_path: Path) -> dict[str, str]:
    """A project with the reference build, another genome, and its robot with a comment."""
    (tmp_path / "test_mine.py").write_text(DECIDES)
    text = (FIRMWARE / "reference.genome").read_text()
    (tmp_path / "g7.genome").write_text(text.replace("\n100 000", "\n101 000", 1))
    robot = (FIRMWARE / "predator" / "robot.toml").read_text()
    (tmp_path / "same.toml").write_text(f"# Mine.\n{robot}")
    return {"build": str(FIRMWARE / "predator"), "genome": "g7.genome"}


@pytest.mark.parametrize(
    ("option", "value", "said"),
    [
        ("genome", "g7.genome", "and the genome that was named beside it is"),
        ("robot", "servobot-prey", "is a build for servobot-predator ("),
        ("genome", "none.genome", "none.genome: cannot be read"),
        ("robot", "none.toml", "none.toml"),
    ],
)
def test_a_build_is_of_what_was_named_beside_it(
    tmp_path: Path, beside: dict[str, str], option: str, value: str, said: str
) -> None:
    """By the command line and the ini file before anything runs; by the environment, each test."""
    build = f"--hil-build={beside['build']}"
    ended = inside(tmp_path, build, f"--hil-{option}={value}")
    assert (ended.returncode, said in ended.stderr) == (4, True), ended.stderr
    assert "passed" not in ended.stdout
    ended = inside(
        tmp_path, **{f"CGAGEN_HIL_{option.upper()}": value, "CGAGEN_HIL_BUILD": beside["build"]}
    )
    assert (ended.returncode, said in ended.stdout) == (1, True), ended.stdout
    (tmp_path / "pytest.ini").write_text(f"[pytest]\nhil_{option} = {value}\n")
    ended = inside(tmp_path, build)
    assert (ended.returncode, said in ended.stderr) == (4, True), ended.stderr


def test_a_build_passes_beside_its_own_genome_and_robot(
    tmp_path: Path, beside: dict[str, str]
) -> None:
    words = (f"--hil-genome={FIRMWARE / 'reference.genome'}", "--hil-robot=same.toml")
    ended = inside(tmp_path, f"--hil-build={beside['build']}", *words)
    assert (ended.returncode, "1 passed" in ended.stdout) == (0, True), ended.stdout


def test_what_has_no_effect_without_another_is_refused_where_it_was_typed(tmp_path: Path) -> None:
    (tmp_path / "test_it.py").write_text("def test_it(): pass\n")
    values = {
        "requirements": "ids.toml",
        "kills": "kills.json",
        "flash": "never",
        "legs": "serial:/no",
    }
    assert {f"--hil-{name}" for name in values} == {rule.option for rule in RULES}
    (tmp_path / "ids.toml").write_text("TABLE = 'what it stands for'\n")
    (tmp_path / "kills.json").write_text('{"format": "cgagen-kills-1"}')
    for rule in RULES:
        value = values[rule.option.removeprefix("--hil-")]
        ended = inside(tmp_path, f"{rule.option}={value}")
        said = f"{rule.option} is for {' or '.join(rule.others)}; give both"
        assert (ended.returncode, said in ended.stderr) == (4, True), ended.stderr
    ended = inside(tmp_path, CGAGEN_HIL_FLASH="never")
    assert ended.returncode == 0, ended.stderr
    ended = inside(tmp_path, "--hil-flash=never", "--hil-target=serial:/no")
    assert ended.returncode == 0, ended.stderr


FREE = {"target", "level", "seed", "trace", "record", "vcd", "coverage", "artifacts", "report"}
FREE |= {"reruns", "require", "force"}
"""Options that say something whatever else is given."""


def test_every_option_is_free_or_in_a_rule_or_held_together() -> None:
    ruled = {rule.option.removeprefix("--hil-") for rule in RULES}
    assert {one.name for one in OPTIONS} == FREE | ruled | set(ON_TRIAL)


def test_a_users_own_test_is_a_proof_unless_less_is_asked_for(tmp_path: Path) -> None:
    """Of the image on the emulator, whatever else the target is; a wrong byte is met by it."""
    (tmp_path / "test_mine.py").write_text(DECIDES)
    build = tmp_path / "build"
    shutil.copytree(FIRMWARE / "prey", build)
    for target in ("emulator", "simulator"):
        ended = inside(tmp_path, "--hil-build=build", f"--hil-target={target}")
        assert ended.returncode == 0, ended.stdout
        assert "PASS: proven for every reading, by all 340,880 cells" in ended.stdout
    ended = inside(tmp_path, "--hil-build=build", "--hil-level=smoke")
    assert ("proven" in ended.stdout, "1 passed" in ended.stdout) == (False, True), ended.stdout
    image = bytearray((build / "main.bin").read_bytes())
    image[image.index(bytes(commands_by_state(read_subject(build))))] ^= 1
    (build / "main.bin").write_bytes(image)
    ended = inside(tmp_path, "--hil-build=build", "--hil-target=simulator")
    assert (ended.returncode, "FAIL: " in ended.stdout) == (1, True), ended.stdout
