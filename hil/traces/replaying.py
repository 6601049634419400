"""A trace on a target: three answers to each reading, the simulator's, the target's and the file's.

Zero tolerance: the first reading where they are not one is reported, and whom the simulator
contradicts.
"""

from dataclasses import dataclass, fields, replace

from hil.equivalence import Explain, Finding, Trial, Verdict, compare
from hil.roster import trouble_of
from hil.simulated import SimulatedTarget
from hil.subject import Subject
from hil.target import Observation, Target
from hil.traces.values import Sample, Trace, refused

TARGET, RECORDING = "target", "recording"


@dataclass
class Replay(Trial):
    """What came of a trace on one target.

    Attributes:
        trace: name of its file.
        index: of the first reading that is not agreed on, from 0; None for none.
        time_ns: of that reading, since the first.
        recorded: the decision in the file, as far as it is known there.
        contradicted: whom the simulator contradicts there: `target`, `recording` or both.
        unproven: readings that the target cannot be given, or is not, because they are too near
            to a threshold for its timers; from 0. Nothing is known of them.
    """

    trace: str = ""
    index: int | None = None
    time_ns: int | None = None
    recorded: Observation | None = None
    contradicted: tuple[str, ...] = ()
    unproven: tuple[int, ...] = ()


def replay(
    subject: Subject, target: Target, trace: Trace, explain: Explain | None = None
) -> Replay:
    """Apply a trace to an open target, and compare with the simulator and with the file.

    Args:
        subject: what is on trial.
        target: open, and known to be what it is to be.
        trace: of the subject's robot.
        explain: names lines of PBASIC for the first difference and the smallest.

    Raises:
        TraceError: the trace is of another robot, or its decisions are of another genome.
    """
    check_trace(trace, subject)
    trial = compare(subject, target, trace.stimuli, explain)
    result = Replay(**{one.name: getattr(trial, one.name) for one in fields(Trial)})
    result.trace = trace.name
    admits = getattr(target, "admits", None)
    if admits is not None:
        result.unproven = tuple(n for n, one in enumerate(trace.stimuli) if not admits(one))
    expected = SimulatedTarget(subject).decide_all(trace.stimuli)
    wrong = _first_contradiction(trace, expected)
    first = trial.findings[0] if trial.findings else None
    places = [one for one in (wrong, first.index if first else None) if one is not None]
    if not places:
        return result
    result.index = index = min(places)
    sample = trace.samples[index]
    result.time_ns = sample.time_ns
    result.recorded = _recorded(sample)
    at_target = first is not None and first.index == index
    who = ((TARGET, at_target), (RECORDING, not _agrees(sample, expected[index])))
    result.contradicted = tuple(name for name, holds in who if holds)
    finding = first if first is not None and at_target else None
    finding = finding or _of_recording(sample, expected[index], index)
    if explain is not None:
        finding = _explained(finding, explain)
    result.smallest = result.smallest or finding
    result.findings = [finding, *(one for one in trial.findings if one.index != index)]
    result.verdict = Verdict.FAIL
    result.reason = _sentence(result, subject, sample, finding)
    return result


def check_trace(trace: Trace, subject: Subject) -> None:
    """Refuse a trace that says nothing about a subject.

    Raises:
        TraceError: it is of another robot, or its decisions are of another genome.
    """
    robot, origin = subject.robot, trace.origin
    for sample in trace.samples:
        odd = trouble_of(sample.stimulus, robot)
        if odd:
            raise refused(trace.name, sample.where, f"the reading {odd}", "name its own robot")
    if origin is None or not trace.decided or origin.genome is None:
        return
    genome = subject.genome.digest if subject.genome else None
    if genome != origin.genome:
        raise refused(
            trace.name,
            "",
            f"its decisions are those of genome {origin.genome[:8]}, and on trial is "
            f"{genome[:8] if genome else 'a prey'}",
            "name that genome, or convert the trace with --readings-only",
        )


def _agrees(sample: Sample, expected: Observation) -> bool:
    return sample.state in (None, expected.state) and sample.command in (None, expected.command)


def _first_contradiction(trace: Trace, expected: list[Observation]) -> int | None:
    pairs = zip(trace.samples, expected, strict=True)
    return next(
        (n for n, (sample, wanted) in enumerate(pairs) if not _agrees(sample, wanted)), None
    )


def _recorded(sample: Sample) -> Observation | None:
    if not sample.decided:
        return None
    command = -1 if sample.command is None else sample.command
    return Observation(sample.seq, command, sample.state)


def _of_recording(sample: Sample, expected: Observation, index: int) -> Finding:
    recorded = _recorded(sample)
    why = f"the trace has {_words(recorded)}, the simulator {_words(expected)}"
    return Finding(sample.stimulus, expected, recorded, why, index=index, by="recorded")


def _explained(finding: Finding, explain: Explain) -> Finding:
    return replace(finding, lines=finding.lines or explain(finding))


def _words(seen: Observation | None) -> str:
    """Return a decision in words.

    >>> _words(Observation(1, 3, 15)), _words(Observation(1, -1, 15)), _words(None)
    ('state 15, command 3', 'state 15', 'nothing')
    """
    if seen is None:
        return "nothing"
    words = [] if seen.state is None else [f"state {seen.state}"]
    return ", ".join([*words, *([f"command {seen.command}"] if seen.command >= 0 else [])])


def _sentence(result: Replay, subject: Subject, sample: Sample, finding: Finding) -> str:
    """Return the report of the first divergence in one sentence."""
    where = f"{result.trace}: {sample.where}: " if sample.where else f"{result.trace}: "
    words = (
        f"{where}reading {(result.index or 0) + 1} at {sample.time_ns / 1e9:.6f} s, "
        f"{sample.stimulus.text()}: {finding.why}"
    )
    movement = subject.movement(finding.expected.command)
    words += f"; {movement} would be right"
    if TARGET in result.contradicted:
        words += f", and the trace has {_words(result.recorded)}"
    if finding.lines:
        words += f"; decided in {finding.lines[0]}"
    return words
