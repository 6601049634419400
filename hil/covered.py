"""Which lines, branches and genes of the four programs the checks meet.

The images are the ones that go into the chips: the emulated chip counts, nothing is added.
"""

import sys
from dataclasses import dataclass
from pathlib import Path

import click

from cgagen.emulator.chip import Coverage
from cgagen.emulator.coverage_report import SourceCoverage, cover_source
from cgagen.errors import MismatchError
from cgagen.stamp.compiled import Compiled
from cgagen.stamp.scan import lines_of
from cgagen.tokenizer import compile_source
from cgagen.words import Role
from hil.anchors import Anchors, anchors_of
from hil.benches import counted
from hil.fate import PROGRAMS, SURVIVORS, bad_row, read_reviews
from hil.judge_legs import judge_legs
from hil.judge_main import judge_main
from hil.kill import subject_for
from hil.main_decides import Decider, genes
from hil.main_trial import MainTrial
from hil.main_wanted import wanted_of
from hil.simulated import states_of
from hil.stimuli import every_state, neutral, thresholds, ties
from hil.subject import Subject

GENES = 64


@dataclass(frozen=True, slots=True)
class Covered:
    """What was met of a program.

    Attributes:
        role: of the robot.
        chip: `main` or `locomotion`.
        source: lines and branches.
        states: those that readings lead to; with masking there are not all 64.
        genes: a predator's whose entry the program has looked up, all of them right.
    """

    role: str
    chip: str
    source: SourceCoverage
    states: frozenset[int]
    genes: frozenset[int]

    def missed(self) -> list[str]:
        """Return the lines that were not executed or not decided both ways, comments off."""
        texts = lines_of(self.source.source)
        return [
            " ".join(texts[line.line - 1].partition("  '")[0].split())
            for line in self.source.lines
            if not line.count or any(one.taken < len(one.ways) for one in line.decisions)
        ]

    def text(self) -> str:
        """Return one line."""
        line = f"{self.role} {self.source.summary}"
        if self.chip == "main" and self.role == Role.PREDATOR:
            line += f", {len(self.genes)} of {GENES} genes, {len(self.states)} states by readings"
        return line


def cover(role: str, chip: str) -> Covered:
    """Run the checks on a program of `firmware/` and count.

    Raises:
        MismatchError: the source compiles to other bytes than its image.
        FailedCheck: the program is wrong.
    """
    subject, coverage = subject_for(role), Coverage()
    compiled = compile_source(subject.sources[chip], subject.files[chip])
    if compiled.image.eeprom != subject.images[chip].eeprom:
        raise MismatchError(f"{subject.where}: {compiled.name} is not what is in the image")
    if chip == "locomotion":
        judge_legs(subject, compiled.image, coverage)
        counted(subject.images[chip], coverage)
        return Covered(role, chip, cover_source(compiled, coverage), frozenset(), frozenset())
    judge_main(subject, wanted_of(subject), compiled.image, coverage)
    anchors = anchors_of(compiled.image, subject.robot)
    states = _decide_slowly(subject, compiled, anchors, coverage)
    counted(subject.images[chip], coverage)
    found = frozenset[int]()
    if subject.genome is not None:
        trial = MainTrial(subject, compiled.image)
        trial.present(neutral(subject.robot))
        found = genes(trial, anchors)
    return Covered(role, chip, cover_source(compiled, coverage), states, found)


def _decide_slowly(
    subject: Subject, compiled: Compiled, anchors: Anchors, coverage: Coverage
) -> frozenset[int]:
    """Let the chip itself decide, so that it counts; a call of the routine would not."""
    robot = subject.robot
    stimuli = [*every_state(robot).values(), *thresholds(robot), *list(ties(robot))[:60]]
    trial = MainTrial(subject, compiled.image)
    trial.present(neutral(robot))
    decider = Decider(trial, anchors, anchors.places.entry)
    trial.chip.coverage = coverage
    before = trial.bench.snapshot()
    for stimulus in stimuli:
        trial.bench.restore(before)
        trial.chip.registers.words[:] = decider.words(stimulus)
        trial.chip.run_until(lambda: trial.chip.pc == decider.stop, trial.now_ns + 100_000_000)
    return frozenset(states_of(robot, stimuli).tolist())


def reviewed_lines(path: Path = SURVIVORS) -> dict[str, str]:
    """Return the reasons of lines that no check meets in full, by chip and text."""
    rows = read_reviews(path).get("uncovered", [])
    try:
        return {f"{chip} {row['line']}": row["reason"] for row in rows for chip in row["chips"]}
    except (KeyError, TypeError, AttributeError) as error:
        raise bad_row(path, error) from error


def main() -> int:
    """Print the figures and the lines; 1 where one is not reviewed."""
    known, fresh = reviewed_lines(), 0
    for role, chip in PROGRAMS:
        covered = cover(role, chip)
        click.echo(covered.text())
        for line in covered.missed():
            reason = known.get(f"{chip} {line}")
            fresh += reason is None
            click.echo(f"  {line}\n      {reason or 'nobody has looked at this'}")
    return 1 if fresh else 0


if __name__ == "__main__":
    sys.exit(main())
