"""That the bytes in the main controller's chip decide as the simulator does, for every reading.

1. Both deciders are followed (`hil.dataflow`, `hil.tracing`): nothing is done with a sensor's
   word but to compare it with numbers and with other words. Whatever else is done is named, and
   nothing is proven then.
2. So both decide alike wherever all these comparisons say the same: in each cell of a finite
   partition of all 65,536^n readings and all positions of the antennas (`hil.partition`).
3. One reading of each cell is put to the image itself, and to the simulator. Where all agree,
   they agree on every reading that can be.
4. Whatever the reading, the answer is set on the command lines by the routine itself (and at
   once, where there is no step line and they may be read at any time), and what the program does
   from there to its next look depends on nothing that was sensed or decided (`hil.afterwards`).

Taken for granted: that the emulator carries out tokens as the chip does (FIDELITY.md); that the
pins are measured as they should be, and each of the eight answers told as it should be, which is
tried through the pins; and that no host has put bits beside the antennas' in bench mode.
"""

import math
import random
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import islice
from typing import NamedTuple

from cgagen.emulator.chip import Chip
from cgagen.emulator.clock import Clock
from cgagen.emulator.registers import WORDS
from cgagen.emulator.routine import Routine
from cgagen.errors import ExecutionError, ImageError, UnprovenError
from cgagen.stamp.compiled import SourceMap
from cgagen.stamp.decode import decode
from hil.equivalence import Finding, Trial, Verdict
from hil.followed import POSITIONS, followed
from hil.partition import Partition
from hil.places import Place, Places, find_places
from hil.simulated import commands_by_state, states_of
from hil.subject import Subject
from hil.target import Observation, Stimulus
from hil.tracing import classifier_criticals

MOST_CELLS = 10_000_000
"""That are tried. Ref: choice; ten minutes of two cores."""

_BATCH = 4096
_JUNK = 0xA5C3
"""What the variables hold before a decision, which must not matter. Ref: choice."""


class Difference(NamedTuple):
    """A reading on which image and simulator part.

    Attributes:
        stimulus: the reading.
        expected: state and command of the simulator.
        observed: of the image; None where it came to no decision.
    """

    stimulus: Stimulus
    expected: tuple[int, int]
    observed: tuple[int, int] | None


@dataclass(frozen=True)
class Proof:
    """What came out.

    Attributes:
        verdict: PASS, FAIL or UNPROVEN.
        cells: of the whole sensor space; 0 where it could not be divided.
        by_state: how many cells were put to the image, by the state that the simulator names.
            After a whole proof, a state that is missing is one that no reading leads to.
        reasons: why nothing is proven.
        difference: the first, on FAIL.
        partition: the cells; None where there are none.
    """

    verdict: Verdict
    cells: int = 0
    by_state: dict[int, int] = field(default_factory=dict)
    reasons: tuple[str, ...] = ()
    difference: Difference | None = None
    partition: Partition | None = field(default=None, repr=False)

    @property
    def tried(self) -> int:
        """How many cells were put to the image."""
        return sum(self.by_state.values())

    def trial(self) -> Trial:
        """Return the same as the other checks give it."""
        trial = Trial("proof", self.verdict, "; ".join(self.reasons), dict(self.by_state))
        trial.agreed = dict(self.by_state)
        if self.difference is not None:
            stimulus, (state, command), observed = self.difference
            trial.agreed[state] -= 1
            trial.reason = self.text().removeprefix("FAIL: ")
            seen = None if observed is None else Observation(0, observed[1], observed[0])
            finding = Finding(stimulus, Observation(0, command, state), seen, trial.reason)
            trial.findings, trial.smallest = [finding], finding
        trial.note = "" if trial.reason else self.text()
        return trial

    @property
    def proven(self) -> bool:
        """Whether image and simulator decide alike on every reading."""
        return self.verdict is Verdict.PASS and self.tried == self.cells

    def text(self) -> str:
        """Return the result as a sentence."""
        if self.proven:
            return (
                f"PASS: proven for every reading, by all {self.cells:,} cells; "
                f"{len(self.by_state)} states occur"
            )
        if self.verdict is Verdict.PASS:
            return f"PASS: {self.tried:,} of {self.cells:,} cells agree; a sample, no proof"
        if self.difference is not None:
            stimulus, (state, command), observed = self.difference
            seen = (
                "no decision" if observed is None else "state {} and command {}".format(*observed)
            )
            return (
                f"FAIL: {stimulus.text()}: state {state} and command {command} expected, "
                f"{seen} observed"
            )
        return f"UNPROVEN: {'; '.join(self.reasons)}"


class Question:
    """A main controller's image, divided and ready to be asked.

    Args:
        subject: the firmware and what it is to agree with.
        source_map: statements of the main program, where it was compiled; for line numbers.

    Attributes:
        partition: the cells.
        criticals: what either decider compares.
        places: of the image.
        visited: stream addresses of the instructions that decisions may carry out.
        by_state: cells that were put to the image so far.

    Raises:
        UnprovenError: the image or the simulator does more with a sensor's word than compare it.
    """

    def __init__(self, subject: Subject, source_map: SourceMap | None = None) -> None:
        self.subject = subject
        image = subject.images["main"]
        try:
            program = decode(image.eeprom, image.model)
        except ImageError as error:
            raise UnprovenError(f"{subject.where}: main: {error}") from error
        self.places = find_places(program, subject.robot)
        flow, state = followed(program, image, self.places, source_map)
        self.criticals, self.visited = flow.criticals, flow.visited
        self.criticals.add(classifier_criticals(subject.robot, self.places.names))
        self.partition = Partition(len(self.places.names), self.criticals, POSITIONS)
        if len(self.partition) > MOST_CELLS:
            raise UnprovenError(
                f"its comparisons make {len(self.partition):,} cells, more than {MOST_CELLS:,}"
            )
        self.by_state: Counter[int] = Counter()
        self._commands = commands_by_state(subject)
        self._asked = _Asked(subject, self.places, state)

    def differences(self, cells: Iterable[int]) -> Iterator[Difference]:
        """Put cells to the image and to the simulator; return those on which they part."""
        robot = self.subject.robot
        rest = iter(cells)
        while batch := list(islice(rest, _BATCH)):
            asked = [self.partition[cell] for cell in batch]
            stimuli = [self._stimulus(*one) for one in asked]
            states = states_of(robot, stimuli).tolist()
            for (counts, touched), stimulus, state in zip(asked, stimuli, states, strict=True):
                self.by_state[state] += 1
                observed, expected = self.decide(counts, touched), (state, self._commands[state])
                if observed != expected:
                    yield Difference(stimulus, expected, observed)

    def decide(self, counts: tuple[int, ...], touched: tuple[bool, ...]) -> tuple[int, int] | None:
        """Return what the image decides: state and command; None if it gets nowhere."""
        return self._asked.decide(counts, touched)

    def _stimulus(self, counts: tuple[int, ...], touched: tuple[bool, ...]) -> Stimulus:
        sonars = len(self.subject.robot.sonars)
        return Stimulus(counts[:sonars], (touched[0], touched[1]), counts[sonars:])


def prove(
    subject: Subject,
    sample: int | None = None,
    seed: int = 0,
    source_map: SourceMap | None = None,
) -> Proof:
    """Compare a main controller's image with the simulator on the whole sensor space.

    Args:
        subject: the firmware and what it is to agree with.
        sample: so many cells, drawn from all; None for all.
        seed: of the drawing.
        source_map: for line numbers in reasons.
    """
    try:
        question = Question(subject, source_map)
    except UnprovenError as error:
        return Proof(Verdict.UNPROVEN, reasons=tuple(str(error).split("; ")))
    total = len(question.partition)
    cells: Iterable[int] = _spread(total)
    if sample is not None and sample < total:
        cells = random.Random(seed).sample(range(total), sample)
    difference = next(question.differences(cells), None)
    verdict = Verdict.PASS if difference is None else Verdict.FAIL
    by_state = dict(sorted(question.by_state.items()))
    return Proof(verdict, total, by_state, (), difference, question.partition)


def _spread(total: int) -> Iterator[int]:
    """Return all numbers below a total, neighbours far apart: a difference is met sooner."""
    stride = int(total * (math.sqrt(5) - 1) / 2) | 1
    while math.gcd(stride, total) > 1:
        stride += 2
    return (place * stride % total for place in range(total))


class _Asked:
    """The image's routine, called with registers."""

    def __init__(self, subject: Subject, places: Places, state: Place) -> None:
        chip = Chip("main", [subject.images["main"]], Clock())
        chip.machine.gosubs[:] = [places.call]
        chip.machine.pc = places.entry
        self._routine = Routine(chip, places.stop)
        self._pins = subject.robot.link.main_pins
        self._words = places.words
        size, element = state
        self._state_word, self._state_shift = divmod(size * element, 16)
        self._state_mask = (1 << size) - 1
        self._before = {touched: self._registers(places, touched) for touched in POSITIONS}

    def decide(self, counts: tuple[int, ...], touched: tuple[bool, ...]) -> tuple[int, int] | None:
        words = self._before[touched].copy()
        for word, count in zip(self._words, counts, strict=True):
            words[word] = count
        try:
            self._routine.call(words)
        except ExecutionError:
            return None
        latch = self._routine.latch
        command = sum((latch >> pin & 1) << bit for bit, pin in enumerate(self._pins))
        state = self._routine.words[self._state_word] >> self._state_shift & self._state_mask
        return state, command

    def _registers(self, places: Places, touched: tuple[bool, ...]) -> list[int]:
        words = [0, 0, 0] + [_JUNK] * (WORDS - 3)
        for bit in places.antennas:
            words[bit >> 4] &= ~(0b1111 << (bit & 12))
        for bit, bent in zip(places.antennas, touched, strict=True):
            words[bit >> 4] |= (not bent) << (bit & 15)
        return words
