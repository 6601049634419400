"""Readings of a wrong shape: no target decides about one, and all say the same of it."""

from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np
import pytest

from cgagen.errors import CgagenError, ReadingError
from hil.canbus import CanTarget
from hil.emulated import PinsTarget, robot_bench
from hil.main_trial import MainTrial
from hil.pipe import BytePipe
from hil.registers import RegisterTarget
from hil.rig import RigOnBus
from hil.simulated import SimulatedTarget, states_of
from hil.stimuli import neutral
from hil.target import Stimulus
from hil.wired import WiredTarget
from tests.predator_rig import rig
from tests.rig_cases import channel
from tests.subjects import subject

PREDATOR, PREY = subject("predator"), subject("prey")
NAN = float("nan")

WRONG: dict[str, tuple[Any, str]] = {
    "one sonar": (Stimulus((7,)), "has 1 sonars and 0 light sensors, and servobot-predator has 3"),
    "no sonar": (Stimulus((), (False, False), (1, 2)), "has 0 sonars and 2 light sensors"),
    "a prey's": (neutral(PREY.robot), "has 6 sonars and 0 light sensors"),
    "same sum": (Stimulus((1, 2, 3, 4), (False, False), (1,)), "has 4 sonars and 1 light sensors"),
    "no lights": (Stimulus((1, 2, 3)), "has 3 sonars and 0 light sensors"),
    "one antenna": (Stimulus((1, 2, 3), (False,), (4, 5)), "has the antennas"),  # type: ignore[arg-type]
    "numbers": (Stimulus((1, 2, 3), (0, 1), (4, 5)), "has the antennas"),  # type: ignore[arg-type]
    "negative": (
        Stimulus((1, -2, 3), (False, False), (4, 5)),
        "the count -2: a chip counts from 0",
    ),
    "17 bits": (Stimulus((1, 2, 3), (False, False), (4, 65_536)), "the count 65536: a chip"),
    "huge": (Stimulus((10**30, 2, 3), (False, False), (4, 5)), "a chip counts from 0 to 65,535"),
    "half": (Stimulus((1.5, 2, 3), (False, False), (4, 5)), "has the count 1.5: counts are whole"),  # type: ignore[arg-type]
    "NaN": (Stimulus((NAN, 2, 3), (False, False), (4, 5)), "has the count nan"),  # type: ignore[arg-type]
    "text": (Stimulus(("1", 2, 3), (False, False), (4, 5)), "has the count '1'"),  # type: ignore[arg-type]
    "a flag": (Stimulus((True, 2, 3), (False, False), (4, 5)), "has the count True"),
    "None": (None, "no Stimulus of counts and antennas"),
    "a tuple": ((1, 2, 3), "no Stimulus of counts and antennas"),
}


@cache
def _pins() -> PinsTarget:
    one = PinsTarget(PREDATOR)
    one.open()
    return one


@pytest.fixture(scope="module")
def registers(tokenizer) -> Iterator[RegisterTarget]:
    with RegisterTarget(PREDATOR, tokenizer.compile) as one:
        yield one


@pytest.fixture(scope="module")
def wired() -> Iterator[WiredTarget]:
    with BytePipe(robot_bench(PREDATOR.robot, PREDATOR.images)) as pipe:
        with WiredTarget(pipe.url, PREDATOR, gaps=False) as one:
            yield one


@pytest.fixture(scope="module")
def on_a_bus() -> Iterator[CanTarget]:
    name = channel()
    with RigOnBus(rig(), f"virtual:{name}") as service:
        one = CanTarget(service.url, PREDATOR)
        one.open()
        yield one
        one.close()


@pytest.mark.parametrize("which", WRONG)
def test_the_simulator_does_not_decide(which: str) -> None:
    stimulus, words = WRONG[which]
    with pytest.raises(ReadingError) as refused:
        SimulatedTarget(PREDATOR).decide(stimulus)
    assert words in str(refused.value)
    assert "give one of servobot-predator" in str(refused.value)
    with pytest.raises(ReadingError, match="the reading"):
        SimulatedTarget(PREDATOR).decide_all([neutral(PREDATOR.robot), stimulus])


def test_the_roster_is_named() -> None:
    with pytest.raises(ReadingError) as refused:
        SimulatedTarget(PREDATOR).decide(Stimulus((7,)))
    assert str(refused.value) == (
        "the reading 7/-- has 1 sonars and 0 light sensors, and servobot-predator has 3 and 2: "
        "sonars front, right, left; antennas left, right; light left, right; "
        "give one of servobot-predator"
    )
    assert isinstance(refused.value, ValueError)
    assert isinstance(refused.value, CgagenError)
    assert refused.value.exit_code == 3


@pytest.mark.parametrize("which", WRONG)
def test_the_emulated_robot_and_its_registers_say_the_same(which, registers) -> None:
    stimulus, words = WRONG[which]
    for target in (_pins(), registers):
        with pytest.raises(ReadingError) as refused:
            target.decide(stimulus)
        assert words in str(refused.value)


@pytest.mark.parametrize("which", WRONG)
def test_a_chip_on_a_wire_and_a_rig_are_not_even_asked(which, wired, on_a_bus) -> None:
    stimulus, words = WRONG[which]
    for target in (wired, on_a_bus):
        with pytest.raises(ReadingError) as refused:
            target.decide(stimulus)
        assert words in str(refused.value)
    assert wired.stale == on_a_bus.stale == 0


def test_after_a_refusal_all_decide_as_before(registers, wired, on_a_bus) -> None:
    right = neutral(PREDATOR.robot)
    wanted = SimulatedTarget(PREDATOR).decide(right)
    for target in (_pins(), registers, wired, on_a_bus):
        seen = target.decide(right)
        assert (seen.command, seen.state) == (wanted.command, wanted.state)


def test_a_prey_has_its_own_roster() -> None:
    with pytest.raises(ReadingError, match="servobot-prey has 6 and 0"):
        SimulatedTarget(PREY).decide(neutral(PREDATOR.robot))


def test_echoes_of_other_sensors_are_refused() -> None:
    with pytest.raises(ReadingError, match=r"1 echoes, 2 antennas, 2 RC times"):
        _pins().present_ns([None], [False, False], [None, None])


def test_a_trial_of_a_mutant_asks_too() -> None:
    trial = MainTrial(PREDATOR, PREDATOR.images["main"])
    with pytest.raises(ReadingError, match="has 1 sonars"):
        trial.present(Stimulus((7,)))


def test_numbers_of_numpy_are_numbers() -> None:
    row = np.array([1843, 0, 700, 0, 170])
    stimulus = Stimulus(tuple(row[:3]), (np.True_, np.False_), tuple(row[3:]))
    same = Stimulus((1843, 0, 700), (True, False), (0, 170))
    found = states_of(PREDATOR.robot, [stimulus, same]).tolist()
    assert found[0] == found[1] == states_of(PREDATOR.robot, [same]).tolist()[0]
    assert states_of(PREDATOR.robot, []).tolist() == []
