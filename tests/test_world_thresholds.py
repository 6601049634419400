"""The compiled world at its thresholds: against the oracle's answers, and worked by hand."""

import numpy as np
import oracle as by_angles
import pytest

from cgagen.robot import SituationCounts
from cgagen.words import COMMANDS, Role
from sim.numbers import world_numbers
from sim.world import PreyReading, Reading, answer_of_reading, state_of_reading
from tests.pursuit import oracle_of, other_world, shipped

PREDATOR, PREY, _ARENA = shipped()


NUMBERS = world_numbers(PREDATOR, PREY, _ARENA)
LIMITS = NUMBERS.predator.limits
TWIN = oracle_of(PREDATOR, PREY, _ARENA)
SONAR_EDGES = [
    count + shift
    for count in (*TWIN.limits[:5], by_angles.threshold_counts(36, PREY))
    for shift in (-1, 0, 1)
]


SONAR_COUNTS = [0, 1, 153, 12_345, 24_666, 65_534, 65_535, *SONAR_EDGES]
LIGHT_COUNTS = [0, 1, 2, 60_000, 65_535] + [
    count + shift for counts in TWIN.limits[5:] for count in counts for shift in (-1, 0, 1)
]


def world_state(reading: tuple[int, ...], masking: bool = True) -> int:
    front, right, left, touch_left, touch_right, light_left, light_right = reading
    touched = bool(touch_left), bool(touch_right)
    seen = Reading(front, right, left, *touched, light_left, light_right)
    return int(state_of_reading(seen, masking, LIMITS))


def world_answer(reading: tuple[int, ...]) -> int:
    a, b, c, d, e, f, touch_left, touch_right = reading
    seen = PreyReading(a, b, c, d, e, f, bool(touch_left), bool(touch_right))
    return int(answer_of_reading(seen, NUMBERS.prey.reflex))


def oracle_answer(reading: tuple[int, ...]) -> int:
    movement = by_angles.answer_of(reading, PREY, "turn")
    return COMMANDS[Role.PREY].index(movement)


def flat(limits: SituationCounts) -> tuple[object, ...]:
    """Return a world's thresholds as the oracle has them: the lamp's by limit, not by sensor."""
    *sonars, left, right = limits
    return (*sonars, *zip(left, right, strict=True))


def test_both_have_the_same_thresholds() -> None:
    assert flat(LIMITS) == tuple(TWIN.limits)
    assert NUMBERS.prey.reflex.alarm == by_angles.threshold_counts(36, PREY)
    other = other_world()
    assert flat(world_numbers(*other).predator.limits) == tuple(oracle_of(*other).limits)


@pytest.mark.parametrize("masking", [True, False])
def test_states_of_20_000_readings_with_many_ties(masking: bool) -> None:
    rng = np.random.default_rng(3)
    states = set()
    sonars = rng.choice(SONAR_COUNTS, (20_000, 3))
    copied = rng.random((20_000, 3)) < 0.3
    sonars = np.where(copied, sonars[:, [1, 2, 0]], sonars)
    touches = rng.random((20_000, 2)) < 0.15
    lights = rng.choice(LIGHT_COUNTS, (20_000, 2)) * (rng.random((20_000, 2)) < 0.6)
    for reading in np.column_stack((sonars, touches, lights)).astype(int).tolist():
        state = by_angles.state_of(tuple(reading), masking, TWIN.limits)
        assert world_state(tuple(reading), masking) == state, reading
        states.add(state)
    # Masked sonars report nothing: of a target ahead, only the antennas know more.
    assert len(states) == (40 if masking else 64)


def test_answers_to_20_000_readings_with_many_ties() -> None:
    rng = np.random.default_rng(4)
    answers = set()
    sonars = rng.choice(SONAR_COUNTS, (20_000, 6))
    copied = rng.random((20_000, 6)) < 0.4
    sonars = np.where(copied, sonars[:, [3, 0, 5, 2, 1, 4]], sonars)
    touches = rng.random((20_000, 2)) < 0.2
    for reading in np.column_stack((sonars, touches)).astype(int).tolist():
        answer = oracle_answer(tuple(reading))
        assert world_answer(tuple(reading)) == answer, reading
        answers.add(answer)
    assert answers == set(range(8))


FAR = by_angles.FARTHEST


@pytest.mark.parametrize("masked", [(), ("light_left",), ("light_right",), ("both",)])
@pytest.mark.parametrize("column", [0, 1, 2])
@pytest.mark.parametrize("count", [0, FAR, FAR - 1, *SONAR_EDGES])
def test_every_sonar_threshold_alone(column: int, count: int, masked: tuple[str, ...]) -> None:
    reading = [0, 0, 0, 0, 0, 0, 0]
    reading[column] = count
    reading[5] = 900 * ("light_left" in masked or "both" in masked)
    reading[6] = 900 * ("light_right" in masked or "both" in masked)
    state = by_angles.state_of(tuple(reading), True, TWIN.limits)
    assert world_state(tuple(reading)) == state


@pytest.mark.parametrize(
    ("reading", "situation"),
    [
        ((0, 0, 0), 0),
        ((FAR, FAR, FAR), 0),
        ((0, 0, 5000), 4),  # no echo is farther than everything
        ((0, 5000, 0), 2),
        ((5000, 0, 0), 7),
        ((1965, 1965, 1965), 5),  # a tie: front, right, left
        ((1966, 1966, 1966), 6),  # near means nearer than
        ((4325, 9999, 9999), 6),
        ((4326, 9999, 9999), 7),
        ((7078, 9999, 9999), 7),
        ((7079, 9999, 9999), 0),
        ((9999, 1965, 1965), 1),
        ((9999, 1966, 1966), 2),
        ((9999, 1966, 1965), 3),
        ((9999, 9999, 7078), 4),
        ((9999, 9999, 7079), 0),
        ((2000, 1999, 5000), 2),  # the nearest alone decides
    ],
)
def test_obstacles_worked_by_hand(reading: tuple[int, int, int], situation: int) -> None:
    for touches, wanted in (((0, 0), situation), ((1, 1), 5), ((1, 0), 3), ((0, 1), 1)):
        assert world_state((*reading, *touches, 0, 0)) == 8 * wanted


@pytest.mark.parametrize(
    ("left", "right", "situation"),
    [
        (0, 0, 0),
        (1, 0, 3),
        (611, 0, 3),
        (612, 0, 4),
        (2586, 0, 4),
        (2587, 0, 0),
        (0, 611, 1),
        (0, 612, 2),
        (0, 2586, 2),
        (0, 2587, 0),
        (346, 2586, 5),
        (2586, 346, 5),
        (347, 347, 6),
        (915, 2000, 6),
        (916, 916, 7),
        (2586, 2586, 7),
        (2587, 2586, 2),
        (1, 2587, 3),
    ],
)
def test_targets_worked_by_hand(left: int, right: int, situation: int) -> None:
    assert world_state((0, 0, 0, 0, 0, left, right)) == situation


def test_masking_worked_by_hand() -> None:
    near = (100, 200, 300, 0, 0)
    assert world_state((*near, 900, 900)) == 8 * 0 + 6  # all three sonars face the target
    assert world_state((*near, 0, 900)) == 8 * 3 + 2  # the left one is left
    assert world_state((*near, 900, 0)) == 8 * 1 + 4
    assert world_state((*near, 0, 0)) == 8 * 5
    assert world_state((*near, 0, 900), masking=False) == 8 * 5 + 2
    assert world_state((100, 200, 300, 1, 1, 900, 900)) == 8 * 5 + 6  # antennas stay


@pytest.mark.parametrize(
    ("sonars", "answer"),
    [
        ((0, 0, 0, 0, 0, 0), "WAIT"),
        ((7078, 9999, 9999, 9999, 9999, 9999), "ROTATE_RIGHT"),
        ((7079, 7079, 7079, 7079, 7079, 7079), "WAIT"),
        ((5000, 5000, 5000, 5000, 5000, 5000), "ROTATE_RIGHT"),
        ((5001, 5000, 5000, 5000, 5000, 5000), "ROTATE_LEFT"),
        ((5001, 5001, 5000, 5000, 5000, 5000), "RIGHT_FORWARD"),
        ((0, 0, 5001, 5000, 5000, 5000), "LEFT_FORWARD"),
        ((0, 0, 0, 0, 5000, 5000), "FORWARD"),
        ((0, 0, 0, 0, 0, 5000), "FORWARD"),
    ],
)
def test_the_prey_worked_by_hand(sonars: tuple[int, ...], answer: str) -> None:
    commands = [str(movement) for movement in COMMANDS[Role.PREY]]
    assert commands[world_answer((*sonars, 0, 0))] == answer
    assert commands[world_answer((*sonars, 1, 0))] == "BACKUP_LEFT"
    assert commands[world_answer((*sonars, 0, 1))] == "BACKUP_RIGHT"


@pytest.mark.parametrize(
    ("left", "right", "answer"),
    [(10, 9, "BACKUP_RIGHT"), (9, 9, "BACKUP_LEFT"), (9, 10, "BACKUP_LEFT"),
     (0, 9, "BACKUP_RIGHT"), (9, 0, "BACKUP_LEFT"), (0, 0, "BACKUP_LEFT")],
)  # fmt: skip
def test_both_antennas_of_the_prey(left: int, right: int, answer: str) -> None:
    commands = [str(movement) for movement in COMMANDS[Role.PREY]]
    assert commands[world_answer((1, 1, left, right, 1, 1, 1, 1))] == answer
