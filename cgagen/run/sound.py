"""Whether the files of a run say what its settings and its checkpoint say.

The checkpoint vouches for all others: the two tables of reports and the best genome follow from
it to the letter, and the figures of a written population are those of its reports. So what is cut
or damaged is found and named before anybody goes on from it.
"""

import csv
import math
from dataclasses import replace
from pathlib import Path

from cgagen import genome
from cgagen.checkpoint import Checkpoint, Report
from cgagen.errors import GenomeError, RunError
from cgagen.inputs import RUN_TABLE, read_bytes, read_text
from cgagen.run import folder as run_folder
from cgagen.run.record import RunSettings
from cgagen.shown import shown

SLACK = 1e-9
"""Of a mean against the least and the most of what it is a mean of. Choice: rounding."""

ROW_BYTES = 1_024
"""Of a row of a written population at most; choice: an honest one has some 260."""


def trouble_of(state: Checkpoint, settings: RunSettings) -> str:
    """Return what is wrong with the numbers of a checkpoint; "" where nothing is.

    Args:
        state: of a trial.
        settings: of its run.
    """
    if state.completed > settings.generations:
        return f"it has {state.completed} generations, and the run {settings.generations}"
    wanted = [one for one in range(1, state.completed + 1) if settings.is_evaluated(one)]
    if [report.generation for report in state.fixed] != wanted:
        return "its reports on the fixed starts are not those of the run's generations"
    for report in (*state.training, *state.fixed):
        wrong = _wrong_report(report)
        if wrong:
            return f"its report on generation {report.generation} says {wrong}"
    return _wrong_best(state)


def _wrong_report(report: Report) -> str:
    for name, value in zip(Report._fields[1:], report[1:], strict=True):
        if not math.isfinite(value) or value < 0:
            return f"{name} is {value}"
    if not report.worst - SLACK <= report.mean <= report.best + SLACK:
        return f"a mean of {report.mean}, which is not between {report.worst} and {report.best}"
    return "" if report.captured <= 1 else f"captured is {report.captured}, a share up to 1"


def _wrong_best(state: Checkpoint) -> str:
    """Return why the best individual is not the one of the reports; the first of equals is."""
    if not state.fixed:
        return "" if state.best is None else "it has a best individual before any was found"
    if state.best is None:
        return "it has no best individual"
    first = max(state.fixed, key=lambda report: report.best)
    said = (state.best.generation, state.best.fitness)
    if said != (first.generation, first.best):
        return (
            f"its best individual is of generation {said[0]} with fitness {said[1]}, and its "
            f"reports say {first.generation} with {first.best}"
        )
    captured = state.best.captured
    return "" if 0 <= captured <= 1 else f"its best individual captures a share of {captured}"


def check_populations(folder: Path, state: Checkpoint, settings: RunSettings) -> None:
    """Make sure of the written populations of the generations that are done.

    Raises:
        RunError: one is missing, cut or edited.
    """
    fixed = {report.generation: report for report in state.fixed}
    for number in range(1, state.completed + 1):
        if settings.is_written(number):
            path = folder / run_folder.population_name(number)
            wrong = _wrong_population(path, settings, (state.training[number - 1], fixed[number]))
            if wrong:
                raise RunError(
                    f"{path}: is not as the run wrote it ({wrong}); put it back, or evolve the "
                    "same seed again in another folder"
                )


def _wrong_population(path: Path, settings: RunSettings, reports: tuple[Report, Report]) -> str:
    count = settings.evolution.population
    kind = replace(RUN_TABLE, most=max(RUN_TABLE.most, count * ROW_BYTES))
    head, *rows = csv.reader(read_text(path, kind).splitlines() or [""])
    if ",".join(head) != run_folder.POPULATION_HEAD:
        return "its first line is another"
    if len(rows) != count:
        return f"it has {len(rows)} individuals, not {count}"
    columns: tuple[list[float], ...] = ([], [], [])
    for index, row in enumerate(rows):
        try:
            number, *numbers, bits = row
            values = [float(one) for one in numbers]
        except ValueError:
            return f"line {index + 2} is {shown(','.join(row))}"
        if number != str(index) or len(values) != 3:
            return f"line {index + 2} is {shown(','.join(row))}"
        if len(bits) != settings.evolution.bits or set(bits) - {"0", "1"}:
            return f"the genes in line {index + 2} are {shown(bits)}"
        for column, value in zip(columns, values, strict=True):
            column.append(value)
    return _wrong_columns(columns, reports)


def _wrong_columns(columns: tuple[list[float], ...], reports: tuple[Report, Report]) -> str:
    training, fixed, captured = columns
    found = (max(training), min(training), max(fixed), min(fixed), math.fsum(captured))
    one, other = reports
    wanted = (one.best, one.worst, other.best, other.worst, other.captured * len(captured))
    means = (math.fsum(training) / len(training), math.fsum(fixed) / len(fixed))
    if found[:4] != wanted[:4] or means != (one.mean, other.mean):
        return "its fitness is not that of the reports on its generation"
    return "" if math.isclose(found[4], wanted[4], abs_tol=SLACK) else "its captures are others"


def check_tables(folder: Path, state: Checkpoint) -> None:
    """Make sure that what a trial that is done has written follows from its checkpoint.

    Args:
        folder: of the trial.
        state: its last.

    Raises:
        RunError: a table or the best genome is missing, cut or edited.
    """
    for name, reports in ((run_folder.TRAINING, state.training), (run_folder.FITNESS, state.fixed)):
        text = run_folder.reports_csv(reports)
        kind = replace(RUN_TABLE, most=max(RUN_TABLE.most, 2 * len(text)))
        content = read_bytes(folder / name, kind)
        if content != text.encode():
            cut = text.encode().startswith(content)
            raise _other(folder / name, f"is cut behind {len(content)} bytes" if cut else "")
    check_best(folder / run_folder.BEST, state)


def check_best(path: Path, state: Checkpoint) -> None:
    """Make sure that a genome is the best one of a trial.

    Raises:
        RunError: it is missing, cut or edited.
    """
    try:
        found = genome.load(path)
    except GenomeError as error:
        raise RunError(f"{error}; or move it away and resume, which writes it again") from error
    best = state.best
    said = (found.origin.trial, found.origin.generation, found.origin.fitness)
    if best is None or said != (state.trial, best.generation, best.fitness):
        raise _other(path)
    if found.array().tolist() != best.bits.tolist():
        raise _other(path)


def _other(path: Path, how: str = "") -> RunError:
    return RunError(
        f"{path}: {how or 'is damaged or edited'}, for the checkpoint stands for another content; "
        "put it back, or move it away and resume, which writes it again"
    )
