"""The target behind a rig: what is not admitted because a timer may err."""

import random

import pytest

from hil import can_session
from hil.equivalence import Verdict, compare
from hil.guard import beside, is_clear
from hil.messages import Report
from hil.simulated import states_of
from hil.stimuli import (
    Level,
    around,
    light_limits,
    sonar_limits,
    stimuli_of,
    thresholds,
    with_values,
)
from hil.target import Stimulus
from hil.verify import try_target
from tests.predator_rig import PREDATOR, spoilt, spoilt_identity, target
from tests.rig_cases import Target, nothing
from tests.subjects import subject


def test_a_rig_that_is_exact_is_given_everything_that_goes_through_pins() -> None:
    robot = subject(PREDATOR).robot
    every = stimuli_of(robot, Level.BOUNDARY)
    left = [one for one in every if not is_clear(robot, one, 0)]
    assert {max((*one.sonars, *one.lights)) for one in left} == {65_535}


@pytest.mark.parametrize("role", ["predator", "prey"])
def test_what_is_admitted_decides_alike_however_the_timers_err(role: str) -> None:
    robot, guard, chance = subject(role).robot, 3, random.Random(4)
    limits = [*sonar_limits(robot), *light_limits(robot)]
    sonars = len(robot.sonars)

    def some(rows: tuple[int, ...]) -> int:
        return chance.choice(
            [0, chance.randrange(30_000), *(n + chance.randint(-9, 9) for n in rows)]
        )

    def off(one: int) -> int:
        return max(one + chance.choice((-guard, guard, chance.randint(-guard, guard))), 1)

    clear, presented = [], []
    for _ in range(4_000):
        counts = [max(some(rows), 0) for rows in limits]
        touched = (chance.random() < 0.3, chance.random() < 0.3)
        one = Stimulus(tuple(counts[:sonars]), touched, tuple(counts[sonars:]))
        if is_clear(robot, one, guard):
            wrong = [off(count) if count else 0 for count in counts]
            clear.append(one)
            presented.append(Stimulus(tuple(wrong[:sonars]), touched, tuple(wrong[sonars:])))
    assert 400 < len(clear) < 4_000
    assert states_of(robot, presented).tolist() == states_of(robot, clear).tolist()


def test_the_band_ends_where_it_says() -> None:
    robot = subject(PREDATOR).robot
    limit = sonar_limits(robot)[0][0]

    def clear(count: int) -> bool:
        return is_clear(robot, Stimulus((count, 0, 0), lights=(0, 0)), 2)

    inside = [count for count in range(limit - 9, limit + 9) if not clear(count)]
    assert inside == [limit - 2, limit - 1, limit, limit + 1]


@pytest.mark.parametrize("role", ["predator", "prey"])
def test_the_nearest_on_both_sides_of_a_threshold_are_tried_instead(role: str) -> None:
    robot = subject(role).robot
    readings = beside(robot, 2)
    assert all(is_clear(robot, one, 2) and not is_clear(robot, one, 3) for one in readings)
    limits = [*sonar_limits(robot), *light_limits(robot)]
    states = dict(zip(readings, states_of(robot, readings).tolist(), strict=True))
    for index, row in enumerate(limits):
        for limit in row:
            pairs = [
                (state, states.get(with_values(one, {index: limit + 2})))
                for one, state in states.items()
                if (*one.sonars, *one.lights)[index] == limit - 3
            ]
            assert any(above not in (None, below) for below, above in pairs), (index, limit)


@pytest.mark.parametrize("role", ["predator", "prey"])
@pytest.mark.parametrize("guard", [400, 1_000, 2_586, 2_587])
def test_a_wide_band_leaves_less_and_nothing_that_cannot_be(role: str, guard: int) -> None:
    robot = subject(role).robot
    readings = beside(robot, guard)
    assert all(min(*one.sonars, *one.lights) >= 0 for one in readings)
    assert readings or guard > 1_000
    assert all(is_clear(robot, one, guard) for one in readings)


def test_an_echo_that_may_vanish_is_not_clear() -> None:
    """A rig that is off by two counts may present none of one: no echo at all."""
    robot, plain = subject(PREDATOR).robot, nothing(PREDATOR)
    clear = [is_clear(robot, with_values(plain, {0: count}), 2) for count in range(5)]
    assert clear == [True, False, False, True, True]


def test_what_is_too_near_is_left_out_and_counted() -> None:
    one = subject(PREDATOR)
    near = [stimulus for stimulus in thresholds(one.robot) if not is_clear(one.robot, stimulus, 2)]
    with spoilt(lambda one: [one]) as bus:
        guarded = Target(f"{bus.url}?guard=2", one)
        with guarded:
            trial = compare(one, guarded, [nothing(PREDATOR), *near])
        only = try_target(one, lambda: Target(f"{bus.url}?guard=2", one), near)
        wide = try_target(one, lambda: Target(f"{bus.url}?guard=2", one), near, widened=True)
        exact = try_target(one, lambda: Target(bus.url, one), near[:1], widened=True)
    assert (trial.verdict, trial.decisions, trial.left_out) == (Verdict.PASS, 1, len(near))
    assert "readings within 2 counts of a threshold" in trial.note
    assert len(near) >= len(around(sonar_limits(one.robot)[0]))
    assert only.verdict is Verdict.UNPROVEN
    assert (wide.verdict, wide.decisions) == (Verdict.PASS, len(beside(one.robot, 2)))
    assert exact.decisions == 1


@pytest.mark.parametrize(("jitter", "guard"), [(0, 0), (1, 1), (15, 1), (16, 2), (255, 17)])
def test_a_rig_that_says_how_far_it_is_off_is_believed(jitter: int, guard: int) -> None:
    with spoilt_identity(JITTER=jitter) as bus:
        with target(bus) as one:
            assert one.guard_counts == guard
        with Target(f"{bus.url}?guard=1", subject(PREDATOR)) as told:
            assert told.guard_counts == 1


def test_reports_have_words() -> None:
    quiet = {Report.NONE, Report.INCOMPLETE, Report.OLD_SEQ, Report.NO_DECISION}
    quiet |= {Report.FAULT_FIRED, Report.FAULT_SILENT}
    assert set(can_session.REFUSALS) == set(Report) - quiet
