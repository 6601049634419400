"""Robot and arena files: what ships is marked and can be loaded, and files that are none."""

import copy
import re
from pathlib import Path

import pytest

from cgagen.errors import RobotError
from cgagen.robot import ROBOTS_FOLDER, load_arena, load_robot, shipped
from cgagen.robot.reader import parse_robot
from cgagen.words import COMMANDS, Movement, Role
from tests.pursuit import other_world, robot_from
from tests.robot_changes import PREDATOR

MARK = re.compile(r"\b(ref: S\d+|choice\b|measured\b)")


# -- what ships -----------------------------------------------------------------------------------


def unmarked_lines(text: str) -> list[str]:
    """Return the lines with a number for which no mark answers.

    A mark stands on the line, in the comment of its table's header, or in the comment before it.
    """
    unmarked, header, comment = [], "", ""
    for line in text.splitlines():
        code, _, remark = line.partition("#")
        if not code.strip():
            comment = (comment + remark) if line.strip() else ""
        elif re.match(r"\[+[a-z]", code):
            header, comment = remark, ""
        elif re.search(r"(=|^\s+\[).*\d", re.sub(r'"[^"]*[A-Za-z][^"]*"', "", code)):
            if not MARK.search(remark + header + comment):
                unmarked.append(line)
        elif not code.rstrip().endswith(("[", "]", ",")):
            comment = ""
    return unmarked


@pytest.mark.parametrize("path", sorted(ROBOTS_FOLDER.glob("*.toml")), ids=lambda path: path.stem)
def test_every_number_says_where_it_comes_from(path: Path) -> None:
    assert unmarked_lines(path.read_text("utf-8")) == []


def test_a_number_without_a_mark_is_noticed() -> None:
    text = (ROBOTS_FOLDER / "servobot-predator.toml").read_text("utf-8")
    bare = re.sub(r"(cone_deg = 66) +# choice$", r"\1", text, flags=re.MULTILINE)
    assert unmarked_lines(bare) == ["cone_deg = 66"]


def test_what_ships_can_be_loaded() -> None:
    assert shipped("robot") == ["servobot-predator", "servobot-prey"]
    assert shipped("arena") == ["colony"]
    for name in shipped("robot"):
        robot = load_robot(name)
        assert robot.name == name
        assert tuple(step.movement for step in robot.steps) == COMMANDS[robot.role]
    assert load_arena("colony").name == "colony"


def test_a_copy_in_another_place_is_the_same_robot(tmp_path: Path) -> None:
    copied = tmp_path / "mine.toml"
    copied.write_bytes((ROBOTS_FOLDER / "servobot-prey.toml").read_bytes())
    assert load_robot(str(copied)) == load_robot("servobot-prey")


def test_tables_may_stand_in_any_order() -> None:
    changed = copy.deepcopy(PREDATOR)
    changed["sonar"].reverse()
    changed["antenna"].reverse()
    changed["light"]["sensor"].reverse()
    robot, usual = robot_from(changed), load_robot("servobot-predator")
    assert (robot.sonars, robot.antennas) == (usual.sonars, usual.antennas)
    assert robot.light == usual.light
    assert robot.interface == usual.interface


def test_the_interface_is_words_and_no_numbers() -> None:
    usual, other = load_robot("servobot-predator"), other_world()[0]
    assert usual.interface == other.interface
    assert usual.interface != load_robot("servobot-prey").interface
    assert usual.digest != other.digest


def test_the_other_role_is_refused_where_one_is_wanted() -> None:
    with pytest.raises(RobotError, match=r"servobot-prey\.toml: role: a prey.*predator"):
        load_robot("servobot-prey", role=Role.PREDATOR)


def test_a_robot_may_do_without_a_step_line() -> None:
    changed = copy.deepcopy(PREDATOR)
    changed["command"]["step_line"] = "none"
    assert robot_from(changed).link.step_line is None


# -- files that are no robots ---------------------------------------------------------------------


def test_a_missing_robot_is_told_which_there_are(tmp_path: Path) -> None:
    with pytest.raises(
        RobotError, match=r"nobody: no such robot.*servobot-predator, servobot-prey"
    ):
        load_robot("nobody")
    with pytest.raises(RobotError, match=r"no such arena.*colony"):
        load_arena(str(tmp_path / "none.toml"))
    with pytest.raises(RobotError, match="is a folder"):
        load_robot(str(tmp_path))  # a folder
    with pytest.raises(RobotError, match="is a folder"):
        load_robot("")


def test_an_arena_is_no_robot() -> None:
    with pytest.raises(RobotError, match=r"format: 'cgagen-arena-1' is not one of cgagen-robot-1"):
        load_robot(str(ROBOTS_FOLDER / "colony.toml"))
    with pytest.raises(RobotError, match=r"format: 'cgagen-robot-1' is not one of cgagen-arena-1"):
        load_arena(str(ROBOTS_FOLDER / "servobot-prey.toml"))


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"\xff\xfe\x00", "text of 16 bits"),
        (b'name = "caf\xe9"', "not UTF-8 at byte 11"),
        (b"name = ", "not TOML"),
        (b"[main\n", "not TOML.*line 1"),
        (b"a = 1\na = 2\n", "not TOML"),
        (b"", "format: missing; wanted one of cgagen-robot-1"),
        (b"\x00", "not TOML"),
    ],
)
def test_bytes_that_are_no_file_of_ours(tmp_path: Path, data: bytes, words: str) -> None:
    path = tmp_path / "bad.toml"
    path.write_bytes(data)
    with pytest.raises(RobotError, match=words) as refused:
        load_robot(str(path))
    assert "bad.toml" in str(refused.value)
    assert "\n" not in str(refused.value)


def test_movements_are_the_papers_table() -> None:
    assert COMMANDS[Role.PREDATOR][1] is Movement.BACKWARD
    assert COMMANDS[Role.PREY][1] is Movement.WAIT


def test_a_movement_may_keep_one_side_still() -> None:
    text = load_robot("servobot-predator").text.replace("left_deg = 11.5", "left_deg = 0")
    assert parse_robot(text, "mine.toml").steps[0].left_deg == 0
