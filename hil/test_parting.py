"""Without a referee both robots still hunt; they are only no longer in step."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cgagen.robot import load_arena
from hil.hunt import fixed_starts
from hil.parting import part
from hil.subject import Subject, read_subject
from sim.numbers import WorldNumbers, world_numbers

FIRMWARE = Path(__file__).parents[1] / "firmware"
QUICK = 56
"""The fixed start with the quickest capture."""


def world() -> tuple[Subject, Subject, WorldNumbers, NDArray[np.float64]]:
    predator, prey = (read_subject(FIRMWARE / name) for name in ("predator", "prey"))
    arena = load_arena("colony")
    numbers = world_numbers(predator.robot, prey.robot, arena)
    start = fixed_starts(predator, prey, numbers, arena.start_gap_units, 100)[QUICK : QUICK + 1]
    return predator, prey, numbers, start


def test_a_hunt_without_referee_is_a_hunt_of_its_own() -> None:
    result = part(*world(), steps=60)
    assert result.trouble == ""
    assert result.simulated_at == 10
    assert result.captured_at is not None
    assert result.decided_alike >= 1  # both begin at the same poses
    assert result.prey_steps >= 1


def test_without_capture_it_ends_with_the_steps() -> None:
    result = part(*world(), steps=2)
    assert (result.captured_at, result.simulated_at) == (None, None)
    assert result.decided_alike <= 2
