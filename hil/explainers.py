"""Who names the lines of PBASIC behind a difference: the program itself, followed once more."""

from dataclasses import replace

from cgagen.errors import CgagenError, TargetTimeout
from cgagen.words import Role
from hil.equivalence import Explain, Finding
from hil.explain import Line, deciding_lines, last_lines, table_line
from hil.registers import Compile, RegisterTarget
from hil.subject import Subject
from hil.target import Observation, Stimulus


def explainer_elsewhere(subject: Subject, compile_source: Compile) -> Explain:
    """Return what names the lines behind a difference that another target has shown.

    The program decides once more, from its registers. Where that cannot be done, or it decides
    otherwise there, no line is named.
    """

    def explain(finding: Finding) -> tuple[Line, ...]:
        observed, stimulus = finding.observed, finding.stimulus
        if stimulus is None:
            return ()
        try:
            with RegisterTarget(subject, compile_source) as target:
                seen = _decided(target, stimulus)
                if (seen is None) != (observed is None):
                    return ()
                if seen is not None and observed is not None:
                    differs = observed.state not in (None, seen.state)
                    if differs or seen.command != observed.command:
                        return ()
                return explainer(subject, target)(replace(finding, observed=seen))
        except CgagenError:
            return ()

    return explain


def _decided(target: RegisterTarget, stimulus: Stimulus) -> Observation | None:
    """Return the decision; None where it comes to none."""
    try:
        return target.decide(stimulus)
    except TargetTimeout:
        return None


def explainer(subject: Subject, target: RegisterTarget) -> Explain:
    """Return what names the lines behind a difference."""
    source, file = subject.sources["main"], subject.files["main"]

    def explain(finding: Finding) -> tuple[Line, ...]:
        expected, observed = finding.expected, finding.observed
        if finding.stimulus is None or expected.state is None:
            return ()
        if observed is None:
            return last_lines(source, file, target.trace(finding.stimulus))
        if observed.state == expected.state:
            line = table_line(source, file, subject.role, expected.state)
            return (line,) if line else ()
        variable = "state"
        if subject.role is Role.PREDATOR and observed.state is not None:
            same = observed.state // 8 == expected.state // 8
            variable = "target" if same else "obstacle"
        stimulus = finding.stimulus
        counts = (*stimulus.sonars, *stimulus.lights)
        return deciding_lines(source, file, target.trace(stimulus), variable, counts)

    return explain
