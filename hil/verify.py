"""All checks of one robot, as `cgagen verify` and the tests run them."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import islice
from pathlib import Path

from cgagen.errors import CgagenError, RigError, SourceError, TargetTimeout
from hil import untried
from hil.benches import Counted, looking
from hil.conduct import try_conduct
from hil.emulated import MOST_SONAR_COUNTS, PinsTarget
from hil.equivalence import Finding, Heard, Trial, Verdict, blocked, compare
from hil.explain import table_line
from hil.explainers import explainer
from hil.outcome import Report
from hil.proving import proof_of
from hil.registers import Compile, RegisterTarget
from hil.simulated import commands_by_state
from hil.stimuli import SEED, Level, every_state, neutral, sample, stimuli_of, thresholds
from hil.subject import CHIPS, Subject
from hil.target import Observation, Stimulus, Target
from hil.timing import try_timing
from hil.traces import Trace, replay
from hil.traces.replaying import check_trace
from hil.walks import try_walks
from hil.wired_walks import try_legs

BOUNDARY_PINS = 200
"""Readings by chance that go through the pins in the boundary level. Choice."""

SAMPLED_CELLS = 6_000
"""Cells of the sensor space that are tried below the exhaustive level. Choice."""


def verify(
    subject: Subject,
    compile_source: Compile,
    level: Level = Level.EXHAUSTIVE,
    seed: int = SEED,
    others: Sequence[Callable[[], Target]] = (),
    readings: Sequence[Stimulus] | None = None,
    traces: Sequence[Trace] = (),
    legs: str | None = None,
) -> Report:
    """Try the programs of a robot on the emulator, and on other targets.

    Args:
        subject: what is on trial.
        compile_source: the tokenizer.
        level: how much is tried.
        seed: for what is chosen by chance.
        others: makers of further targets, not yet open.
        readings: these alone instead of the level's, and nothing else but table and sources.
        traces: to be replayed on the emulator and on all other targets.
        legs: the locomotion controller's port, as `hil.wired_walks` has it; it walks.

    Raises:
        TraceError: a trace is of another robot or genome.
    """
    for trace in traces:
        check_trace(trace, subject)
    report, counted = Report(subject, level, seed), Counted()
    fast = pin_readings(subject, level, seed) if readings is None else readings
    every = stimuli_of(subject.robot, level, seed) if readings is None else readings
    with looking(counted):
        report.add("sources", try_sources(subject, compile_source))
        with_registers(report, subject, compile_source, every)
        if 0 in report.trials["sources"].agreed.values():
            _try_edited(report, subject, compile_source, every, fast)
        if readings is None:
            with_cells(report, subject, compile_source)
        ear = report.evidence.ear
        report.add("emulator", try_target(subject, lambda: PinsTarget(subject), fast, ear))
        if readings is None:
            _with_walks(report, subject, compile_source)
        else:
            report.add_all(untried.beside_readings())
        for trace in traces:
            _with_trace(report, subject, lambda: PinsTarget(subject), trace)
    asked = [make() for make in others]
    for make, target in zip(others, asked, strict=True):
        trial = try_target(subject, partial(_itself, target), fast, ear, widened=readings is None)
        report.add(trial.target, trial)
        for trace in traces:
            _with_trace(report, subject, make, trace)
    if legs is not None:
        report.add("legs", try_legs(legs, subject))
    report.add_all(untried.of_build(subject))
    report.add_all(untried.of_wires(asked, legs))
    report.evidence.count(counted, compile_source)
    return report


def with_cells(report: Report, subject: Subject, compile_source: Compile) -> None:
    """Try the cells of the sensor space: all of them, which is a proof, or a sample."""
    count = None if report.level is Level.EXHAUSTIVE else SAMPLED_CELLS
    proof = proof_of(subject, compile_source, count, report.seed)
    report.evidence.proof(proof)
    report.add("cells", proof.trial())


def _with_trace(report: Report, subject: Subject, make: Callable[[], Target], trace: Trace) -> None:
    """Replay a trace on a target."""
    target = make()
    try:
        target.open()
        trial: Trial = replay(subject, target, trace, report.explain)
    except RigError as error:
        trial = blocked(target.url, error)
    finally:
        target.close()
    report.add(f"{Path(trace.name).name} on {target.url}", trial)


def _with_walks(report: Report, subject: Subject, compile_source: Compile) -> None:
    """Try the movements, the robot's time, and its conduct on all lines."""
    report.add("movements", try_walks(subject))
    trial, report.evidence.timing = try_timing(subject)
    report.add("timing", trial)
    report.add("conduct", try_conduct(subject))


def pin_readings(subject: Subject, level: Level, seed: int = SEED) -> list[Stimulus]:
    """Return the readings that go through the pins, or a wire."""
    robot = subject.robot
    wanted = [neutral(robot), *every_state(robot).values(), *thresholds(robot)]
    if level.wide:
        drawn = sample(robot, 10 * BOUNDARY_PINS, seed)
        most = MOST_SONAR_COUNTS
        wanted += islice(
            (one for one in drawn if max(*one.sonars, *one.lights) <= most), BOUNDARY_PINS
        )
    return list(dict.fromkeys(wanted))


def try_sources(subject: Subject, compile_source: Compile) -> Trial:
    """Compile both sources and compare the bytes with those of the images."""
    trial = Trial("sources")
    for number, name in enumerate(CHIPS):
        file = subject.files[name]
        try:
            compiled = compile_source(subject.sources[name], file)
        except SourceError as error:
            trial.verdict, trial.reason = Verdict.FAIL, str(error)
            return trial
        trial.tried[number], trial.agreed[number] = 1, 1
        ours, theirs = compiled.image.eeprom, subject.images[name].eeprom
        if ours != theirs:
            at = next(n for n in range(len(ours)) if ours[n] != theirs[n])
            trial.agreed[number] = 0
            trial.verdict = Verdict.FAIL
            trial.reason = (
                f"{subject.where}: {file} compiles to other bytes than {name}.bin holds, the first "
                f"at {at}: {ours[at]:02X} against {theirs[at]:02X}; build both again"
            )
    return trial


def _try_edited(
    report: Report,
    subject: Subject,
    compile_source: Compile,
    every: Sequence[Stimulus],
    fast: Sequence[Stimulus],
) -> None:
    """Try what the sources compile to, where the images are something else."""
    images = dict(subject.images)
    for number, name in enumerate(CHIPS):
        if report.trials["sources"].agreed.get(number) == 0:
            images[name] = compile_source(subject.sources[name], subject.files[name]).image
    edited = replace(subject, images=images)
    if images["main"] is not subject.images["main"]:
        with_registers(report, edited, compile_source, every, "source ")
        report.add("source emulator", try_target(edited, lambda: PinsTarget(edited), fast))
    if images["locomotion"] is not subject.images["locomotion"]:
        report.add("source movements", try_walks(edited))


def with_registers(
    report: Report,
    subject: Subject,
    compile_source: Compile,
    every: Sequence[Stimulus],
    prefix: str = "",
) -> None:
    """Try the table and all readings from a snapshot behind sensing."""
    try:
        target = RegisterTarget(subject, compile_source)
        target.open()
    except CgagenError as error:
        trial = Trial("emulator:registers", Verdict.UNPROVEN, str(error))
        if isinstance(error, TargetTimeout):
            trial = blocked("emulator:registers", error)
        report.add(f"{prefix}table", untried.table_behind(str(error)))
        report.add(f"{prefix}registers", trial)
        return
    table = try_table(subject, target)
    report.add(f"{prefix}table", table)
    explain = explainer(subject, target)
    ear = None if prefix else report.evidence.ear(target.url)
    if not prefix:
        report.evidence.table(table)
        report.explain = explain
    trial = compare(subject, target, every, explain, ear)
    report.add(f"{prefix}registers", trial)


def try_table(subject: Subject, target: RegisterTarget) -> Trial:
    """Compare the command of every state, those too that no reading leads to."""
    trial = Trial("emulator:table")
    for state, wanted in enumerate(commands_by_state(subject)):
        trial.tried[state] = 1
        try:
            found = target.look_up(state)
        except RigError as error:
            trial.verdict, trial.reason = blocked(trial.target, error).verdict, str(error)
            return trial
        trial.agreed[state] = int(found == wanted)
        if found != wanted:
            why = f"the table answers state {state} with command {found}, the genome with {wanted}"
            line = table_line(subject.sources["main"], subject.files["main"], subject.role, state)
            trial.findings.append(
                Finding(
                    None,
                    Observation(0, wanted, state),
                    Observation(0, found, state),
                    why,
                    (line,) if line else (),
                )
            )
    if trial.findings:
        trial.smallest = trial.findings[0]
        trial.verdict, trial.reason = Verdict.FAIL, trial.smallest.why
    return trial


def _itself(target: Target) -> Target:
    return target


def with_beside(target: Target, readings: Sequence[Stimulus]) -> list[Stimulus]:
    """Return readings with those that an open target has in place of what it cannot be given."""
    more: Callable[[], list[Stimulus]] | None = getattr(target, "beside", None)
    return list(dict.fromkeys([*readings, *(more() if more else ())]))


def try_target(
    subject: Subject,
    make: Callable[[], Target],
    stimuli: Sequence[Stimulus],
    ear: Callable[[str], Heard] | None = None,
    widened: bool = False,
) -> Trial:
    """Open a target, compare it with the simulator, and close it.

    Args:
        subject: what it is to hold.
        make: makes it.
        stimuli: in this order.
        ear: given the target's name, returns what is told of each answer.
        widened: try what the target itself has to add, too.
    """
    target = make()
    try:
        target.open()
        stimuli = with_beside(target, stimuli) if widened else stimuli
        return compare(subject, target, stimuli, heard=ear(target.url) if ear else None)
    except RigError as error:
        return blocked(target.url, error)
    finally:
        target.close()
