"""A locomotion controller that starts: legs one after another, and nothing that looks accepted."""

from collections.abc import Sequence
from functools import cache
from itertools import pairwise

import pytest

from cgagen.bench_protocol import FRAME_LIMIT_MS, GO_MS
from cgagen.build.bench import bench_text
from cgagen.emulator.bench import Bench
from cgagen.emulator.parts.servo import Servo
from cgagen.firmware.timing import legs_start_ms
from hil.emulated import robot_bench
from hil.forced import ForcedSensors
from hil.gait_reader import DEAD_BAND_NS, GaitReader
from hil.lone import MS, Lone
from hil.lone_cases import as_asked, subject
from hil.target import Stimulus
from hil.telemetry import parse_telemetry

ROBOTS = ("predator", "prey")


def far(name: str) -> Stimulus:
    """What a robot in the open sees: the longest echo of every sonar."""
    robot = subject(name).robot
    return Stimulus((23_124,) * len(robot.sonars), lights=(0, 0) if robot.light else ())


# -- Legs rise one after another --------------------------------------------------------------


@pytest.mark.hil_req("FRAMES")
@pytest.mark.parametrize("name", ROBOTS)
def test_no_two_legs_begin_to_turn_within_the_time_that_one_needs(name: str) -> None:
    """All servos stand 40 degrees off before power is on; the angles are looked at each ms."""
    robot = subject(name).robot
    text = bench_text(robot).replace('kind = "servo"', 'kind = "servo"\nangle_deg = 40')
    lone = Lone(subject(name), text)
    servos = list(lone.bench.parts_of(Servo).values())
    began_ms: list[int | None] = [None] * len(servos)
    while lone.booting:
        lone.run(1)
        for index, servo in enumerate(servos):
            if began_ms[index] is None and servo.angle_deg < 40:
                began_ms[index] = lone.now_ns // MS
    legs = [(began_ms[n], began_ms[n + 1]) for n in range(0, len(servos), 2)]
    assert all(abs((swing or 0) - (lift or 0)) < 10 for swing, lift in legs)
    order = [swing or 0 for swing, _ in legs][::-1]
    apart = [then - now for now, then in pairwise(order)]
    needs_ms = robot.servo_set.start_frames * 20
    assert min(apart) >= needs_ms, order
    assert needs_ms >= 40 * 0.2e3 / 60  # 60 degrees in 0.2 s
    assert all(abs(servo.angle_deg) < 0.5 for servo in servos)
    seen = [servo.pulses for servo in servos]
    assert all(one.odd == one.limp == 0 for one in seen)
    assert max(one.longest_period_ns for one in seen) <= FRAME_LIMIT_MS * MS
    assert min(one.shortest_period_ns for one in seen) > 18 * MS


@pytest.mark.hil_req("GO")
@pytest.mark.parametrize("name", ROBOTS)
def test_both_chips_switched_on_at_one_time_begin_without_a_refusal(name: str) -> None:
    lone = Lone(subject(name), mute=True)
    lone.stand()
    ready_ms = lone.now_ns / MS
    assert 0.7 * legs_start_ms(subject(name).robot) < ready_ms < legs_start_ms(subject(name).robot)
    lone = Lone(subject(name))
    lone.show(far(name))
    as_asked(lone.walk(2))
    assert "*" not in lone.player.heard
    assert lone.uncommanded == []


# -- A reset in a step ------------------------------------------------------------------------


class Step:
    """A robot at its second step, which can be had again and again.

    Attributes:
        bench: its own.
        go_ns: when its main controller begins to say GO.
        said: what that has said since.
        gait: its servos.
        command: what is asked.
    """

    def __init__(self, name: str) -> None:
        self._switch_on(name)
        falls: list[int] = []
        clock = self.bench.clock
        self.bench.wire("step").listen(
            lambda level: falls.append(clock.now_ns) if level == 0 else None
        )
        while len(falls) < 2:
            self.bench.run(clock.now_ns + 20 * MS)
        self.go_ns = falls[1]
        self._switch_on(name)
        self.bench.run(self.go_ns - BEFORE_NS)
        self._moment = self.bench.snapshot()
        self.gait.rest = self.gait.take().whole_frames()[-1]
        told = parse_telemetry(self.said, subject(name).robot.role)
        assert told is not None
        self.command = told.command

    def _switch_on(self, name: str) -> None:
        one = subject(name)
        self.bench: Bench = robot_bench(one.robot, one.images)
        self.gait, self.said = GaitReader(one.robot, self.bench), ""
        ForcedSensors(one.robot, self.bench).show(far(name))
        self.bench.host("main").heard = self._heard

    def reset(self, chip: str, at_ms: float, more_ms: int) -> None:
        """Go back, reset a chip so long behind the beginning of GO, and go on from there."""
        self.bench.restore(self._moment)
        self.said = ""
        self.gait.take()
        self.bench.run(self.go_ns + round(at_ms * MS))
        self.bench.reset(chip, 2 * MS)
        self.bench.run(self.bench.clock.now_ns + more_ms * MS)

    def _heard(self, byte: int) -> None:
        self.said += chr(byte)


BEFORE_NS = 40 * MS


@cache
def step(name: str) -> Step:
    return Step(name)


@pytest.mark.hil_req("RESET")
@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("tenths_ms", [-300, -50, *range(0, 1_100, 7)])
def test_a_locomotion_controller_that_starts_in_go_has_not_accepted(
    name: str, tenths_ms: int
) -> None:
    """Swept over the whole of GO; before it, and from there up to the acceptance, too."""
    one = step(name)
    one.reset("locomotion", tenths_ms / 10, 500)
    before, colon, behind = one.said.partition(":")
    assert colon, one.said
    assert "*REFUSED" in before or "\r*CUT\r" in behind, one.said
    if tenths_ms < GO_MS * 10 - 5:
        assert "*REFUSED" in before, one.said  # before the step is told, and not behind it


@pytest.mark.hil_req("RESET")
@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("at_ms", range(105, 450, 15))
def test_a_step_that_a_reset_cuts_short_is_told(name: str, at_ms: int) -> None:
    """The legs stand sooner than any movement is over; what is cut later is told by nobody."""
    one = step(name)
    one.reset("locomotion", at_ms, 300)
    before, _, behind = one.said.partition(":")
    assert "*" not in before
    assert behind.count("*CUT\r") == 1, one.said


@pytest.mark.hil_req("RESET")
@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("tenths_ms", range(-30, 1_010, 9))
def test_a_main_controller_that_starts_in_go_moves_nothing_else(name: str, tenths_ms: int) -> None:
    """Its lines let go and read 000, which is FORWARD: nothing is walked, or what was asked."""
    one = step(name)
    one.reset("main", tenths_ms / 10, 1_700)
    # The first pulse of each servo may have begun before what was gone back to.
    made = [_poses([pulse.width_ns for pulse in row[1:]]) for row in one.gait.take().pulses]
    still = [_poses([width_ns]) for width_ns in one.gait.rest]
    asked = [_poses(row) for row in zip(*one.gait.wanted(one.command), strict=True)]
    assert made in (still, asked)


def _poses(widths_ns: Sequence[int]) -> list[int]:
    """Return a servo's positions in their order, in steps of what it does not see."""
    steps = [round(one / DEAD_BAND_NS) for one in widths_ns]
    return [one for n, one in enumerate(steps) if n == 0 or one != steps[n - 1]]
