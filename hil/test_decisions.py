"""The firmware of predator and prey decides as the simulator does.

Every test runs for each robot, and those with `hil_target` on each target that was named.
"""

from collections.abc import Callable, Sequence
from typing import Any

from cgagen.words import Role, situations_of
from hil.equivalence import Trial
from hil.registers import RegisterTarget
from hil.simulated import commands_by_state
from hil.stimuli import Level, every_state
from hil.subject import Subject
from hil.target import Stimulus, Target
from hil.verify import pin_readings, try_table

Check = Callable[[Target, Sequence[Stimulus]], Trial]


def test_every_gene_is_in_the_table(hil_subject: Subject, hil_registers: RegisterTarget) -> None:
    trial = try_table(hil_subject, hil_registers)
    assert trial.verdict == "PASS", trial.reason
    assert trial.decisions == len(commands_by_state(hil_subject))


def test_all_commands_and_situations_are_met(hil_subject: Subject) -> None:
    """The readings of this suite lead to all eight commands and all of Table II."""
    commands = commands_by_state(hil_subject)
    reached = every_state(hil_subject.robot)
    if hil_subject.role is Role.PREY:
        assert set(reached) == set(range(11))
        return
    assert {commands[state] for state in reached} == set(commands)
    assert {situations_of(state)[0] for state in reached} == {
        situations_of(s)[0] for s in range(64)
    }
    assert {situations_of(state)[1] for state in reached} == {
        situations_of(s)[1] for s in range(64)
    }


def test_decisions_from_registers(
    hil_registers: RegisterTarget, hil_stimuli: list[Stimulus], hil_check: Check
) -> None:
    trial = hil_check(hil_registers, hil_stimuli)
    assert trial.decisions == len(hil_stimuli)


def test_decisions_on_the_target(
    hil_target: Target, hil_subject: Subject, hil_config: Any, hil_check: Check
) -> None:
    readings = pin_readings(hil_subject, Level(hil_config.level), hil_config.seed)
    trial = hil_check(hil_target, readings)
    assert set(trial.agreed) == set(every_state(hil_subject.robot))
