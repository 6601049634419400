"""Decisions as a file: one a line, JSON, in the order in which they were made."""

import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cgagen.errors import RunError
from cgagen.files import write_text
from cgagen.inputs import DECISIONS, read_text
from cgagen.notations import parse_json
from cgagen.outputs import begins
from hil.target import Observation, Stimulus, stimulus_of

DECISION_LINES = begins("a file of decisions", '{"seq": ')


@dataclass(frozen=True, slots=True)
class Decision:
    """A stimulus and what a target has made of it."""

    stimulus: Stimulus
    observation: Observation

    def line(self) -> str:
        r"""Return the decision as a line of a file, its end included.

        >>> print(Decision(Stimulus((7,)), Observation(1, 3, 0)).line(), end="")
        {"seq": 1, "reading": "7/--", "state": 0, "command": 3, "time_ns": null}
        """
        seen = self.observation
        row = {
            "seq": seen.seq,
            "reading": self.stimulus.text(),
            "state": seen.state,
            "command": seen.command,
            "time_ns": seen.latency_ns,
        }
        return json.dumps(row) + "\n"


def write_decisions(path: Path, decisions: Iterable[Decision]) -> None:
    """Write decisions to a file, whole or not at all.

    Raises:
        StorageError: the disk is full, read-only or gone.
    """
    write_text(path, "".join(decision.line() for decision in decisions))


def read_decisions(path: Path) -> Iterator[Decision]:
    """Read a file of decisions.

    Raises:
        RunError: a line is no decision; the sentence has its number.
    """
    for number, line in enumerate(read_text(path, DECISIONS).splitlines(), 1):
        try:
            yield _decision(parse_json(line))
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            raise RunError(
                f"{path}: line {number} is no decision ({error}); record the file again"
            ) from error


def _decision(row: dict[str, Any]) -> Decision:
    numbers = [row["seq"], row["command"]]
    options = [row["state"], row["time_ns"]]
    if not all(type(number) is int for number in numbers) or not 0 <= row["command"] <= 7:
        raise ValueError("seq and command are numbers, command from 0 to 7")
    if not all(option is None or type(option) is int for option in options):
        raise ValueError("state and time_ns are numbers or null")
    seen = Observation(row["seq"], row["command"], row["state"], latency_ns=row["time_ns"])
    return Decision(stimulus_of(row["reading"]), seen)
