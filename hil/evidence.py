"""What the trials of one robot's firmware have shown, as JSON has it.

Several processes may try parts of the same firmware: `merged` adds up what each of them has seen.
"""

from collections import defaultdict
from collections.abc import Sequence
from typing import Any

from cgagen.emulator.coverage_report import (
    Decision,
    LineCoverage,
    SourceCoverage,
    cover_source,
)
from cgagen.errors import SourceError
from cgagen.genome import origin_text
from cgagen.words import GENES, Role, situation_name, situations_of
from hil.benches import Counted
from hil.boundaries import STEPS, boundaries, steps_of
from hil.equivalence import Finding, Heard, Trial, Verdict
from hil.proof import Proof
from hil.registers import Compile
from hil.simulated import commands_by_state
from hil.stimuli import every_state
from hil.subject import CHIPS, Subject
from hil.target import Observation, Stimulus
from hil.timing import Timing

Pair = list[int]
"""How many were tried, and how many agreed."""


class Evidence:
    """Collects what trials of one firmware show.

    Args:
        subject: the firmware.

    Attributes:
        whole: of all cells, where a proof was made; for whoever asks again.
        beside: what was tried beside decisions, by name; likewise.
    """

    def __init__(self, subject: Subject) -> None:
        self.subject = subject
        self.coverage: dict[str, SourceCoverage] = {}
        self.timing: Timing | None = None
        self.whole: Proof | None = None
        self.beside: dict[str, Trial] = {}
        self._proof: dict[str, Any] | None = None
        self._smallest: dict[str, Any] | None = None
        self._limits = boundaries(subject.robot)
        self._trials: dict[str, dict[str, Any]] = {}
        self._states: defaultdict[int, Pair] = defaultdict(lambda: [0, 0])
        self._steps: defaultdict[tuple[int, int], Pair] = defaultdict(lambda: [0, 0])
        self._table: dict[int, Pair] = {}
        self._slowest: dict[str, tuple[int, str]] = {}

    def ear(self, target: str) -> Heard:
        """Return what `compare` tells each answer of a target to."""

        def heard(
            stimulus: Stimulus, expected: Observation, observed: Observation | None, agrees: bool
        ) -> None:
            for pair in (
                self._states[expected.state or 0],
                *(self._steps[step] for step in steps_of(stimulus, self._limits)),
            ):
                pair[0] += 1
                pair[1] += agrees
            if observed is not None and observed.latency_ns is not None:
                slow = (observed.latency_ns, stimulus.text())
                self._slowest[target] = max(slow, self._slowest.get(target, slow))

        return heard

    def trial(self, name: str, trial: Trial) -> None:
        """Note what came of a trial."""
        self._trials[name] = trial_data(trial)
        if trial.smallest is not None and (not self._smallest or not self._smallest["reading"]):
            self._smallest = finding_data(trial.smallest, self.subject)

    @property
    def not_tried(self) -> dict[str, str]:
        """Why something stands there that was not tried, by name."""
        rows = self._trials.items()
        return {name: row["reason"] for name, row in rows if row["verdict"] == Verdict.NOT_TRIED}

    def table(self, trial: Trial) -> None:
        """Note which entries of the table were looked up."""
        self._table = {state: [n, trial.agreed.get(state, 0)] for state, n in trial.tried.items()}

    def proof(self, proof: Proof) -> None:
        """Note how much of the sensor space was tried."""
        self._proof = worse(proof_data(proof), self._proof)

    def count(self, counted: Counted, compile_source: Compile) -> None:
        """Note which lines were executed, of those sources that compile to their image."""
        for name in CHIPS:
            image = self.subject.images[name]
            try:
                compiled = compile_source(self.subject.sources[name], self.subject.files[name])
            except SourceError:
                continue
            if image.digest in counted.coverage and compiled.image.eeprom == image.eeprom:
                self.coverage[name] = cover_source(compiled, counted.coverage[image.digest])

    def data(self) -> dict[str, Any]:
        """Return everything, in lists whose rows are the same for the same robot and genome."""
        subject, robot = self.subject, self.subject.robot
        return {
            "name": robot.name,
            "role": str(robot.role),
            "where": subject.where,
            "robot": robot.digest,
            "genome": subject.genome.digest if subject.genome else None,
            "origin": origin_text(subject.genome) if subject.genome else "",
            "images": {name: image.digest for name, image in subject.images.items()},
            "trials": self._trials,
            "smallest": self._smallest,
            "states": self._state_rows(),
            "boundaries": [
                {
                    **limit._asdict(),
                    "steps": {str(step): self._steps.get((number, step), [0, 0]) for step in STEPS},
                }
                for number, limit in enumerate(self._limits)
            ],
            "slowest": {target: list(slow) for target, slow in self._slowest.items()},
            "timing": self.timing._asdict() if self.timing else None,
            "proof": self._proof,
            "coverage": {name: coverage_data(one) for name, one in self.coverage.items()},
        }

    def _state_rows(self) -> list[dict[str, Any]]:
        """Return a row per state: what it is called, its command, and what was tried."""
        subject = self.subject
        reached = every_state(subject.robot)
        names = state_names(subject)
        return [
            {
                "state": state,
                "names": list(names[state]),
                "command": command,
                "movement": subject.movement(command),
                "reached": state in reached,
                "readings": self._states.get(state, [0, 0]),
                "table": self._table.get(state, [0, 0]),
            }
            for state, command in enumerate(commands_by_state(subject))
        ]


def state_names(subject: Subject) -> list[tuple[str, ...]]:
    """Return what a state is called: obstacle and target of a predator, the cause of a prey."""
    if subject.role is Role.PREDATOR:
        pairs = [situations_of(state) for state in range(GENES)]
        return [
            (situation_name(one, "object"), situation_name(two, "target")) for one, two in pairs
        ]
    sonars = [f"{sonar.name}_nearest" for sonar in subject.robot.sonars]
    rest = ("antenna_left", "antenna_right", "both_left_open", "both_right_open")
    return [(name,) for name in ("calm", *sonars, *rest)]


def trial_data(trial: Trial) -> dict[str, Any]:
    """Return a trial's figures, without its findings."""
    return {
        "target": trial.target,
        "verdict": str(trial.verdict),
        "reason": trial.reason,
        "decisions": trial.decisions,
        "agreed": sum(trial.agreed.values()),
        "left_out": trial.left_out,
        "stale": trial.stale,
        "note": trial.note,
    }


def finding_data(small: Finding, subject: Subject) -> dict[str, Any]:
    """Return a difference, with the names of what was seen and decided."""
    names = state_names(subject)

    def seen(one: Observation | None) -> dict[str, Any] | None:
        if one is None or one.command < 0:
            return None
        known = one.state is not None and 0 <= one.state < len(names)
        return {
            "state": one.state,
            "names": list(names[one.state]) if known and one.state is not None else [],
            "command": one.command,
            "movement": subject.movement(one.command),
        }

    return {
        "reading": small.stimulus.text() if small.stimulus else None,
        "why": small.why,
        "expected": seen(small.expected),
        "observed": seen(small.observed),
        "lines": [line._asdict() for line in small.lines],
    }


def proof_data(proof: Proof) -> dict[str, Any]:
    """Return how much of the sensor space was tried, and what came of it."""
    return {
        "verdict": str(proof.verdict),
        "cells": proof.cells,
        "tried": proof.tried,
        "proven": proof.proven,
        "states": len(proof.by_state),
        "text": proof.text(),
    }


def coverage_data(source: SourceCoverage) -> dict[str, Any]:
    """Return what was executed of a source, with its text."""
    return {
        "name": source.name,
        "source": source.source,
        "lines": [
            [line.line, line.count, [[one.bit, one.ways, one.counts] for one in line.decisions]]
            for line in source.lines
        ],
    }


def source_coverage(data: dict[str, Any]) -> SourceCoverage:
    """Return what `coverage_data` was made of."""
    lines = (
        LineCoverage(
            line,
            count,
            tuple(
                Decision(bit, (ways[0], ways[1]), None if gone is None else (gone[0], gone[1]))
                for bit, ways, gone in decisions
            ),
        )
        for line, count, decisions in data["lines"]
    )
    return SourceCoverage(data["name"], data["source"], tuple(lines))


def key_of(data: dict[str, Any]) -> str:
    """Return what two processes must agree in that have tried the same firmware."""
    return " ".join([data["robot"], data["genome"] or "-", *data["images"].values()])


def merged(one: dict[str, Any], other: dict[str, Any]) -> dict[str, Any]:
    """Add up what two processes have seen of the same firmware."""
    both = one | {"trials": dict(sorted((one["trials"] | other["trials"]).items()))}
    both["states"] = [
        mine | {key: _sum(mine[key], yours[key]) for key in ("readings", "table")}
        for mine, yours in zip(one["states"], other["states"], strict=True)
    ]
    both["boundaries"] = [
        mine | {"steps": {at: _sum(pair, yours["steps"][at]) for at, pair in mine["steps"].items()}}
        for mine, yours in zip(one["boundaries"], other["boundaries"], strict=True)
    ]
    slowest = [*one["slowest"].items(), *other["slowest"].items()]
    both["slowest"] = dict(sorted(slowest))
    for key in ("timing", "smallest"):
        both[key] = one[key] or other[key]
    both["proof"] = worse(one["proof"], other["proof"])
    both["coverage"] = {
        name: _covered(one["coverage"].get(name), other["coverage"].get(name))
        for name in CHIPS
        if name in one["coverage"] or name in other["coverage"]
    }
    return both


def worse(one: dict[str, Any] | None, other: dict[str, Any] | None) -> dict[str, Any] | None:
    """Return what tells more: a proof that fails, or the one with more cells."""
    found = [proof for proof in (one, other) if proof is not None]
    return min(found, key=lambda proof: (proof["verdict"] == "PASS", -proof["tried"]), default=None)


def _covered(one: dict[str, Any] | None, other: dict[str, Any] | None) -> dict[str, Any]:
    if one is None or other is None:
        return one or other or {}
    lines = []
    for (line, count, mine), (_, more, yours) in zip(one["lines"], other["lines"], strict=True):
        decisions = [
            [bit, ways, _sum(gone, too) if gone and too else gone or too]
            for (bit, ways, gone), (_, _, too) in zip(mine, yours, strict=True)
        ]
        lines.append([line, count + more, decisions])
    return one | {"lines": lines}


def _sum(one: Sequence[int], other: Sequence[int]) -> list[int]:
    return [mine + yours for mine, yours in zip(one, other, strict=True)]
