"""Where episodes start."""

import math

import numpy as np
import pytest

from cgagen.errors import RobotError
from sim.model import World
from sim.starts import draw_starts, start_of
from tests.pursuit import other_world, shipped

PREDATOR, PREY, ARENA = shipped()


RADII = (10.6, 10.6)


def philox(seed: int) -> np.random.Generator:
    return np.random.Generator(np.random.Philox(key=seed))


def test_starts_are_inside_apart_and_look_everywhere() -> None:
    starts = draw_starts(philox(1), 3000, 300.0, RADII, 42.4)
    assert starts.shape == (3000, 8)
    places = starts[:, [0, 1, 4, 5]]
    assert places.min() >= 10.6
    assert places.max() <= 289.4
    assert np.abs(places.mean(axis=0) - 150).max() < 6
    gaps = np.hypot(starts[:, 4] - starts[:, 0], starts[:, 5] - starts[:, 1])
    assert gaps.min() >= 42.4
    assert gaps.min() < 50  # the gap is not wider than asked for
    for c, s in ((starts[:, 2], starts[:, 3]), (starts[:, 6], starts[:, 7])):
        assert np.abs(np.hypot(c, s) - 1).max() < 1e-15
        headings = np.degrees(np.arctan2(s, c)) % 360
        quarters = np.histogram(headings, 4, (0, 360))[0]
        assert quarters.min() > 600
        assert np.abs(headings - np.round(headings)).min() > 0  # real-valued, no whole degrees


def test_starts_depend_on_their_generator_alone() -> None:
    world = World(PREDATOR, PREY, ARENA)
    first = world.draw_starts(philox(7), 50)
    assert first.tobytes() == world.draw_starts(philox(7), 50).tobytes()
    assert first[:20].tobytes() == world.draw_starts(philox(7), 20).tobytes()
    assert first.tobytes() != world.draw_starts(philox(8), 50).tobytes()


def test_starts_keep_each_body_within_the_walls() -> None:
    predator, prey, arena = other_world()
    starts = World(predator, prey, arena).draw_starts(philox(3), 2000)
    for columns, radius in (((0, 1), 7.25), ((4, 5), 9.5)):
        places = starts[:, columns]
        assert radius <= places.min() < radius + 1
        assert 231.5 - radius - 1 < places.max() <= 231.5 - radius
    gaps = np.hypot(starts[:, 4] - starts[:, 0], starts[:, 5] - starts[:, 1])
    assert 20 <= gaps.min() < 25


def test_the_start_of_the_papers_figure_7() -> None:
    """Ref: S1 section IV: ten inches from both walls in the SE corner, heading west."""
    start = start_of((268.75, 31.25, 180.0), (15.0, 150.0, 90.0), 300.0, RADII)
    assert start.tolist() == [[268.75, 31.25, -1.0, 0.0, 15.0, 150.0, 0.0, 1.0]]


@pytest.mark.parametrize("edge", [10.6, 289.4])
def test_a_start_may_touch_a_wall(edge: float) -> None:
    assert start_of((edge, edge, 0), (150, edge, 0), 300.0, RADII).shape == (1, 8)


@pytest.mark.parametrize(
    ("predator", "prey", "named"),
    [
        ((10.59, 150, 0), (150, 150, 0), "predator"),
        ((150, 289.41, 0), (150, 150, 0), "predator"),
        ((100, 100, 0), (150, -5, 0), "prey"),
        ((100, 100, 0), (301, 150, 0), "prey"),
        ((math.nan, 100, 0), (150, 150, 0), "predator"),
        ((100, 100, 0), (150, math.inf, 0), "prey"),
        ((100, 100, 0), (100, 100, 90), "both stand on one point"),
    ],
)
def test_a_start_outside_is_refused(
    predator: tuple[float, float, float], prey: tuple[float, float, float], named: str
) -> None:
    with pytest.raises(RobotError, match=named) as refused:
        start_of(predator, prey, 300.0, RADII)
    if "one point" not in named:
        assert "10.6 to 289.4" in str(refused.value)


@pytest.mark.parametrize("heading", [math.nan, math.inf, -math.inf])
def test_a_heading_that_is_no_number_is_refused(heading: float) -> None:
    with pytest.raises(RobotError, match="heading"):
        start_of((100, 100, heading), (200, 200, 0), 300.0, RADII)
