"""Robot and arena files: what ships is marked, and what cannot be is refused in one sentence."""

import copy
import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import tomli_w
from hypothesis import given, settings
from hypothesis import strategies as st
from pursuit import content, other_world, robot_from

from cgagen.errors import RobotError
from cgagen.robot import ROBOTS_FOLDER, Arena, Robot, load_arena, load_robot, shipped
from cgagen.robot.reader import parse_arena, parse_robot
from cgagen.words import COMMANDS, Movement, Role

Content = dict[str, Any]
Change = Callable[[Content], object]

PREDATOR, PREY = content("servobot-predator"), content("servobot-prey")

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
    with pytest.raises(RobotError, match="no such robot"):
        load_robot(str(tmp_path))  # a folder
    with pytest.raises(RobotError, match="no such robot"):
        load_robot("")


def test_an_arena_is_no_robot() -> None:
    with pytest.raises(RobotError, match=r"format: 'cgagen-arena-1' is not one of cgagen-robot-1"):
        load_robot(str(ROBOTS_FOLDER / "colony.toml"))
    with pytest.raises(RobotError, match=r"format: 'cgagen-robot-1' is not one of cgagen-arena-1"):
        load_arena(str(ROBOTS_FOLDER / "servobot-prey.toml"))


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"\xff\xfe\x00", "not UTF-8 at byte 0"),
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


# -- one thing wrong ------------------------------------------------------------------------------


def put(*path: str | int, to: Any) -> Change:
    """Return a change of one value, by its path."""

    def change(data: Content) -> None:
        at: Any = data
        for key in path[:-1]:
            at = at[key]
        at[path[-1]] = to

    return change


def drop(*path: str | int) -> Change:
    """Return a change that takes one value away."""

    def change(data: Content) -> None:
        at: Any = data
        for key in path[:-1]:
            at = at[key]
        del at[path[-1]]

    return change


def both(*changes: Change) -> Change:
    return lambda data: [change(data) for change in changes]


def srf04(sonar: int, trigger: int, echo: int) -> Change:
    return both(
        drop("sonar", sonar, "pin"),
        put("sonar", sonar, "kind", to="srf04"),
        put("sonar", sonar, "trigger_pin", to=trigger),
        put("sonar", sonar, "echo_pin", to=echo),
    )


def sentence_of(data: Content, change: Change) -> str:
    """Return the sentence with which a changed file is refused; it is one line."""
    changed = copy.deepcopy(data)
    change(changed)
    with pytest.raises(RobotError) as refused:
        parse_robot(tomli_w.dumps(changed), "mine.toml")
    sentence = str(refused.value)
    assert sentence.startswith("mine.toml: ")
    assert "\n" not in sentence
    return sentence


LIGHT = ("light",)
CURVE = PREDATOR["light"]["curve"]

REFUSALS: list[tuple[str, Content, Change, list[str]]] = [
    # unknown, missing, of another type
    ("typo", PREDATOR, put("sonar", 0, "bearing_degs", to=3),
     ["[sonar.front] bearing_degs", "did you mean bearing_deg?"]),
    ("typo on top", PREY, put("telemetri", to=True), ["telemetri", "did you mean telemetry?"]),
    ("stranger", PREDATOR, put("main", "zzz", to=1), ["[main] zzz", "known here: model"]),
    ("prey with light", PREY, put("light", to=PREDATOR["light"]), ["light", "no such key"]),
    ("missing", PREDATOR, drop("main", "model"), ["[main] model: missing", "BS2p"]),
    ("missing table", PREDATOR, drop("echo"), ["echo: missing", "[echo]"]),
    ("other model", PREDATOR, put("main", "model", to="BS1"), ["[main] model", "'BS1'", "BS2pe"]),
    ("text for number", PREDATOR, put("body", "radius_units", to="10"),
     ["[body] radius_units", "'10'", "0.1 to 1000"]),
    ("flag for number", PREDATOR, put("body", "radius_units", to=True), ["radius_units", "True"]),
    ("NaN", PREDATOR, put("body", "radius_units", to=math.nan), ["radius_units", "nan"]),
    ("inf", PREDATOR, put("movement", "FORWARD", "along_units", to=math.inf),
     ["[movement.FORWARD] along_units", "inf", "-100 to 100"]),
    ("-inf", PREY, put("reflex", "policies", "wary", "alarm_in", to=-math.inf),
     ["[reflex.policies.wary] alarm_in", "-inf"]),
    ("fraction of a pin", PREDATOR, put("antenna", 0, "pin", to=8.0),
     ["[antenna.left] pin", "whole number from 0 to 15"]),
    ("number for flag", PREDATOR, put("telemetry", to=1), ["telemetry", "true or false"]),
    ("number for table", PREDATOR, put("echo", to=1), ["echo", "table [echo]"]),
    ("table for list", PREDATOR, put("sonar", to={"a": 1}), ["sonar", "[[sonar]]"]),
    ("number for list", PREDATOR, put("command", "main_pins", to=3), ["main_pins", "list of 3"]),
    ("short list", PREDATOR, put("servo", "pin", "LF", to=[0]), ["[servo.pin] LF", "list of 2"]),
    ("falling pair", PREDATOR, put("antenna", 0, "robot_deg", to=[50, -5]),
     ["[antenna.left] robot_deg", "rising"]),
    ("empty name", PREDATOR, put("name", to=""), ["name", "a text"]),
    ("policy of two lines", PREY, put("reflex", "policies", "a\nb", to={}),
     ["[reflex.policies.a?b] alarm_in: missing"]),
    ("key of two lines", PREY, put("ma\x1bin\n", to=1), ["ma?in?: no such key", "mean main?"]),
    ("slow sound", PREDATOR, put("echo", "us_per_in", to=7.3746), ["us_per_in", "60 to 90"]),
    # sensors
    ("missing sonar", PREDATOR, drop("sonar", 2), ["sonar", "'left' is missing"]),
    ("sonar twice", PREDATOR, put("sonar", 2, "name", to="right"),
     ["[sonar.right] name", "stands twice"]),
    ("unknown sonar", PREDATOR, put("sonar", 0, "name", to="rear"), ["rear", "front, right, left"]),
    ("unknown kind", PREY, put("sonar", 0, "kind", to="ultra"), ["'ultra'", "ping, srf04"]),
    ("missing antenna", PREY, drop("antenna", 0), ["antenna", "'left' is missing"]),
    ("light sensor twice", PREDATOR, put("light", "sensor", 0, "name", to="right"),
     ["[light.sensor.right] name", "stands twice"]),
    ("srf04 with one pin", PREDATOR, put("sonar", 0, "kind", to="srf04"),
     ["[sonar.front] trigger_pin: missing"]),
    ("left sonar on the right", PREDATOR, put("sonar", 2, "bearing_deg", to=-30),
     ["[sonar.left] bearing_deg", "not to the left", "0 to 180"]),
    ("left antenna ahead", PREDATOR, put("antenna", 0, "bearing_deg", to=0),
     ["[antenna.left] bearing_deg", "not to the left"]),
    ("right light on the left", PREDATOR, put("light", "sensor", 1, "bearing_deg", to=25),
     ["[light.sensor.right] bearing_deg", "not to the right", "180 to 360"]),
    ("rear_right on the left", PREY, put("sonar", 5, "bearing_deg", to=150),
     ["[sonar.rear_right] bearing_deg", "not to the right"]),
    ("cone within another", PREDATOR,
     both(put("sonar", 1, "bearing_deg", to=355), put("sonar", 1, "cone_deg", to=20)),
     ["[sonar.right] cone_deg", "within that of 'front'"]),
    ("cone too wide", PREDATOR, put("sonar", 0, "cone_deg", to=171), ["cone_deg", "1 to 170"]),
    # pins
    ("pin twice", PREDATOR, put("antenna", 0, "pin", to=4),
     ["[antenna.left] pin", "P4", "main controller", "[sonar.front] pin", "free pins: 7, 8, 12"]),
    ("srf04 with one pin for both", PREDATOR, srf04(0, 12, 12), ["P12", "[sonar.front] pin"]),
    ("srf04 on a used pin", PREDATOR, srf04(0, 12, 8), ["P8", "[antenna.left] pin"]),
    ("step line on a sensor", PREDATOR, put("command", "step_line", "main_pin", to=5),
     ["[command.step_line] main_pin", "P5", "[sonar.right] pin"]),
    ("step line on a servo", PREDATOR, put("command", "step_line", "locomotion_pin", to=11),
     ["[command.step_line] locomotion_pin", "P11", "[servo.pin] RR vertical"]),
    ("servo twice", PREY, put("servo", "pin", "RM", to=[3, 9]),
     ["[servo.pin] RM horizontal", "P3", "locomotion controller", "LM vertical"]),
    ("servo on a command line", PREY, put("servo", "pin", "RR", to=[10, 12]),
     ["P12", "locomotion controller"]),
    ("light on a command line", PREDATOR, put("light", "sensor", 0, "pin", to=1), ["P1 ", "main"]),
    ("pin 16", PREDATOR, put("sonar", 0, "pin", to=16), ["[sonar.front] pin", "16", "0 to 15"]),
    ("pin -1", PREDATOR, put("light", "sensor", 0, "pin", to=-1), ["pin", "-1", "0 to 15"]),
    ("servo pin 16", PREY, put("servo", "pin", "LF", to=[0, 16]), ["[servo.pin] LF", "16"]),
    # command lines
    ("crossed nibbles", PREDATOR, put("command", "main_pins", to=[12, 13, 7]),
     ["[command] main_pins", "nibble", "[4, 5, 6]"]),
    ("not at a nibble", PREDATOR,
     both(put("command", "step_line", to="none"),
          put("command", "locomotion_pins", to=[13, 14, 15])),
     ["[command] locomotion_pins", "[13, 14, 15]", "nibble"]),
    ("backwards", PREDATOR, put("command", "main_pins", to=[2, 1, 0]), ["main_pins", "nibble"]),
    ("a sensor on the fourth pin", PREDATOR,
     both(put("command", "step_line", "main_pin", to=7), put("sonar", 0, "pin", to=3)),
     ["[command] main_pins", "P3", "fourth pin"]),
    ("no step line", PREDATOR, put("command", "step_line", to="no"), ["step_line", "'no'"]),
    # situations and light
    ("front limits fall", PREDATOR, put("situation", "front_near_in", to=23),
     ["[situation] front_near_in", "23", "front_middle_in = 22", "must rise"]),
    ("front limits equal", PREDATOR, put("situation", "front_far_in", to=22),
     ["front_middle_in", "front_far_in = 22"]),
    ("side limits fall", PREDATOR, put("situation", "side_far_in", to=9), ["side_near_in"]),
    ("target limits fall", PREDATOR, put("situation", "target_front_near_in", to=41),
     ["target_front_near_in", "target_front_middle_in"]),
    ("limits of one count", PREDATOR,
     both(put("situation", "side_near_in", to=10), put("situation", "side_far_in", to=10.001)),
     ["side_near_in", "same chip count"]),
    ("curve falls in count", PREDATOR, put("light", "curve", to=[[2, 50], [90, 49]]),
     ["[light] curve", "[90, 49]", "both rising"]),
    ("curve falls in distance", PREDATOR, put("light", "curve", to=[[2, 5], [2, 9], [99, 3000]]),
     ["[light] curve", "[2, 9]"]),
    ("curve of one row", PREDATOR, put("light", "curve", to=[[2, 50]]),
     ["curve", "1 pairs", "2 to 9"]),
    ("curve of none", PREDATOR, put("light", "curve", to=[]), ["curve", "0 pairs"]),
    ("curve of ten rows", PREDATOR, put("light", "curve", to=[[n + 1, n + 1] for n in range(10)]),
     ["curve", "10 pairs", "2 to 9"]),
    ("curve ends early", PREDATOR, put("light", "curve", to=CURVE[:-2]),
     ["[light] curve", "ends at 60 in", "reach 84 in"]),
    ("curve with count 0", PREDATOR, put("light", "curve", to=[[2, 0], [96, 9]]),
     ["[2, 0]", "1 to"]),
    ("curve beyond a word", PREDATOR, put("light", "curve", to=[[2, 1], [96, 65536]]), ["65536"]),
    ("curve with NaN", PREDATOR, put("light", "curve", to=[[math.nan, 1], [96, 9]]), ["nan"]),
    ("curve of flags", PREDATOR, put("light", "curve", to=[[2, True], [96, 9]]), ["True"]),
    ("curve is a number", PREDATOR, put("light", "curve", to=5), ["[light] curve"]),
    ("light cones apart", PREDATOR, put("light", "sensor", 0, "cone_deg", to=50),
     ["[light.sensor.left] cone_deg", "straight ahead"]),
    ("unknown condition", PREDATOR, put("light", "condition", to="dusk"),
     ["'dusk'", "dark, ambient"]),
    # movements, gait, servos
    ("missing movement", PREDATOR, drop("movement", "BACKUP_LEFT"),
     ["[movement] BACKUP_LEFT: missing"]),
    ("prey's movement", PREDATOR, put("movement", "WAIT", to=PREY["movement"]["WAIT"]),
     ["[movement] WAIT", "no such key"]),
    ("predator's answer", PREY, put("reflex", "antenna_left", to="BACKWARD"),
     ["[reflex] antenna_left", "'BACKWARD'", "WAIT"]),
    ("unknown policy", PREY, put("reflex", "policy", to="brave"), ["'brave'", "turn, wall, wary"]),
    ("no policies", PREY, put("reflex", "policies", to={}), ["[reflex]", "polic"]),
    ("policy without a sonar", PREY, drop("reflex", "policies", "wall", "left"),
     ["[reflex.policies.wall] left: missing"]),
    ("phase 7", PREDATOR, put("movement", "FORWARD", "first_phase", to=7),
     ["first_phase", "1 to 6"]),
    ("ends with the leg back", PREDATOR, put("movement", "FORWARD", "first_phase", to=4),
     ["[movement.FORWARD] first_phase", "left front leg", "other sign of left_deg"]),
    ("ends with the leg up", PREDATOR, put("movement", "FORWARD", "first_phase", to=2),
     ["[movement.FORWARD] first_phase", "left front leg"]),
    ("pulse too long", PREDATOR, put("movement", "ROTATE_LEFT", "left_deg", to=51),
     ["[movement.ROTATE_LEFT]", "horizontal servo of LF", "1005", "500 to 1000"]),
    ("pulse too short", PREDATOR, put("servo", "trim_counts", "RM", to=[0, -101]),
     ["vertical servo of RM", "499", "500 to 1000"]),
    ("centre outside", PREDATOR, put("servo", "centre_counts", to=1000),
     ["[servo] centre_counts", "min_counts"]),
    ("no direction", PREDATOR, put("servo", "direction", "LF", to=[0, 1]),
     ["[servo.direction] LF", "1 or -1"]),
    ("five poses", PREDATOR, drop("gait", "phase", 5), ["[gait] phase", "5 poses"]),
    ("short mask", PREDATOR, put("gait", "phase", 0, "up", to="01010"),
     ["[gait.phase.1] up", "six"]),
    ("mask of letters", PREDATOR, put("gait", "phase", 2, "forward", to="01010x"),
     ["[gait.phase.3] forward", "LF LM LR RF RM RR"]),
    ("legs in another order", PREDATOR, put("gait", "legs", 0, to="RF"),
     ["[gait] legs", "LF LM LR"]),
]  # fmt: skip


@pytest.mark.parametrize(
    ("data", "change", "words"), [row[1:] for row in REFUSALS], ids=[row[0] for row in REFUSALS]
)
def test_one_thing_wrong_is_one_sentence(data: Content, change: Change, words: list[str]) -> None:
    sentence = sentence_of(data, change)
    for word in words:
        assert word in sentence, sentence


ARENA_REFUSALS = [
    ("typo", put("side_unit", to=300), ["side_unit", "did you mean side_units?"]),
    ("missing", drop("walls"), ["walls: missing", "slide, stop"]),
    ("unknown walls", put("walls", to="bounce"), ["walls", "'bounce'", "slide, stop"]),
    ("unknown capture", put("after_capture", to="halt"), ["after_capture", "hold, go_on"]),
    ("capture out of reach", put("capture_score_units", to=424.26),
     ["capture_score_units", "less than longest_units = 424.26"]),
    ("gap too wide", put("start_gap_units", to=151), ["start_gap_units", "half of a side"]),
    ("NaN", put("side_units", to=math.nan), ["side_units", "nan"]),
    ("tiny", put("side_units", to=1), ["side_units", "50 to 10000"]),
    ("text", put("units_per_in", to="3"), ["units_per_in", "'3'"]),
]  # fmt: skip


@pytest.mark.parametrize(
    ("change", "words"),
    [row[1:] for row in ARENA_REFUSALS],
    ids=[row[0] for row in ARENA_REFUSALS],
)
def test_an_arena_with_one_thing_wrong(change: Change, words: list[str]) -> None:
    changed = content("colony")
    change(changed)
    with pytest.raises(RobotError) as refused:
        parse_arena(tomli_w.dumps(changed), "mine.toml")
    sentence = str(refused.value)
    assert sentence.startswith("mine.toml: ")
    assert "\n" not in sentence
    for word in words:
        assert word in sentence, sentence


# -- anything wrong -------------------------------------------------------------------------------


def places(data: Any, path: tuple[str | int, ...] = ()) -> list[tuple[str | int, ...]]:
    """Return the paths of all values of a file, tables and lists among them."""
    inner = data.items() if isinstance(data, dict) else enumerate(data)
    found = []
    for key, value in inner:
        found.append((*path, key))
        if isinstance(value, dict | list):
            found += places(value, (*path, key))
    return found


GARBAGE = st.one_of(
    st.booleans(),
    st.integers(-(2**63), 2**63 - 1),
    st.integers(-20, 20),
    st.floats(),
    st.floats(-400, 400),
    st.text("ab01é \"'\\\n[", max_size=7),
    st.sampled_from(["none", "hold", "FORWARD", "ping", "srf04", "left"]),
    st.lists(st.one_of(st.integers(-5, 20), st.floats(), st.lists(st.integers(), max_size=2))),
    st.dictionaries(st.sampled_from(["name", "pin", "x"]), st.integers(0, 20), max_size=2),
)


def refusal_of(parse: Callable[[str, str], object], text: str) -> str | None:
    """Return the sentence with which a text is refused, or None; other errors are bugs."""
    try:
        parse(text, "mine.toml")
    except RobotError as error:
        return str(error)
    return None


def garbled(data: Content, changes: list[tuple[int, Any]]) -> str:
    changed = copy.deepcopy(data)
    paths = places(data)
    for number, value in changes:
        try:
            put(*paths[number % len(paths)], to=value)(changed)
        except (KeyError, IndexError, TypeError):
            continue  # an earlier change took that place away
    return tomli_w.dumps(changed)


CHANGES = st.lists(st.tuples(st.integers(0, 500), GARBAGE), min_size=1, max_size=3)


@given(st.sampled_from([PREDATOR, PREY]), CHANGES)
@settings(max_examples=400, deadline=None)
def test_garbage_is_a_robot_or_a_sentence(data: Content, changes: list[tuple[int, Any]]) -> None:
    text = garbled(data, changes)
    sentence = refusal_of(parse_robot, text)
    if sentence is None:
        robot = parse_robot(text, "mine.toml")
        assert isinstance(robot, Robot)
        assert robot.interface
        assert robot.alarm_count if robot.reflex else robot.situation_counts
    else:
        assert sentence.startswith("mine.toml: ")
        assert "\n" not in sentence


@given(CHANGES)
@settings(max_examples=60, deadline=None)
def test_garbage_is_an_arena_or_a_sentence(changes: list[tuple[int, Any]]) -> None:
    text = garbled(content("colony"), changes)
    sentence = refusal_of(parse_arena, text)
    if sentence is None:
        assert isinstance(parse_arena(text, "mine.toml"), Arena)
    else:
        assert sentence.startswith("mine.toml: ")
        assert "\n" not in sentence


@given(st.binary(max_size=60))
@settings(max_examples=60, deadline=None)
def test_noise_is_refused(tmp_path_factory: pytest.TempPathFactory, data: bytes) -> None:
    path = tmp_path_factory.getbasetemp() / "noise.toml"
    path.write_bytes(data)
    with pytest.raises(RobotError):
        load_robot(str(path))


def test_movements_are_the_papers_table() -> None:
    assert COMMANDS[Role.PREDATOR][1] is Movement.BACKWARD
    assert COMMANDS[Role.PREY][1] is Movement.WAIT


def test_an_echo_longer_than_pulsin_counts_is_refused() -> None:
    """An SRF04 that sees nothing gives 36 ms: 72,000 counts of 0.5 us. Ref: S2 p. 343, S8."""
    text = load_robot("servobot-predator").text.replace(
        "pulsin_unit_ns = 800", "pulsin_unit_ns = 250"
    )
    with pytest.raises(RobotError, match=r"pulsin_unit_ns: .*74000 counts.*65535"):
        parse_robot(text, "mine.toml")


def test_a_movement_may_keep_one_side_still() -> None:
    text = load_robot("servobot-predator").text.replace("left_deg = 11.5", "left_deg = 0")
    assert parse_robot(text, "mine.toml").steps[0].left_deg == 0
