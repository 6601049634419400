"""Begin a run in a new folder, or continue one; one trial in it, or a folder for each."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

from cgagen import __version__, files, genome
from cgagen.checkpoint import Best, Report
from cgagen.errors import RunError, StoppedError, StorageError
from cgagen.run import folder as run_folder
from cgagen.run.loop import (
    Job,
    Observer,
    Progress,
    WorldFactory,
    complete,
    run_trial,
    state_of,
)
from cgagen.run.record import RunRecord
from cgagen.run.sound import check_best, check_populations
from cgagen.run.stop import Stopped, never
from cgagen.run.workers import run_in_processes
from cgagen.shell import command
from cgagen.temporaries import sweep


@dataclass(frozen=True, slots=True)
class TrialOutcome:
    """What a trial came to.

    Attributes:
        trial: from 1.
        folder: where its files are.
        fixed: the reports on the fixed starts.
        best: the best individual on the fixed starts.
    """

    trial: int
    folder: Path
    fixed: tuple[Report, ...]
    best: Best


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a run came to.

    Attributes:
        folder: the run folder.
        trials: one or more.
        was_complete: nothing was left to do.
    """

    folder: Path
    trials: tuple[TrialOutcome, ...]
    was_complete: bool

    @property
    def best(self) -> TrialOutcome:
        """The trial with the best individual; of equals the first."""
        return max(self.trials, key=lambda trial: trial.best.fitness)

    @property
    def best_file(self) -> Path:
        """The file of the best individual of all trials."""
        return self.folder / run_folder.BEST


def _ignore(progress: Progress) -> None:
    """Watch nothing."""


def start(
    folder: Path,
    record: RunRecord,
    make_world: WorldFactory,
    *,
    workers: int = 1,
    observe: Observer = _ignore,
    stopped: Stopped = never,
) -> Outcome:
    """Run all trials of a record in a new folder.

    Args:
        folder: is created; may exist if it is empty.
        record: settings, inputs and versions.
        make_world: see `WorldFactory`.
        workers: threads for one trial, processes for several; changes no file.
        observe: is told after each generation.
        stopped: is asked before each generation.

    Raises:
        RunError: the folder holds something, or is in use.
        StorageError: the disk refused before the run could begin.
        StoppedError: interrupted; `resume` continues it.
    """
    run_folder.refuse_unless_free(folder, record)
    files.make_folder(folder)
    with run_folder.locked(folder):
        run_folder.refuse_unless_free(folder, record)
        sweep(folder)
        run_folder.write_beginning(folder, record)
        with _resumable(folder):
            return _run_all(folder, record, make_world, workers, observe, stopped)


def resume(
    folder: Path,
    make_world: Callable[[RunRecord], WorldFactory],
    *,
    workers: int = 1,
    observe: Observer = _ignore,
    stopped: Stopped = never,
) -> Outcome:
    """Continue a run from its checkpoints; a complete run stays as it is.

    Args:
        folder: a run folder.
        make_world: returns the factory of the world that the folder's record describes; is not
            called where nothing is left to do.
        workers: see `start`; need not be what the run began with.
        observe: see `start`.
        stopped: see `start`.

    Raises:
        RunError: no run, another version, edited or damaged files, or in use.
        StoppedError: interrupted again.
    """
    record = run_folder.read_record(folder)
    began_with = dict(record.versions).get("cgagen")
    if began_with != __version__:
        raise RunError(
            f"{folder}: was begun by cgagen {began_with}, and this is {__version__}, which may "
            f"decide otherwise; continue it with {began_with}, or start a new run"
        )
    with run_folder.locked(folder):
        sweep(folder)
        jobs = _jobs(folder, record)
        if _is_complete(folder, jobs):
            return _checked(folder, jobs, _outcome(folder, jobs, was_complete=True))
        for one in {folder, *(job.folder for job in jobs)}:
            run_folder.refuse_strangers(one)
        with _resumable(folder):
            return _run_all(folder, record, make_world(record), workers, observe, stopped)


def _checked(folder: Path, jobs: list[Job], outcome: Outcome) -> Outcome:
    """Return the outcome of a run that is done, if its files are whole.

    Raises:
        RunError: one is missing, cut, damaged or edited; the sentence names it.
    """
    states = {job.trial: state_of(job) for job in jobs}
    for job in jobs:
        check_populations(job.folder, states[job.trial], job.record.settings)
        complete(job, states[job.trial])
    check_best(folder / run_folder.BEST, states[outcome.best.trial])
    return outcome


@contextmanager
def _resumable(folder: Path) -> Iterator[None]:
    """Say of a full disk that the run can be resumed: its record is on the disk."""
    try:
        yield
    except StorageError as error:
        what = str(error).rpartition("; ")[0]  # without its advice: this folder is the right one
        raise StoppedError(
            f"{what}; free some space, then continue with `{command('resume', folder)}`"
        ) from error


def _jobs(folder: Path, record: RunRecord, threads: int = 1) -> list[Job]:
    """Return the trials of a run: the folder itself, or one folder each."""
    settings = record.settings
    if settings.trials == 1:
        return [Job(folder, record, folder, threads)]
    numbers = range(settings.first_trial, settings.first_trial + settings.trials)
    return [
        Job(
            run_folder.trial_folder(folder, number),
            replace(record, settings=replace(settings, first_trial=number, trials=1)),
            folder,
            threads=1,
        )
        for number in numbers
    ]


def _run_all(
    folder: Path,
    record: RunRecord,
    make_world: WorldFactory,
    workers: int,
    observe: Observer,
    stopped: Stopped,
) -> Outcome:
    """Run or continue every trial; the folder is locked."""
    jobs = _jobs(folder, record, workers)
    if len(jobs) == 1:
        run_trial(jobs[0], make_world, observe, stopped)
        return _outcome(folder, jobs, was_complete=False)
    for job in jobs:
        _prepare(job)
    if workers > 1:
        run_in_processes(jobs, make_world, workers, observe, stopped)
    else:
        for job in jobs:
            with run_folder.locked(job.folder):
                sweep(job.folder)
                run_trial(job, make_world, observe, stopped)
    outcome = _outcome(folder, jobs, was_complete=False)
    best = run_folder.best_genome(record, outcome.best.trial, outcome.best.best)
    files.write_text(outcome.best_file, genome.to_text(best))
    return outcome


def _prepare(job: Job) -> None:
    """Make sure that a trial's folder has begun, with the record that it must have."""
    if (job.folder / run_folder.RECORD).exists():
        if run_folder.read_record(job.folder).text != job.record.text:
            raise RunError(
                f"{job.folder}: belongs to a run with other settings; put back the right folder, "
                "or move it away to run this trial again"
            )
        return
    run_folder.refuse_unless_free(job.folder, job.record)
    files.make_folder(job.folder)
    run_folder.write_beginning(job.folder, job.record)


def _is_complete(folder: Path, jobs: list[Job]) -> bool:
    """Whether every trial has its last generation, and the folder its best genome."""
    if not (folder / run_folder.BEST).exists():
        return False
    return all(
        (job.folder / run_folder.CHECKPOINT).exists()
        and state_of(job).completed >= job.record.settings.generations
        for job in jobs
    )


def _outcome(folder: Path, jobs: list[Job], *, was_complete: bool) -> Outcome:
    """Return what the checkpoints of complete trials say."""
    trials = []
    for job in jobs:
        state = state_of(job)
        if state.best is None:
            raise ValueError(f"{job.folder}: the checkpoint of a complete trial has no best")
        trials.append(TrialOutcome(job.trial, job.folder, state.fixed, state.best))
    return Outcome(folder, tuple(trials), was_complete)
