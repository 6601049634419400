"""From distance to counts: laws of the two functions."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cgagen.counts import FARTHEST_COUNT, echo_count, light_count, light_curve
from cgagen.robot import SONAR_KINDS, load_robot
from tests.oracle import echo_counts, light_counts, threshold_counts
from tests.pursuit import other_world, shipped

PREDATOR, PREY, ARENA = shipped()
PER_IN = PREDATOR.echo_counts_per_in
FEWEST, MOST = PREDATOR.echo_limits_counts(PREDATOR.sonars[0])
LIGHT = PREDATOR.light
assert LIGHT is not None
MARKS = list(LIGHT.sensors[0].curve)
INCHES = st.floats(0, 300)


def test_the_worked_numbers_of_a_ping() -> None:
    assert PER_IN == pytest.approx(196.656)
    assert (FEWEST, MOST) == pytest.approx((153.3333, 24_666.6667))
    assert echo_count(10.0, PER_IN, FEWEST, MOST) == 1966
    assert echo_count(0.0, PER_IN, FEWEST, MOST) == echo_count(-3.0, PER_IN, FEWEST, MOST) == 153
    assert echo_count(125.5, PER_IN, FEWEST, MOST) == echo_count(1e9, PER_IN, FEWEST, MOST) == 24666


def test_an_srf04_hears_other_limits() -> None:
    sonar = other_world()[0].sonars[0]
    assert sonar.kind == "srf04"
    assert other_world()[0].echo_limits_counts(sonar) == (87.0, 18_000.0)
    assert SONAR_KINDS["srf04"].pins == ("trigger_pin", "echo_pin")


@given(INCHES, INCHES)
def test_farther_is_never_a_smaller_echo(one: float, other: float) -> None:
    near, far = sorted((one, other))
    assert echo_count(near, PER_IN, FEWEST, MOST) <= echo_count(far, PER_IN, FEWEST, MOST)


@given(INCHES)
def test_an_echo_is_the_oracle_s(inches: float) -> None:
    ours = echo_count(inches, PER_IN, FEWEST, MOST)
    assert 153 <= ours <= 24_666
    kind = SONAR_KINDS["ping"]
    near_by = {
        echo_counts(inches + shift, PREDATOR, kind.shortest_us, kind.longest_us)
        for shift in (-1e-9, 0, 1e-9)
    }
    assert ours in near_by


@pytest.mark.parametrize("robot", [*shipped()[:2], *other_world()[:2]], ids=lambda r: r.digest[:4])
@pytest.mark.parametrize("inches", [0.5, 5, 7.3, 10, 22, 27.7, 36, 48, 60, 100, 300])
def test_a_threshold_is_the_reading_at_that_distance(robot, inches: float) -> None:  # type: ignore[no-untyped-def]
    count = robot.echo_count_of(inches)
    assert count == threshold_counts(inches, robot)
    sonar = robot.sonars[0]
    fewest, most = robot.echo_limits_counts(sonar)
    if fewest < count < most:
        assert echo_count(inches, robot.echo_counts_per_in, fewest, most) == count
    # In the arena's units, an inch nearer is nearer and an inch farther is not.
    per_unit = robot.echo_counts_per_in / ARENA.units_per_in
    assert echo_count((inches - 0.1) * ARENA.units_per_in, per_unit, 0.0, 1e9) < count
    assert echo_count((inches + 0.1) * ARENA.units_per_in, per_unit, 0.0, 1e9) > count or (
        count == FARTHEST_COUNT
    )


@pytest.mark.parametrize(("inches", "count"), MARKS)
@pytest.mark.parametrize("scale", [1.0, 3.125, 2.6, 0.32])
def test_a_marked_distance_gives_its_own_count(inches: float, count: int, scale: float) -> None:
    assert light_count(inches * scale, light_curve(MARKS, scale)) == count


@given(INCHES, INCHES)
def test_farther_is_never_a_smaller_light_count(one: float, other: float) -> None:
    near, far = sorted((one, other))
    curve = PREDATOR.light_curve(1)
    assert light_count(near, curve) <= light_count(far, curve)


@given(st.floats(0, 1000), st.sampled_from([1.0, 3.125, 2.6]))
def test_a_light_count_is_the_oracle_s(distance: float, scale: float) -> None:
    curve = light_curve(MARKS, scale)
    near_by = {
        light_counts((distance + shift) / scale, tuple(MARKS)) for shift in (-1e-8, 0.0, 1e-8)
    }
    assert light_count(distance, curve) in near_by


RISING = st.lists(
    st.tuples(st.integers(1, 300), st.integers(1, 65_535)), min_size=2, max_size=9
).map(
    lambda rows: list(
        zip(sorted({row[0] for row in rows}), sorted({row[1] for row in rows}), strict=False)
    )
)


@given(RISING.filter(lambda rows: len(rows) >= 2), st.floats(0, 400))
def test_any_curve_is_flat_outside_and_straight_between(
    rows: list[tuple[float, int]], distance: float
) -> None:
    rows = [(float(inches), count) for inches, count in rows]
    curve = light_curve(rows, 1.0)
    count = light_count(distance, curve)
    assert rows[0][1] <= count <= rows[-1][1]
    near_by = {light_counts(distance + shift, tuple(rows)) for shift in (-1e-9, 0.0, 1e-9)}
    assert count in near_by
    for inches, marked in rows:
        assert light_count(inches, curve) == marked


def test_thresholds_beyond_what_a_chip_counts_end_there() -> None:
    robot = load_robot("servobot-predator")
    assert robot.echo_count_of(300) == math.floor(300 * PER_IN) == 58_996
    assert robot.echo_count_of(3000) == FARTHEST_COUNT == 65_535
