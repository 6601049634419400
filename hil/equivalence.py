"""Two targets, one list of stimuli, a verdict.

PASS: all answers are alike. FAIL: one is not, or a living target does not answer. BLOCKED: the
bench is sick, so nothing is known. UNPROVEN: nothing could be applied. NOT TRIED: it was left
out of this run, and the row says why; the whole is UNPROVEN then.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum

from cgagen.errors import MismatchError, RigError, TargetTimeout
from hil.explain import Line
from hil.simulated import SimulatedTarget
from hil.stimuli import neutral, weight, with_values
from hil.subject import Subject
from hil.target import Observation, Stimulus, Target

MOST_FINDINGS = 20
"""Differences that are kept; all are counted. Choice."""

ASK_AGAIN = 3
"""How often a question is repeated whose answer was to another. Choice."""


class Verdict(StrEnum):
    """What is known after a trial."""

    PASS = "PASS"
    FAIL = "FAIL"
    BLOCKED = "BLOCKED"
    UNPROVEN = "UNPROVEN"
    NOT_TRIED = "NOT TRIED"

    @property
    def exit_code(self) -> int:
        """The command line's."""
        return {"PASS": 0, "BLOCKED": 7, "FAIL": 9}.get(self.value, 11)


@dataclass(frozen=True, slots=True)
class Finding:
    """One answer that is not the reference's.

    Attributes:
        stimulus: what was sensed; None where a table was read without sensing.
        expected: the reference's answer.
        observed: the target's; None where there was none.
        why: a sentence.
        lines: lines of PBASIC that decided it, the likeliest first.
        index: which of the stimuli of the trial it was, from 0; None where it was none of them.
        by: how the other answer is known: observed, or recorded in a trace.
    """

    stimulus: Stimulus | None
    expected: Observation
    observed: Observation | None
    why: str
    lines: tuple[Line, ...] = ()
    index: int | None = None
    by: str = "observed"


@dataclass
class Trial:
    """What came of a list of stimuli on one target.

    Attributes:
        target: its URL.
        verdict: see above.
        reason: why it is not PASS; "" for PASS.
        tried: by state, how many stimuli were answered.
        agreed: by state, how many answers were right.
        left_out: stimuli that the target cannot be given.
        stale: answers to other questions.
        note: what the target says of itself, such as what it cannot show; "" for nothing.
        findings: the first differences.
        smallest: the smallest of all, made smaller still where that could be.
    """

    target: str
    verdict: Verdict = Verdict.PASS
    reason: str = ""
    tried: dict[int, int] = field(default_factory=dict)
    agreed: dict[int, int] = field(default_factory=dict)
    left_out: int = 0
    stale: int = 0
    note: str = ""
    findings: list[Finding] = field(default_factory=list)
    smallest: Finding | None = None

    @property
    def decisions(self) -> int:
        """How many stimuli were answered."""
        return sum(self.tried.values())


Explain = Callable[[Finding], tuple[Line, ...]]
"""Names the lines of PBASIC that decided a difference, the likeliest first."""

Heard = Callable[[Stimulus, Observation, Observation | None, bool], None]
"""Told of each answer: the stimulus, what was expected and observed, and whether they agree."""


def worst(verdicts: Iterable[Verdict]) -> Verdict:
    """Return what several trials come to: FAIL before BLOCKED before UNPROVEN before PASS.

    Of a whole in which something was not tried nothing better is known than UNPROVEN.

    >>> str(worst([Verdict.PASS, Verdict.NOT_TRIED])), str(worst([]))
    ('UNPROVEN', 'UNPROVEN')
    """
    order = [Verdict.FAIL, Verdict.BLOCKED, Verdict.UNPROVEN, Verdict.NOT_TRIED, Verdict.PASS]
    found = min(verdicts, key=order.index, default=Verdict.UNPROVEN)
    return Verdict.UNPROVEN if found is Verdict.NOT_TRIED else found


def not_tried(target: str, reason: str) -> Trial:
    """Return the row of what a run leaves out.

    Args:
        target: on which it would have been tried.
        reason: why it was not, and what would have it tried.
    """
    return Trial(target, Verdict.NOT_TRIED, reason)


def compare(
    subject: Subject,
    target: Target,
    stimuli: Sequence[Stimulus],
    explain: Explain | None = None,
    heard: Heard | None = None,
) -> Trial:
    """Apply all stimuli to an open target and compare its answers with the simulator's.

    Args:
        subject: what is on trial.
        target: open, and known to be what it is to be.
        stimuli: in this order.
        explain: names lines for the smallest difference.
        heard: told of each answer.
    """
    trial = Trial(target.url, note=getattr(target, "note", ""))
    admits = getattr(target, "admits", None)
    places = [n for n, one in enumerate(stimuli) if admits is None or admits(one)]
    wanted = [stimuli[n] for n in places]
    trial.left_out = len(stimuli) - len(wanted)
    expected = SimulatedTarget(subject).decide_all(wanted)
    asker = _Asker(target, heard)
    stale = target.stale
    try:
        for place, stimulus, reference in zip(places, wanted, expected, strict=True):
            finding = asker.differs(stimulus, reference)
            finding = finding and replace(finding, index=place)
            _count(trial, reference.state or 0, finding)
            if finding is not None and finding.observed is None:
                break
        asker.heard = None
        trial.smallest = _smallest(subject, asker, trial.findings)
    except RigError as error:
        trial.verdict, trial.reason = Verdict.BLOCKED, str(error)
    trial.stale = asker.stale + target.stale - stale
    if trial.findings:
        trial.smallest = trial.smallest or min(trial.findings, key=_weight_in(subject))
        if explain is not None:
            trial.smallest = replace(trial.smallest, lines=explain(trial.smallest))
        trial.verdict, trial.reason = Verdict.FAIL, trial.smallest.why
    elif trial.verdict is Verdict.PASS and not trial.decisions:
        trial.verdict = Verdict.UNPROVEN
        trial.reason = "no stimulus could be applied, so nothing is known"
    return trial


def blocked(target: str, error: RigError) -> Trial:
    """Return the trial of a target that could not be opened.

    A program that hangs is not a sick bench: `TargetTimeout` is FAIL.
    """
    verdict = Verdict.FAIL if isinstance(error, TargetTimeout) else Verdict.BLOCKED
    return Trial(target, verdict, str(error))


class _Asker:
    """Asks a target and makes sure that the answer is to the question."""

    def __init__(self, target: Target, heard: Heard | None = None) -> None:
        self.stale = 0
        self.heard = heard
        self._target = target
        self._last = -1

    def differs(self, stimulus: Stimulus, expected: Observation) -> Finding | None:
        """Return what is wrong with the target's answer; None for nothing."""
        observed: Observation | None
        try:
            answer = self._ask(stimulus)
            observed, why = answer, _difference(stimulus, expected, answer)
        except TargetTimeout as error:
            observed, why = None, str(error)
        except MismatchError as error:
            observed, why = Observation(0, -1), str(error)
        if self.heard is not None:
            self.heard(stimulus, expected, observed, not why)
        return Finding(stimulus, expected, observed, why) if why else None

    def _ask(self, stimulus: Stimulus) -> Observation:
        for _ in range(ASK_AGAIN):
            observed = self._target.decide(stimulus)
            if observed.seq > self._last:
                self._last = observed.seq
                return observed
            self.stale += 1
        raise RigError(
            f"{self._target.url}: answers question {observed.seq} again and again, after "
            f"{self._last} was answered; reset the target"
        )


def _difference(stimulus: Stimulus, expected: Observation, observed: Observation) -> str:
    if observed.counts not in (None, stimulus):
        seen = observed.counts.text() if observed.counts else ""
        return f"the program measured {seen} where {stimulus.text()} was presented"
    if None not in (observed.state, expected.state) and observed.state != expected.state:
        return (
            f"the program sees state {observed.state} (command {observed.command}), the simulator "
            f"state {expected.state} (command {expected.command})"
        )
    if observed.command != expected.command:
        return (
            f"the program answers state {expected.state} with command {observed.command}, "
            f"the simulator with {expected.command}"
        )
    return ""


def _count(trial: Trial, state: int, finding: Finding | None) -> None:
    trial.tried[state] = trial.tried.get(state, 0) + 1
    trial.agreed[state] = trial.agreed.get(state, 0) + (finding is None)
    if finding is not None and len(trial.findings) < MOST_FINDINGS:
        trial.findings.append(finding)


def _smallest(subject: Subject, asker: _Asker, findings: Sequence[Finding]) -> Finding | None:
    """Return the smallest difference, with every sensor neutral that need not be otherwise."""
    if not findings:
        return None
    small = min(findings, key=_weight_in(subject))
    if small.observed is None:
        return small
    plain = neutral(subject.robot)
    defaults = (*plain.sonars, *plain.lights)
    reference = SimulatedTarget(subject)
    tries = [_with_value(index, value) for index, value in enumerate(defaults)]
    tries += [_untouched(0), _untouched(1)]
    for simpler in tries:
        stimulus = simpler(small.stimulus) if small.stimulus else None
        if stimulus is not None and stimulus != small.stimulus:
            small = asker.differs(stimulus, reference.decide(stimulus)) or small
    return small


def _weight_in(subject: Subject) -> Callable[[Finding], tuple[int, Stimulus]]:
    return lambda one: weight(subject.robot, one.stimulus or neutral(subject.robot))


def _with_value(index: int, value: int) -> Callable[[Stimulus], Stimulus]:
    """Return what puts one count to a value."""
    return lambda stimulus: with_values(stimulus, {index: value})


def _untouched(side: int) -> Callable[[Stimulus], Stimulus]:
    def change(stimulus: Stimulus) -> Stimulus:
        left, right = stimulus.touched
        touched = (False, right) if side == 0 else (left, False)
        return Stimulus(stimulus.sonars, touched, stimulus.lights)

    return change
