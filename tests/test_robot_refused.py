"""Robot and arena files with one thing wrong: each is refused in one sentence."""

import copy
import math
from typing import Any

import pytest
import tomli_w

from cgagen.errors import RobotError
from cgagen.robot import load_robot
from cgagen.robot.reader import parse_arena, parse_robot
from tests.pursuit import content
from tests.robot_changes import PREDATOR, PREY, Change, Content, put


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


CURVE = PREDATOR["light"]["sensor"][1]["curve"]


def curve(rows: object) -> Change:
    return put("light", "sensor", 1, "curve", to=rows)


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
    ("blank name", PREDATOR, put("name", to="  "), ["name: nothing but blanks"]),
    ("name of two lines", PREY, put("name", to="a\nb"), ["name: U+000A in it cannot be printed"]),
    ("name that reads backwards", PREY, put("name", to="a\u202eb"), ["name: U+202E"]),
    ("name of an escape", PREY, put("name", to="\x1b[2J"), ["name: U+001B"]),
    ("long name", PREY, put("name", to="x" * 201), ["name: 201 characters; at most 200"]),
    ("policy of two lines", PREY, put("reflex", "policies", "a\nb", to={}),
     ["[reflex.policies] a\\nb: U+000A in it cannot be printed"]),
    ("key of two lines", PREY, put("ma\x1bin\n", to=1),
     ["ma\\x1bin\\n: no such key", "mean main?"]),
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
    ("srf04 in no mode", PREDATOR, both(srf04(0, 12, 13), put("sonar", 0, "mode", to="low")),
     ["[sonar.front] mode", "ground, open"]),
    ("ping with a mode", PREDATOR, put("sonar", 0, "mode", to="open"), ["[sonar.front] mode"]),
    ("srf04 on a high pin of a BS2, mode open", PREDATOR,
     both(both(put("main", "model", to="BS2"), srf04(0, 12, 13)),
          put("sonar", 0, "mode", to="open")),
     ["[sonar.front] echo_pin", "BS2 looks at P13", "P0 to P7", 'mode = "ground"']),
    ("silence as an obstacle", PREDATOR, put("situation", "front_far_in", to=126),
     ["[situation] front_far_in", "126 in is farther", "'front' sonar hears", "125 in at most"]),
    ("silence as an alarm", PREY, put("reflex", "policies", "wary", "alarm_in", to=200),
     ["[reflex.policies.wary] alarm_in", "200 in is farther"]),
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
    ("curve falls in count", PREDATOR, curve([[2, 50], [90, 49]]),
     ["[light.sensor.right] curve", "[90, 49]", "both rising"]),
    ("curve falls in distance", PREDATOR, curve([[2, 5], [2, 9], [99, 3000]]),
     ["[light.sensor.right] curve", "[2, 9]"]),
    ("curve of one row", PREDATOR, curve([[2, 50]]),
     ["curve", "1 pairs", "2 to 9"]),
    ("curve of none", PREDATOR, curve([]), ["curve", "0 pairs"]),
    ("curve of ten rows", PREDATOR, curve([[n + 1, n + 1] for n in range(10)]),
     ["curve", "10 pairs", "2 to 9"]),
    ("curve ends early", PREDATOR, curve(CURVE[:-2]),
     ["[light.sensor.right] curve", "ends at 60 in", "reach 84 in"]),
    ("curve with count 0", PREDATOR, curve([[2, 0], [96, 9]]),
     ["[2, 0]", "1 to"]),
    ("curve beyond a word", PREDATOR, curve([[2, 1], [96, 65536]]), ["65536"]),
    ("curve with NaN", PREDATOR, curve([[math.nan, 1], [96, 9]]), ["nan"]),
    ("curve of flags", PREDATOR, curve([[2, True], [96, 9]]), ["True"]),
    ("curve is a number", PREDATOR, curve(5), ["[light.sensor.right] curve"]),
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


def test_an_echo_longer_than_pulsin_counts_is_refused() -> None:
    """An SRF04 that sees nothing gives 36 ms: 72,000 counts of 0.5 us. Ref: S2 p. 343, S8."""
    text = load_robot("servobot-predator").text.replace(
        "pulsin_unit_ns = 750", "pulsin_unit_ns = 250"
    )
    with pytest.raises(RobotError, match=r"pulsin_unit_ns: .*74000 counts.*65535"):
        parse_robot(text, "mine.toml")
