"""The step line between both Stamps, and their resets and brown-outs."""

from functools import cache

import pytest

from hil.lone import MS, OFF_NS, WORD, Lone
from hil.lone_cases import SEEN_MS, as_asked, subject
from hil.target import Stimulus


def far(name: str) -> Stimulus:
    """What a robot in the open sees: the longest echo of every sonar."""
    robot = subject(name).robot
    return Stimulus((23_124,) * len(robot.sonars), lights=(0, 0) if robot.light else ())


# -- The wire between both Stamps -------------------------------------------------------------


@pytest.mark.hil_req("GO")
@pytest.mark.parametrize("phase_ms", range(0, 26, 2))
def test_a_go_at_any_phase_of_a_frame_is_one_movement_and_the_one_asked(phase_ms: int) -> None:
    lone = Lone(subject("predator"), mute=True)
    lone.stand()
    lone.run(SEEN_MS + phase_ms)
    command = 1 + phase_ms // 2 % 7
    lone.go(command)
    assert as_asked(lone.walk()).asked == command
    lone.run(200)
    assert len(lone.walks) == 1
    assert lone.uncommanded == []


@pytest.mark.hil_req("GO")
@pytest.mark.parametrize("hold_ms", [0.02, 0.1, 0.5, 1, 2, 5, 10, 15, 20, 24, 26, 30, 50, 400])
def test_a_go_of_any_length_is_taken_whole_or_not_at_all(hold_ms: float) -> None:
    """The legs look once in a frame of 24 ms: a shorter GO may be missed, never misread."""
    lone = Lone(subject("predator"), mute=True)
    lone.stand()
    lone.run(31)
    lone.go(5, hold_ms)
    walk = lone.walk(limit_ms=2_000)
    if hold_ms >= 26:
        assert walk is not None
    if walk is not None:
        assert as_asked(walk).asked == 5
    lone.run(100)
    assert len(lone.walks) <= 1
    assert lone.uncommanded == []
    assert lone.words["locomotion"].count("*LINES") == 0


@pytest.mark.hil_req("GO")
@pytest.mark.parametrize("early_ms", [0, 5, 10, 15, 20, 24])
def test_a_go_before_the_legs_have_seen_the_line_high_is_left_alone(early_ms: int) -> None:
    """No main controller senses in so short a time; if one did, it would hear a refusal."""
    lone = Lone(subject("predator"), mute=True)
    lone.stand()
    lone.run(early_ms)
    lone.go(6)
    lone.run(100)
    assert lone.line.level == 1 or lone.referee.walks(WORD)
    walk = lone.walk(limit_ms=1_500)
    if walk is not None:
        assert as_asked(walk).asked == 6
    assert lone.uncommanded == []


@pytest.mark.hil_req("GO")
def test_without_go_nothing_moves_whatever_the_lines_say() -> None:
    lone = Lone(subject("predator"), mute=True)
    lone.stand()
    for command in (1, 7, 2, 5, 0):
        for bit in range(3):
            lone.bench.wire(f"{WORD}_command_{bit}").drive("tester", command >> bit & 1)
        lone.run(90)
    assert lone.walks == []
    lone.go(3)
    assert as_asked(lone.walk()).asked == 3
    assert lone.uncommanded == []


@pytest.mark.hil_req("GO")
@pytest.mark.parametrize("late_ms", [0, 3, 7, 11, 16, 22, 600, 1_300])
def test_both_chips_may_be_switched_on_at_different_times(late_ms: int) -> None:
    """Either chip comes late: the first movement and the second are the ones decided."""
    for late in ("main", "locomotion"):
        lone = Lone(subject("predator"))
        lone.show(far("predator"))
        lone.reset(late, late_ms * MS)
        for _ in range(2):
            walk = as_asked(lone.walk())
            lone.run(30)
            assert lone.player.said is not None
            assert lone.player.said.command == walk.asked
        assert lone.uncommanded == []


@pytest.mark.hil_req("GO")
def test_a_go_that_nobody_takes_is_reported_and_said_again() -> None:
    """A locomotion controller that is off drives nothing: the line rises after GO."""
    lone = Lone(subject("predator"))
    lone.show(far("predator"))
    lone.reset("locomotion", OFF_NS)
    lone.run(4_000)
    assert lone.walks == []
    assert lone.player.heard.count("*REFUSED") >= 2
    lone.reset("locomotion")
    as_asked(lone.walk())
    assert lone.uncommanded == []


@pytest.mark.hil_req("GO")
def test_legs_that_never_stand_are_reported() -> None:
    """The step line is shorted to ground: nobody moves, both chips say so."""
    lone = Lone(subject("predator"))
    lone.show(far("predator"))
    lone.line.drive("short", 0)
    lone.run(9_000)
    assert lone.walks == []
    assert "*BUSY" in lone.player.heard
    assert "*LOW" in lone.words["locomotion"]


# -- Resets and brown-outs --------------------------------------------------------------------


def walking(at_ms: float) -> Lone:
    """A predator so long after it accepted its first movement."""
    lone = Lone(subject("predator"))
    lone.show(far("predator"))
    lone.bench.run(first_accepted_ns() + round(at_ms * MS))
    return lone


@cache
def first_accepted_ns() -> int:
    lone = Lone(subject("predator"))
    lone.show(far("predator"))
    return as_asked(lone.walk()).accepted_ns


TIMES_MS = (-900, -200, -40, -10, 2, 60, 130, 400, 900, 1_215, 1_230, 1_300)
"""From boot over sensing, GO and the movement to the next sensing."""


@pytest.mark.hil_req("RESET")
@pytest.mark.parametrize("at_ms", TIMES_MS)
def test_a_reset_of_the_main_controller_moves_nothing(at_ms: float) -> None:
    """The movement under way is finished, and the next one is told."""
    lone = walking(at_ms)
    lone.reset("main")
    for _ in range(2):
        as_asked(lone.walk())
    assert lone.uncommanded == []


@pytest.mark.hil_req("RESET")
@pytest.mark.parametrize("at_ms", TIMES_MS)
def test_a_reset_of_the_locomotion_controller_centres_the_legs_and_no_more(at_ms: float) -> None:
    lone = walking(at_ms)
    before = len(lone.walks)
    lone.reset("locomotion", 5 * MS)
    cut = lone.walks[before:]  # a movement that was under way ends with the reset
    while lone.booting:
        lone.run(1)
    stand = round(subject("predator").robot.servo_set.centre_counts * 2_000 / MS, 1)
    centred = [round(one / MS, 1) for one in lone.player.gait.rest]
    assert centred == [stand] * 12
    as_asked(lone.walk())
    as_asked(lone.walk())
    assert all(walk.made.command in (None, walk.asked) for walk in cut)  # all of it, or no other
    assert lone.uncommanded == []


@pytest.mark.hil_req("RESET")
@pytest.mark.parametrize("at_ms", TIMES_MS)
def test_a_brown_out_of_both_is_a_power_up(at_ms: float) -> None:
    lone = walking(at_ms)
    for chip in ("main", "locomotion"):
        lone.reset(chip, 200 * MS)
    before = len(lone.walks)
    as_asked(lone.walk(2))
    assert [walk.made.command for walk in lone.walks[before:]] == [
        walk.asked for walk in lone.walks[before:]
    ]
    assert lone.uncommanded == []


@pytest.mark.hil_req("RESET")
@pytest.mark.parametrize(
    "at_ms", [-3, -2, -1.5, -1, -0.5, -0.1, 0, 0.3, 0.6, 0.9, 1.2, 1.6, 2, 3, 50, 99]
)
def test_a_reset_of_the_main_controller_in_the_middle_of_go(at_ms: float) -> None:
    """Its lines let go and read 000, which is FORWARD; but the step line lets go with them, and
    GO has to outlast the reading of the command.
    """
    lone = walking(at_ms)
    lone.reset("main")
    walk = lone.walk()
    assert walk is not None
    assert walk.made.command == 4
    as_asked(lone.walk())
