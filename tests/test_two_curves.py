"""Light sensors that differ: each has its own curve, from the robot's file to the chip's answer."""

import pytest
import tomli_w

from cgagen.errors import RobotError
from cgagen.monitor import Decoder
from cgagen.monitor.suspects import LIT_AFTER, SILENT_AFTER, STUCK_AFTER, Suspects
from cgagen.robot import Robot
from cgagen.robot.reader import parse_robot
from cgagen.telemetry import Telemetry
from cgagen.tokenizer import Tokenizer
from hil.boundaries import boundaries
from hil.conduct import try_conduct
from hil.emulated import PinsTarget
from hil.equivalence import Verdict
from hil.lone import Lone
from hil.proof import prove
from hil.simulated import SimulatedTarget
from hil.stimuli import Level, stimuli_of
from hil.subject import Subject, subject_of
from hil.target import Stimulus
from hil.traces.vectors import parse_vectors
from tests.firmware_cases import CASES, PREDATOR, built, robot_of

CASE = "predator-two-curves"
FAR = (26_666,) * 3


def subject() -> Subject:
    return subject_of(built(CASE), CASE)


def test_each_sensor_has_its_own_limits() -> None:
    robot = robot_of(CASE)
    counts = robot.situation_counts
    assert counts.lamp_left == (347, 916, 612, 2587)
    assert counts.lamp_right == (480, 1250, 850, 3500)
    rows = [one for one in boundaries(robot) if "light" in one.sensor]
    assert [one.counts for one in rows] == [347, 916, 612, 2587, 480, 1250, 850, 3500]
    source = built(CASE).programs[0].program.source
    assert "LeftLampNear    CON     347 " in source
    assert "RightLampNear   CON     480 " in source


@pytest.mark.parametrize(
    ("lights", "target"),
    [
        ((346, 0), 3), ((612, 0), 4), ((2586, 0), 4), ((2587, 0), 0),
        ((0, 849), 1), ((0, 850), 2), ((0, 3499), 2), ((0, 3500), 0),
        ((2586, 479), 5), ((2586, 480), 6), ((346, 3499), 5), ((347, 3499), 6),
        ((915, 3499), 6), ((916, 1249), 6), ((916, 1250), 7), ((2587, 1250), 2),
    ],
)  # fmt: skip
def test_the_simulator_takes_each_count_by_its_own_sensor(
    lights: tuple[int, int], target: int
) -> None:
    assert SimulatedTarget(subject()).decide(Stimulus(FAR, lights=lights)).state == target


def test_the_image_is_proven_for_every_reading() -> None:
    proof = prove(subject())
    assert (proof.verdict, proof.proven) == (Verdict.PASS, True)
    assert len(proof.by_state) == 40


def test_a_program_with_one_table_for_both_is_no_longer_right() -> None:
    """The right sensor by the left one's limits, as it was: a difference is found, and shown."""
    one = subject()
    source = one.sources["main"]
    for word in ("Near", "Middle", "Side", "Range"):
        source = source.replace(f" RightLamp{word} THEN", f" LeftLamp{word} THEN")
    image = Tokenizer().compile(source, "main.bsp").image
    proof = prove(Subject(**{**vars(one), "images": {**one.images, "main": image}}))
    assert proof.verdict is Verdict.FAIL
    assert proof.difference is not None
    assert proof.difference.stimulus.lights[1]


def test_through_the_pins_too() -> None:
    one = subject()
    target, oracle = PinsTarget(one), SimulatedTarget(one)
    target.open()
    lit = [s for s in stimuli_of(one.robot, Level.SMOKE) if any(s.lights) and target.admits(s)]
    assert len(lit) > 40
    for stimulus in lit[::3]:
        seen = target.decide(stimulus)
        right = oracle.decide(stimulus)
        assert (seen.state, seen.command) == (right.state, right.command)


def test_a_table_in_inches_is_read_by_each_sensor() -> None:
    head = "t_ms,front_in,right_in,left_in,antenna_left,antenna_right,light_left_in,light_right_in"
    trace = parse_vectors(f"{head}\n0,none,none,none,0,0,20,20\n", "v.csv", robot_of(CASE))
    assert trace.samples[0].stimulus.lights == (347, 480)


def test_one_curve_for_both_is_still_read() -> None:
    """A file of an earlier version has it under [light]."""
    import tomllib

    data = tomllib.loads(PREDATOR)
    left, right = data["light"]["sensor"]
    data["light"]["curve"] = left.pop("curve")
    del right["curve"]
    robot = parse_robot(tomli_w.dumps(data), "old.toml")
    assert robot.situation_counts == robot_of("predator").situation_counts
    del data["light"]["curve"]
    with pytest.raises(RobotError, match=r"\[light.sensor.left\] curve: missing"):
        parse_robot(tomli_w.dumps(data), "old.toml")


# -- A room that is too bright, and sonars that cannot be right --------------------------------


@pytest.mark.parametrize(
    ("lights", "told"), [((0, 0), 0), ((600, 0), 0), ((2586, 3499), 1), ((2587, 9), 0)]
)
def test_a_room_too_bright_is_told_behind_the_banner(lights: tuple[int, int], told: int) -> None:
    lone = Lone(subject())
    lone.show(Stimulus(FAR, lights=lights))
    lone.run(4_000)
    assert lone.player.heard.count("*BRIGHT\r") == told
    if told:
        banner, said, *_ = lone.player.heard.split("\r")
        assert banner.startswith("#1 M")
        assert said == "*BRIGHT"
        [line] = Decoder(robot_of(CASE)).lines(b"*BRIGHT\r")
        assert "too bright for their limits" in line.text


def test_a_robot_that_starts_in_a_bright_room_conducts_itself() -> None:
    trial = try_conduct(subject())
    assert (trial.verdict, trial.reason) == (Verdict.PASS, "")


def notes(robot: Robot, rows: list[tuple[tuple[int, ...], tuple[int, ...]]]) -> list[str]:
    suspects = Suspects(robot)
    found: list[str] = []
    for number, (sonars, lights) in enumerate(rows):
        found += suspects.add(Telemetry(number, sonars, (False, False), lights, 0, 0))
    return found


def test_sonars_that_cannot_be_right_are_told_once() -> None:
    robot = robot_of(CASE)
    silent = [((2_000 + n, 0, 3_000 - n), (0, 0)) for n in range(3 * SILENT_AFTER)]
    assert [one.split(" has")[0] for one in notes(robot, silent)] == ["sonar right"]
    again = [*silent, ((1, 9, 1), (0, 0)), *silent]
    assert len(notes(robot, again)) == 2
    stuck = [((1_133, 2_000 + 7 * n, 3_000), (0, 0)) for n in range(3 * STUCK_AFTER)]
    told = notes(robot, stuck)
    assert [one.split(" has")[0] for one in told] == ["sonar front", "sonar left"]
    assert "counted 1133 12 times" in told[0]
    standing = [((1_133, 2_000, 3_000), (0, 0))] * (3 * STUCK_AFTER)
    assert notes(robot, standing) == []  # nothing moves: the same is no news
    open_field = [((26_666, 26_666, 2_000 + n), (0, 0)) for n in range(3 * STUCK_AFTER)]
    assert notes(robot, open_field) == []  # silence may be equally long each time


def test_light_everywhere_is_told_with_what_it_does() -> None:
    rows = [((2_000 + n, 2_100 - n, 2_200 + n), (300 + n, 3_499)) for n in range(2 * LIT_AFTER)]
    (told,) = notes(robot_of(CASE), rows)
    assert "all sonars are masked" in told
    assert notes(robot_of(CASE), [(sonars, (2_587, 9)) for sonars, _ in rows]) == []
    assert notes(robot_of("prey"), [((9,) * 6, ())] * 40) == []


def test_a_monitor_says_it_behind_the_decision() -> None:
    decoder = Decoder(robot_of("predator"))
    line = ":{} F{} R0 L3000 LL0 LR0 AL1 AR1 S0 C4\r"
    data = "".join(line.format(n, 2_000 + n) for n in range(SILENT_AFTER)).encode()
    *_, last, note = decoder.lines(data)
    assert last.said is not None
    assert note.said is None
    assert note.text.startswith("note: sonar right has given no echo pulse")
    assert note.data["kind"] == "note"


assert CASE in CASES
