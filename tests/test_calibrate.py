"""Measurements into a robot file: means, what is odd, and what a file keeps."""

import cmath
import io
import math
import random
import re
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cgagen.calibrate import HEADERS, Calibration, calibrate, read_measurements
from cgagen.calibrate.displacements import INVERSES, MIRRORS, cycle_of
from cgagen.calibrate.edit import with_value
from cgagen.calibrate.measurements import Walk
from cgagen.cli import main
from cgagen.errors import MeasurementError
from cgagen.robot import Robot, load_robot
from cgagen.robot.reader import ROBOTS_FOLDER, parse_robot
from cgagen.robot.seal import SEAL
from cgagen.words import COMMANDS, Movement, Role

REFERENCE = Path(__file__).parent.parent / "firmware" / "reference.genome"
MOVES, SENSORS = (header + "\n" for header in HEADERS)
UNITS_PER_IN = 3.125


@pytest.fixture(scope="module")
def predator() -> Robot:
    return load_robot("servobot-predator")


def from_text(robot: Robot, *texts: str) -> Calibration:
    tables = {f"table{number}": text for number, text in enumerate(texts)}
    return calibrate(robot, "robot.toml", read_measurements(robot, tables), UNITS_PER_IN, "May 4")


def walked(cycles: int, step: complex, turn_deg: float) -> tuple[float, float, float]:
    """Walk cycle by cycle, as a robot does."""
    place, heading = 0j, 1 + 0j
    for _ in range(cycles):
        place += step * heading
        heading *= cmath.exp(1j * math.radians(turn_deg))
    return place.real, -place.imag, turn_deg * cycles


# -- one cycle out of several ---------------------------------------------------------------------


@given(
    cycles=st.integers(1, 12),
    along=st.floats(-5, 5),
    right=st.floats(-5, 5),
    turn=st.floats(-25, 25),
)
def test_a_walk_is_taken_apart_into_its_cycles(
    cycles: int, along: float, right: float, turn: float
) -> None:
    end = walked(cycles, complex(along, -right), turn)
    assert cycle_of(Walk("", cycles, *end)) == pytest.approx((along, right, turn), abs=1e-6)


def test_a_full_circle_says_nothing() -> None:
    with pytest.raises(MeasurementError, match=r"here: 8 cycles that turn by 360 degrees"):
        cycle_of(Walk("here", 8, 0.0, 0.0, 360.0))


# -- the whole way --------------------------------------------------------------------------------


def table_of(robot: Robot, noise_in: float = 0.0, seed: int = 1) -> str:
    """Measure a robot as its own file has it: five repeats of three cycles."""
    chance, lines = random.Random(seed), [MOVES.strip()]
    for step in robot.steps:
        motion = complex(step.along_units, -step.right_units) / UNITS_PER_IN
        for _ in range(5):
            along, right, turn = walked(3, motion, step.turn_deg)
            along, right = (value + chance.gauss(0, noise_in) for value in (along, right))
            lines.append(f"{step.movement},3,{along!r},{right!r},{turn!r}")
    return "\n".join(lines)


@pytest.mark.parametrize("role", list(Role))
def test_measuring_what_the_file_says_changes_nothing_but_comments(role: Role) -> None:
    robot = load_robot(f"servobot-{role}")
    found = from_text(robot, table_of(robot))
    assert found.robot.steps == robot.steps
    assert found.text != robot.text
    assert found.text.count("# measured: mean of 5, spread ") == 3 * len(robot.steps)
    kept = [line for line in found.text.splitlines() if "measured: mean of 5" not in line]
    assert kept.pop().startswith(SEAL)
    assert set(kept) <= set(robot.text.splitlines())
    assert parse_robot(found.text, "again") == found.robot


def test_the_mean_of_noisy_repeats_is_near(predator: Robot) -> None:
    found = from_text(predator, table_of(predator, noise_in=0.1))
    for before, after in zip(predator.steps, found.robot.steps, strict=True):
        assert after.along_units == pytest.approx(before.along_units, abs=0.6)
        assert after.turn_deg == pytest.approx(before.turn_deg)
    one = found.movements[Movement.FORWARD].along_in
    assert one.repeats == 5
    assert one.spread is not None
    assert 0.005 < one.spread < 0.15  # a third of 0.1 in for each of three cycles


def test_centimetres_and_inches_are_the_same_robot(predator: Robot) -> None:
    inches = from_text(predator, MOVES + "FORWARD,2,4.8,0.5,0\n")
    lengths = "along_cm,movement,right_mm,turn_deg,cycles\n12.192,FORWARD,12.7,0,2\n"
    assert from_text(predator, lengths).text == inches.text
    forward = inches.robot.steps[0]
    assert (forward.along_units, forward.right_units, forward.turn_deg) == (7.5, 0.781, 0)
    assert "along_units = 7.5          # measured: once, May 4\n" in inches.text


def test_sound_and_lamp(predator: Robot) -> None:
    chance, lines = random.Random(3), [SENSORS.strip()]
    for distance in (6, 12, 24, 48, 90):
        for name in ("front", "left", "right"):
            count = round(distance * 2 * 72.0 / 0.75) + chance.randint(-3, 3)
            lines.append(f"{name},{distance},{count}")
    for distance, count in ((6, 60), (12, 166), (24, 450), (90, 2600)):
        lines += [f"light_left,{distance},{count + off}" for off in (-1, 1)]
        lines += [f"light_right,{distance},{count * 13 // 10}"]
    found = from_text(predator, "\n".join(lines))
    assert found.robot.echo.us_per_in == pytest.approx(72.0, abs=0.02)
    assert found.us_per_in is not None
    assert found.us_per_in.repeats == 15
    assert found.robot.light is not None
    left, right = (sensor.curve for sensor in found.robot.light.sensors)
    assert left == ((6, 60), (12, 166), (24, 450), (90, 2600))
    assert right == ((6, 78), (12, 215), (24, 585), (90, 3380))
    assert "measured: 8 readings, spread up to 1.4 counts, May 4" in found.text
    assert len(found.warnings) == 4  # one for each distance
    assert "look at tubes and parts" in found.warnings[0]
    assert found.robot.digest != predator.digest
    assert found.robot.interface == predator.interface


# -- what is odd ----------------------------------------------------------------------------------


def test_a_robot_that_is_its_own_mirror_gives_no_warning(predator: Robot) -> None:
    assert from_text(predator, table_of(predator)).warnings == ()


@pytest.mark.parametrize(("one", "other"), [pair for pair in MIRRORS if pair[0] != pair[1]])
def test_a_movement_unlike_its_mirror_image(
    predator: Robot, one: Movement, other: Movement
) -> None:
    text = MOVES + f"{one},1,1.0,0.2,-40\n{other},1,1.0,-0.2,25\n"
    warned = [line for line in from_text(predator, text).warnings if "mirror" in line]
    assert len(warned) == 1
    assert f"{one} and {other} go differently" in warned[0]
    assert "turn 25 degrees, not about 40" in warned[0]
    assert "along" not in warned[0]


def test_forward_that_veers(predator: Robot) -> None:
    straight, veers = (
        f"{MOVES}FORWARD,4,{along},{right},{turn}\n"
        for along, right, turn in (walked(4, 2.4 + 0j, -1.5), walked(4, 2.4 + 0j, -6.5))
    )
    assert from_text(predator, straight).warnings == ()
    (warning,) = from_text(predator, veers).warnings
    assert warning.startswith("FORWARD goes differently in a mirror: turn -6.5 degrees")


@pytest.mark.parametrize(("one", "other"), INVERSES)
def test_a_movement_that_does_not_undo_its_inverse(
    predator: Robot, one: Movement, other: Movement
) -> None:
    text = MOVES + f"{one},1,0.9,0.4,-37\n{other},1,0.9,-0.25,37\n"
    warned = [line for line in from_text(predator, text).warnings if "does not undo" in line]
    assert len(warned) == 1
    assert warned[0].startswith(
        f"{other} does not undo {one}: along 0.9 in, not about -0.959, right"
    )


def test_a_wide_spread_excuses_a_difference(predator: Robot) -> None:
    wide = [("RIGHT_FORWARD", -40 + way) for way in (-9, 0, 9)]
    wide += [("LEFT_FORWARD", 22 + way) for way in (-9, 0, 9)]
    text = MOVES + "".join(f"{name},1,1,0,{turn}\n" for name, turn in wide)
    assert from_text(predator, text).warnings == ()


def test_a_repeat_far_from_the_others(predator: Robot) -> None:
    rows = "".join(f"FORWARD,1,{along},0,0\n" for along in (2.4, 2.5, 2.3, 5.2, 2.4))
    (warning,) = from_text(predator, MOVES + rows).warnings
    assert warning.startswith("table0: line 5: FORWARD along of 5.2 in a cycle is far from")


def test_a_sonar_that_was_measured_from_elsewhere(predator: Robot) -> None:
    rows = [f"front,{d},{round((d + 1.5) * 196.656)}" for d in (10, 20, 40, 80)]
    rows += [f"{name},{d},{round(d * 196.656)}" for name in ("left", "right") for d in (10, 40, 80)]
    (warning,) = from_text(predator, SENSORS + "\n".join(rows)).warnings
    assert warning.startswith("front: its counts fit distances 1.5 in longer than marked")


def test_a_sonar_unlike_the_others(predator: Robot) -> None:
    rows = [f"front,{d},{round(d * 181.333)}" for d in (10, 20, 40)]
    rows += [f"{name},{d},{round(d * 196.656)}" for name in ("left", "right") for d in (10, 40)]
    warnings = from_text(predator, SENSORS + "\n".join(rows)).warnings
    assert any(line.startswith("front: 68.0 us per inch where all") for line in warnings)


def test_useless_echoes_are_named_and_left_out(predator: Robot) -> None:
    rows = "front,12,0\nfront,140,24666\nfront,0,154\nfront,20,3933\n"
    found = from_text(predator, SENSORS + rows)
    assert found.us_per_in is not None
    assert found.us_per_in.repeats == 1
    assert [line.partition(";")[0] for line in found.warnings] == [
        "table0: line 2: front gave no echo",
        "table0: line 3: front was at the end of its range (24666)",
        "table0: line 4: front was at the end of its range (154)",
    ]
    with pytest.raises(MeasurementError, match=r"no usable measurement; table0: line 2"):
        from_text(predator, SENSORS + "front,12,0\n")


def test_light_sensors_that_differ(predator: Robot) -> None:
    rows = "light_left,12,170\nlight_right,12,240\nlight_left,84,2430\nlight_right,84,2440\n"
    (warning,) = from_text(predator, SENSORS + rows).warnings
    assert warning.startswith("light_left counts 170 and light_right 240 with the lamp at 12 in")
    one = SENSORS + "light_left,12,170\nlight_left,84,2430\n"
    assert from_text(predator, one).warnings[0].startswith("one light sensor only")


# -- what is refused ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "table0: no measurements"),
        ("# nothing\n\n", "table0: no measurements"),
        (MOVES, "table0: no measurements"),
        ("FORWARD,1,2,3,4\n", "line 1: no header"),
        ("movement,movement\n", "line 1: no header"),
        (MOVES + "FORWARD,1,2,3\n", "line 2: 4 cells under 5 columns"),
        (MOVES + "#\n\nFLY,1,2,3,4\n", "line 4: movement: 'FLY' is not one of FORWARD, BACKWARD"),
        (MOVES + "WAIT,1,2,3,4\n", "movement: 'WAIT' is not one of"),
        (MOVES + "FORWARD,0,2,3,4\n", "cycles: '0' is not a number from 1 to 1000"),
        (MOVES + "FORWARD,1.5,2,3,4\n", "cycles: '1.5' is not a whole number"),
        (MOVES + "FORWARD,1,nan,3,4\n", "along_in: 'nan' is not a number"),
        (MOVES + "FORWARD,1,2,3,inf\n", "turn_deg: 'inf' is not a number"),
        (MOVES + "FORWARD,1,2,two,4\n", "right_in: 'two' is not a number"),
        (MOVES + "FORWARD,1,2,\x1b[2J,4\n", r"right_in: '\\x1b\[2J' is not"),
        ("movement,along_in,turn_deg\nFORWARD,1,2\n", "right_in: no such column"),
        ("movement,along_in,along_cm,right_in,turn_deg\nFORWARD,1,2,3,4\n", "in in and cm at once"),
        (MOVES.strip() + ",wind\nFORWARD,1,2,3,4,5\n", "wind: no such column"),
        (SENSORS + "top,1,2\n", "sensor: 'top' is not one of front, right, left, light_left"),
        (SENSORS + "front,-1,2\n", "distance_in: '-1' is not a number"),
        (SENSORS + "front,1,65536\n", "count: '65536' is not a number from 0 to 65535"),
        (SENSORS + "light_left,90,0\nlight_left,10,9\n", "line 2: light_left was dark"),
        (SENSORS + "light_left,10,9\n", "1 distances of the lamp"),
        (SENSORS + "light_left,10,9\nlight_left,20,9\n", "no more than 9 at 10 in"),
        (MOVES + 'FORWARD,"1,2,3,4\n', "line 2: no line of a table"),
    ],
)
def test_a_table_is_refused_with_its_line(predator: Robot, text: str, words: str) -> None:
    with pytest.raises(MeasurementError, match=words):
        from_text(predator, text)


@given(st.text(max_size=200))
def test_no_text_is_more_than_a_sentence(predator: Robot, text: str) -> None:
    for header in ("", MOVES, SENSORS):
        said = ""
        try:
            read_measurements(predator, {"fuzz": header + text})
        except MeasurementError as error:
            said = str(error)
        assert said.isprintable()
        assert said.startswith("fuzz" if said else "")


def test_a_file_whose_tables_are_written_otherwise_is_refused() -> None:
    text = "movement = { FORWARD = { along_units = 1 } }\n"
    with pytest.raises(MeasurementError, match=r"f: \[movement.FORWARD\] along_units: not on a"):
        with_value(text, "f", "movement.FORWARD", "along_units", "2", "why")


def test_only_the_key_of_that_table_is_changed() -> None:
    text = 'k = 1\n[a.b]  # x\nk = 2 # "old"\n[[a.c]]\nk = 3\n[ d ]\nk = ["]", 4,\n 5]\nm = 6\n'
    assert with_value(text, "f", "a.b", "k", "9", "new").splitlines()[2].split() == [
        *("k", "=", "9", "#", "new")
    ]
    cut = with_value(text, "f", "d", "k", "9", "new").splitlines()
    assert cut[:6] == text.splitlines()[:6]
    assert [line.partition(" ")[0] for line in cut[6:]] == ["k", "m"]


# -- the verb -------------------------------------------------------------------------------------


def test_the_verb_writes_a_robot_and_says_what_it_does(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table, mine = tmp_path / "walks.csv", tmp_path / "mine.toml"
    table.write_text(MOVES + "FORWARD,4,4.8,0.1,-6\nFORWARD,4,5.0,0,-5\n")
    words = ["calibrate", str(table), "--robot", "servobot-predator", "-o", str(mine)]
    assert main([*words, "--date", "May 4", "--genome", str(REFERENCE)]) == 0
    out = capsys.readouterr().out
    assert "FORWARD along_in" in out
    assert "captured" in out
    after = load_robot(str(mine))
    assert after.steps[0].along_units == pytest.approx(1.225 * UNITS_PER_IN, rel=0.02)
    assert "# measured: mean of 2, spread 0.11, May 4" in after.text
    assert main(words) == 3
    assert "--force" in capsys.readouterr().err
    assert main([*words, "--force"]) == 0
    assert "May 4" not in mine.read_text()


def test_slower_legs_catch_less(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from cgagen.calibrate import effect_of
    from cgagen.genome import load
    from cgagen.robot import load_arena

    robot, prey, arena = (
        load_robot("servobot-predator"),
        load_robot("servobot-prey"),
        load_arena("colony"),
    )
    slow = from_text(robot, MOVES + "FORWARD,1,0.4,0,0\n").robot
    genome = load(REFERENCE)
    before, after = (effect_of(genome, one, prey, arena) for one in (robot, slow))
    assert before.captured > 0.9  # what its own run folder says of it
    assert after.captured < before.captured
    assert effect_of(genome, prey, slow, arena) == after  # either may be the one measured


def test_a_table_may_be_typed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    class Typed:
        buffer = io.BytesIO((MOVES + "WAIT,1,0,0,0\n").encode())

    monkeypatch.setattr(sys, "stdin", Typed)
    assert main(["calibrate", "-", "--robot", "servobot-prey"]) == 0
    assert "nothing written; give -o FILE" in capsys.readouterr().out


@pytest.mark.parametrize("data", [b"\xff", None])
def test_a_table_that_cannot_be_read(
    tmp_path: Path, data: bytes | None, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "t.csv"
    if data is not None:
        path.write_bytes(data)
    assert main(["calibrate", str(path), "--robot", "servobot-prey"]) == 3
    assert str(path) in capsys.readouterr().err


def test_every_shipped_robot_can_be_edited() -> None:
    for path in ROBOTS_FOLDER.glob("servobot-*.toml"):
        robot = load_robot(str(path))
        for movement in COMMANDS[robot.role]:
            for key in ("along_units", "right_units", "turn_deg"):
                assert "new" in with_value(robot.text, "f", f"movement.{movement}", key, "1", "new")


def test_a_number_that_is_edited_afterwards_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its comment still speaks of a mean and a spread; so does calibrating once more."""
    table, mine = tmp_path / "walks.csv", tmp_path / "mine.toml"
    table.write_text(MOVES + "FORWARD,4,4.8,0.1,-6\nFORWARD,4,5.0,0,-5\n")
    words = ["calibrate", str(table), "--robot"]
    assert main([*words, "servobot-predator", "-o", str(mine)]) == 0
    assert main(["info", str(mine)]) == 0
    out = capsys.readouterr().out
    assert "edited since" not in out
    line = next(one for one in mine.read_text().splitlines() if "mean of 2" in one)
    mine.write_text(mine.read_text().replace(line, re.sub(r"= -?[\d.]+", "= 9.0", line)))
    assert main(["info", str(mine)]) == 0
    assert "edited since it was calibrated" in capsys.readouterr().out
    again = tmp_path / "again.toml"
    assert main([*words, str(mine), "-o", str(again)]) == 0
    assert "mine.toml: was edited since it was calibrated" in capsys.readouterr().out
    assert main(["info", str(again)]) == 0
    assert "edited since" not in capsys.readouterr().out
