"""The reference: what the simulator decides. Every other target is compared with it."""

from collections.abc import Sequence
from itertools import count

import numpy as np
from numpy.typing import NDArray

from cgagen.bench_protocol import (
    PREY_ANTENNA_LEFT,
    PREY_ANTENNA_RIGHT,
    PREY_BOTH_LEFT_OPEN,
    PREY_BOTH_RIGHT_OPEN,
    PREY_CALM,
    PREY_FIRST_SONAR,
)
from cgagen.robot import Robot, SituationCounts
from cgagen.words import COMMANDS, Movement, Role
from hil.roster import rows_of
from hil.subject import Subject
from hil.target import STATE, Identity, Observation, Stimulus
from sim.jit import kernel
from sim.numbers import ReflexNumbers
from sim.world import PreyReading, Reading, answer_of_reading, state_of_reading


class SimulatedTarget:
    """The simulator's classifier, with a genome's table or a prey's reflex behind it.

    Args:
        subject: robot and genome; its images are not looked at.
    """

    url = "simulator"
    caps = frozenset({STATE})

    def __init__(self, subject: Subject) -> None:
        self.stale = 0
        self._subject = subject
        self._seq = count(1)
        self._commands = commands_by_state(subject)

    def open(self) -> None:
        """Nothing to open."""

    def close(self) -> None:
        """Nothing to close."""

    def reset(self) -> None:
        """Nothing to reset: it has no memory."""

    def identity(self) -> Identity:
        """Return whom it stands for."""
        return Identity(self._subject.robot.name, self._subject.genome_digest)

    def decide(self, stimulus: Stimulus) -> Observation:
        """Return what the simulator decides. Raises ReadingError."""
        return self.decide_all([stimulus])[0]

    def decide_all(self, stimuli: Sequence[Stimulus]) -> list[Observation]:
        """Return all decisions; a million a second instead of thousands."""
        states = states_of(self._subject.robot, stimuli)
        return [
            Observation(next(self._seq), self._commands[state], state) for state in states.tolist()
        ]


def commands_by_state(subject: Subject) -> tuple[int, ...]:
    """Return the command of each state: a predator's 64, a prey's 11."""
    if subject.genome is not None:
        return subject.genome.commands()
    reflex = subject.robot.reflex
    if reflex is None:
        raise ValueError(f"{subject.robot.name} is a predator and has no genome")
    answers = (
        Movement.WAIT,
        *reflex.policy.answers,
        reflex.antenna_left,
        reflex.antenna_right,
        reflex.both_left_open,
        reflex.both_right_open,
    )
    return tuple(COMMANDS[Role.PREY].index(answer) for answer in answers)


def states_of(robot: Robot, stimuli: Sequence[Stimulus]) -> NDArray[np.int64]:
    """Return the state of each stimulus, by the simulator's own classifier.

    A prey's classifier answers with commands; asked with a reflex whose answers are the numbers
    of the states, it answers with those.

    Raises:
        ReadingError: one is not of this robot.
    """
    rows = rows_of(stimuli, robot)
    states = np.zeros(len(rows), dtype=np.int64)
    if not len(rows):
        return states
    if robot.limits is not None:
        _predator_states(rows, robot.limits.masking, robot.situation_counts, states)
    else:
        _prey_states(rows, numbered_reflex(robot.alarm_count), states)
    return states


def numbered_reflex(alarm: int) -> ReflexNumbers:
    """Return a prey's reflex that answers with the number of its state."""
    first = PREY_FIRST_SONAR
    return ReflexNumbers(
        alarm=alarm,
        answers=(first, first + 1, first + 2, first + 3, first + 4, first + 5),
        wait=PREY_CALM,
        antenna_left=PREY_ANTENNA_LEFT,
        antenna_right=PREY_ANTENNA_RIGHT,
        both_left_open=PREY_BOTH_LEFT_OPEN,
        both_right_open=PREY_BOTH_RIGHT_OPEN,
    )


@kernel
def _predator_states(
    rows: NDArray[np.int64],
    masking: bool,
    limits: SituationCounts,
    states: NDArray[np.int64],
) -> None:
    for k in range(len(rows)):
        row = rows[k]
        reading = Reading(row[0], row[1], row[2], row[3] != 0, row[4] != 0, row[5], row[6])
        states[k] = state_of_reading(reading, masking, limits)


@kernel
def _prey_states(rows: NDArray[np.int64], reflex: ReflexNumbers, states: NDArray[np.int64]) -> None:
    for k in range(len(rows)):
        row = rows[k]
        reading = PreyReading(
            row[0], row[1], row[2], row[3], row[4], row[5], row[6] != 0, row[7] != 0
        )
        states[k] = answer_of_reading(reading, reflex)
