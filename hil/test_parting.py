"""Without a referee both robots still hunt; they are only no longer in step."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from cgagen.errors import RigError
from cgagen.robot import load_arena
from cgagen.tokenizer import Tokenizer
from hil.colony import Colony
from hil.equivalence import Verdict
from hil.hunt import fixed_starts
from hil.parting import Parting, part
from hil.rates import FOUR, Rates, freed, rates
from hil.subject import Subject, read_subject
from hil.walks import try_walks
from sim.numbers import WorldNumbers, world_numbers

pytestmark = pytest.mark.hil_req("HUNT")

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


# -- On three lines, without a step line ------------------------------------------------------


@pytest.fixture(scope="module")
def tokenizer() -> Iterator[Tokenizer]:
    with Tokenizer() as shared:
        yield shared


@pytest.fixture(scope="module")
def runners(tokenizer: Tokenizer) -> tuple[Subject, Subject]:
    predator, prey, *_ = world()
    return freed(predator, tokenizer), freed(prey, tokenizer)


def test_on_three_lines_every_movement_is_read_from_the_servos(
    runners: tuple[Subject, Subject],
) -> None:
    """Both walk all the time; what they make is a movement of their tables, whole, each time."""
    _, prey, numbers, start = world()
    result = part(*runners, numbers, start, steps=6)
    assert result.trouble == ""
    assert result.predator_steps == 6
    assert 5 <= result.prey_steps <= 8
    assert 1 <= result.decided_alike <= 6
    mixed = part(runners[0], prey, numbers, start, steps=2)
    assert (mixed.trouble, mixed.predator_steps) == ("", 2)


def test_what_is_no_movement_is_seen_on_three_lines(
    runners: tuple[Subject, Subject], tokenizer: Tokenizer
) -> None:
    predator, prey = runners
    *_, numbers, start = world()
    source = predator.sources["locomotion"]
    rows = [line for line in source.splitlines() if "DATA" in line and "' pose 2: forward" in line]
    shifted = source
    for row in rows:
        shifted = shifted.replace(row, row.replace("221", "211"))
    assert shifted != source
    image = tokenizer.compile(shifted, predator.files["locomotion"]).image
    faulty = replace(predator, images={**predator.images, "locomotion": image})
    result = part(faulty, prey, numbers, start, steps=3)
    assert "predator: not " in result.trouble
    assert "horizontal" in result.trouble
    assert result.predator_steps == 0
    trial = try_walks(faulty)
    assert trial.verdict is Verdict.FAIL
    assert "was asked for: not " in trial.reason
    assert sum(trial.agreed.values()) < 8


def test_every_command_on_three_lines_is_walked(runners: tuple[Subject, Subject]) -> None:
    for runner in runners:
        trial = try_walks(runner)
        assert (trial.verdict, trial.reason) == (Verdict.PASS, "")
        assert trial.agreed == dict.fromkeys(range(8), 1)


def test_lines_that_are_swapped_are_seen(
    runners: tuple[Subject, Subject], tokenizer: Tokenizer
) -> None:
    prey = runners[1]
    source = prey.sources["locomotion"]
    swapped = source.replace("command = commandLines & %0111", "command = commandLines & %0110", 1)
    assert swapped != source
    image = tokenizer.compile(swapped, prey.files["locomotion"]).image
    faulty = replace(prey, images={**prey.images, "locomotion": image})
    trial = try_walks(faulty)
    assert trial.verdict is Verdict.FAIL
    assert trial.agreed[0] == 1


def test_a_referee_wants_step_lines(runners: tuple[Subject, Subject]) -> None:
    *_, numbers, start = world()
    with pytest.raises(RigError, match="has no step line"):
        Colony(*runners, numbers, start)


def test_capture_rates_are_told() -> None:
    partings = (
        Parting(10, 20, 20, 19, 5, 12.0, ""),
        Parting(10, None, 50, 49, 3, 40.0, ""),
        Parting(None, None, 50, 51, 1, 80.0, "7: predator: moves without being told"),
        Parting(None, 30, 30, 31, 1, 20.0, ""),
    )
    rows = dict(Rates(partings, 50).rows())
    assert rows["captured by the simulator"] == "2 (50 %)"
    assert rows["captured by the robots"] == "2 (50 %)"
    assert rows["captured by both"] == "1"
    assert rows["decisions alike at first, median"] == "2"
    assert rows["farthest apart after as many movements, median and most"] == "30 and 80 units"
    assert rows["movements to the capture, robots by simulator, median"] == "2.00"
    assert rows["trouble"] == "7: predator: moves without being told"


def test_the_reference_robots_are_played_from_the_fixed_starts() -> None:
    found = rates(FOUR, [QUICK], steps=2)
    assert [one.predator_steps for one in found.partings] == [2]
    assert "captured by the robots                                    0 (0 %)" in found.text()
