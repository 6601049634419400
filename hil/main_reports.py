"""What a main controller says of each decision on its port, and the number that it gives it."""

from cgagen.bench_protocol import (
    ANTENNA_KEYS,
    COMMAND_KEY,
    END,
    LIGHT_KEYS,
    SONAR_KEYS,
    STATE_KEY,
    TELEMETRY,
)
from cgagen.errors import LackingError
from hil.anchors import number_place
from hil.main_trial import MainTrial
from hil.target import Observation, Stimulus
from hil.trial import want

FIRST_NUMBERS, LATE_NUMBER, NUMBERS = 3, 253, 256
"""After so many decisions the program is made to believe that the next one is this one, as if it
had made all between: the number is a byte, and 0 follows 255. Choice, the first two."""


def count_on(trial: MainTrial) -> None:
    """Make the program believe that its next decision is a late one."""
    if not trial.robot.telemetry:
        return
    try:
        place = number_place(trial.image)
    except LackingError as error:
        trial.lacks.append(error)
        return
    trial.chip.registers.write(*place, LATE_NUMBER)
    trial.number = LATE_NUMBER


def check_line(trial: MainTrial, stimulus: Stimulus, right: Observation) -> None:
    """Compare what was said since the last `forget` with the line that is wanted."""
    line = line_of(trial, trial.number, stimulus, right)
    if trial.number == LATE_NUMBER and trial.said == line_of(trial, FIRST_NUMBERS, stimulus, right):
        trial.number = FIRST_NUMBERS
        trial.lacks.append(
            LackingError("the number in telemetry is not that of the variable which says it")
        )
    else:
        want(trial.said == line, "telemetry", f"{trial.said!r}, not {line!r}")
    trial.number = (trial.number + 1) % NUMBERS


def line_of(trial: MainTrial, number: int, stimulus: Stimulus, right: Observation) -> str:
    """Return the line of telemetry of a decision."""
    sides = [1 - bent for bent in stimulus.touched]
    keys = [*SONAR_KEYS[trial.robot.role], *(LIGHT_KEYS if stimulus.lights else ())]
    keys += [*ANTENNA_KEYS, STATE_KEY, COMMAND_KEY]
    values = [*stimulus.sonars, *stimulus.lights, *sides, right.state, right.command]
    words = [f"{key}{value}" for key, value in zip(keys, values, strict=True)]
    return f"{TELEMETRY}{number} {' '.join(words)}{END}"
