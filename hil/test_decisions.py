"""The firmware of predator and prey decides as the simulator does.

Every test runs for each robot, and those with `hil_target` on each target that was named.
"""

from collections.abc import Callable, Sequence
from typing import Any

import pytest

from cgagen.robot import load_robot
from cgagen.tokenizer import compile_source
from cgagen.words import Role, Situation, situations_of
from hil.conduct import try_conduct
from hil.equivalence import Trial
from hil.evidence import Evidence
from hil.lone_cases import subject as reference
from hil.proving import proof_of, whole_proof
from hil.registers import RegisterTarget
from hil.simulated import commands_by_state
from hil.stimuli import Level, every_state, stimuli_of
from hil.subject import Subject
from hil.target import Stimulus, Target
from hil.timing import try_timing
from hil.verify import SAMPLED_CELLS, pin_readings, try_table, with_beside
from hil.walks import try_walks

Check = Callable[[Target, Sequence[Stimulus]], Trial]
Judge = Callable[[Trial], Trial]


@pytest.mark.hil_req("TABLE")
def test_every_gene_is_in_the_table(
    hil_subject: Subject, hil_registers: RegisterTarget, hil_judge: Judge, hil_evidence: Evidence
) -> None:
    trial = try_table(hil_subject, hil_registers)
    hil_evidence.table(trial)
    hil_judge(trial)
    assert trial.decisions == len(commands_by_state(hil_subject))


@pytest.mark.hil_req("SITUATIONS")
def test_every_state_that_can_occur_is_met(
    hil_subject: Subject, hil_config: Any, hil_evidence: Evidence
) -> None:
    """The readings of this suite leave out no state that any reading leads this robot to.

    Which commands are met then is the genome's business: it need not use all eight.
    """
    if hil_config.level == Level.EXHAUSTIVE:
        proof = whole_proof(hil_evidence, compile_source)
    else:
        proof = proof_of(hil_subject, compile_source, SAMPLED_CELLS, hil_config.seed)
    reached = set(every_state(hil_subject.robot))
    assert set(proof.by_state) <= reached
    assert set(proof.by_state) == reached or not proof.proven


@pytest.mark.hil_req("SITUATIONS")
@pytest.mark.parametrize("role", Role)
def test_the_shipped_robots_meet_all_of_table_ii(role: Role) -> None:
    reached = set(every_state(load_robot(f"servobot-{role}")))
    if role is Role.PREY:
        assert reached == set(range(11))
        return
    pairs = [situations_of(state) for state in reached]
    assert {obstacle for obstacle, _ in pairs} == {target for _, target in pairs} == set(Situation)


@pytest.mark.hil_req("SITUATIONS")
def test_the_reference_genome_answers_with_all_eight_commands() -> None:
    """So all eight answers of the reference firmware are tried through its pins."""
    subject = reference("predator")
    commands = commands_by_state(subject)
    assert {commands[state] for state in every_state(subject.robot)} == set(range(8))


@pytest.mark.hil_req("DECISIONS", "BOUNDARIES")
def test_decisions_from_registers(
    hil_registers: RegisterTarget, hil_subject: Subject, hil_config: Any, hil_check: Check
) -> None:
    readings = stimuli_of(hil_subject.robot, Level(hil_config.level), hil_config.seed)
    trial = hil_check(hil_registers, readings)
    assert trial.decisions == len(readings)


@pytest.mark.hil_req("DECISIONS", "BOUNDARIES")
def test_decisions_on_the_target(
    hil_target: Target, hil_subject: Subject, hil_config: Any, hil_check: Check
) -> None:
    readings = pin_readings(hil_subject, Level(hil_config.level), hil_config.seed)
    trial = hil_check(hil_target, with_beside(hil_target, readings))
    assert set(trial.agreed) == set(every_state(hil_subject.robot))


@pytest.mark.hil_req("GAIT", "GO")
def test_every_movement_is_the_one_commanded(hil_subject: Subject, hil_judge: Judge) -> None:
    trial = hil_judge(try_walks(hil_subject))
    assert trial.decisions == 8


@pytest.mark.hil_req("TIME", "FRAMES")
def test_the_longest_decision_and_all_frames_are_in_time(
    hil_subject: Subject, hil_judge: Judge, hil_evidence: Evidence
) -> None:
    trial, hil_evidence.timing = try_timing(hil_subject)
    hil_judge(trial)


@pytest.mark.hil_req("GO", "BENCH", "FRAMES")
def test_both_controllers_conduct_themselves(hil_subject: Subject, hil_judge: Judge) -> None:
    """On all lines and on the port: one chip at a time, the other one played by hand."""
    trial = hil_judge(try_conduct(hil_subject))
    assert trial.decisions == 2
