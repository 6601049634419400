"""Our own sine and cosine against the library's."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.trig import cos_sin_deg

EXACT = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))


def reduced(angle_deg: float) -> tuple[float, float]:
    """Return the library's cosine and sine, from an angle that is small enough to be exact."""
    quarters = round(angle_deg / 90)
    rest = math.radians(angle_deg - 90 * quarters)
    c, s = math.cos(rest), math.sin(rest)
    return ((c, s), (-s, c), (-c, -s), (s, -c))[quarters % 4]


@pytest.mark.parametrize("turn", range(-8, 9))
def test_multiples_of_90_are_exact(turn: int) -> None:
    assert cos_sin_deg(90.0 * turn) == EXACT[turn % 4]


def test_all_tenths_of_a_degree_agree_with_the_library() -> None:
    worst = max(
        abs(ours - theirs)
        for angle in np.linspace(-360, 360, 7201).tolist()
        for ours, theirs in zip(cos_sin_deg(angle), reduced(angle), strict=True)
    )
    assert worst <= 1e-15


@given(st.floats(-360, 360))
def test_any_angle_agrees_with_the_library(angle: float) -> None:
    c, s = cos_sin_deg(angle)
    assert abs(c - math.cos(math.radians(angle))) <= 2e-15
    assert abs(s - math.sin(math.radians(angle))) <= 2e-15
    assert abs(c - reduced(angle)[0]) <= 1e-15
    assert abs(s - reduced(angle)[1]) <= 1e-15
    assert abs(c * c + s * s - 1.0) <= 1e-15


@given(st.floats(-360, 360))
def test_opposite_angles_mirror(angle: float) -> None:
    c, s = cos_sin_deg(angle)
    mirrored_c, mirrored_s = cos_sin_deg(-angle)
    assert (c, s) == (mirrored_c, -mirrored_s)
