"""One trial: generation after generation, with a checkpoint at every tenth or every 30 s."""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from cgagen import checkpoint, files, genome
from cgagen.checkpoint import Best, Checkpoint, Report
from cgagen.errors import StoppedError
from cgagen.evolve import Bits, first_generation, next_generation
from cgagen.run import folder as run_folder
from cgagen.run.record import RunRecord
from cgagen.run.sound import check_populations, check_tables, trouble_of
from cgagen.run.stop import Stopped
from cgagen.run.streams import Purpose, stream
from cgagen.shell import command

SAVE_EVERY = 10
"""Generations between two checkpoints. choice: a few per cent of the time of a trial."""

SAVE_AFTER_S = 30.0
"""Seconds after which one is due in any case. choice: what a user can bear to lose."""


class Scores(Protocol):
    """What a world says of a population, one value per individual."""

    @property
    def fitness(self) -> NDArray[np.float64]:
        """Mean step score over all starts, arena units, shape (individuals,)."""

    @property
    def captured(self) -> NDArray[np.float64]:
        """Share of the starts that ended in a capture, 0 to 1, shape (individuals,)."""


class World(Protocol):
    """Where individuals are tried out. The same arguments give the same scores, bit for bit."""

    def draw_starts(self, rng: np.random.Generator, count: int) -> NDArray[np.float64]:
        """Return random starts, shape (count, 8); their meaning is the world's business."""

    def evaluate(self, bits: Bits, starts: NDArray[np.float64]) -> Scores:
        """Run every individual from every start."""

    def close(self) -> None:
        """Give back threads; the world is not used again."""


WorldFactory = Callable[[int], World]
"""Makes a world with that many threads. Picklable, where trials run in processes."""


@dataclass(frozen=True, slots=True)
class Progress:
    """What an observer is told after each generation.

    Attributes:
        trial: from 1.
        generation: the one that is done, from 1.
        generations: how many there are.
        mean: mean fitness on the generation's own starts, arena units.
        steps_per_second: world steps of this trial since it was started or resumed.
        seconds_left: of this trial, at that rate.
    """

    trial: int
    generation: int
    generations: int
    mean: float
    steps_per_second: float
    seconds_left: float


Observer = Callable[[Progress], None]


@dataclass(frozen=True, slots=True)
class Job:
    """One trial to be run or continued.

    Attributes:
        folder: its run folder, whose record exists.
        record: settings and inputs, with this one trial.
        resume_folder: the folder that a user resumes: this one, or the one above of several.
        threads: for the world.
    """

    folder: Path
    record: RunRecord
    resume_folder: Path
    threads: int

    @property
    def trial(self) -> int:
        """Number of the trial, from 1."""
        return self.record.settings.first_trial


def state_of(job: Job) -> Checkpoint:
    """Return the state to go on from: the checkpoint's, or the first population.

    Raises:
        RunError: there is a checkpoint and it cannot be used.
    """
    settings = job.record.settings
    shape = (settings.evolution.population, settings.evolution.bits)
    path = job.folder / run_folder.CHECKPOINT
    if path.exists():
        state = checkpoint.restore(path, job.record.digest, job.trial, shape)
        trouble = trouble_of(state, settings)
        if trouble:
            raise checkpoint.damaged(str(path), trouble)
        return state
    rng = stream(settings.seed, job.trial, 0, Purpose.POPULATION)
    return Checkpoint(job.record.digest, job.trial, first_generation(settings.evolution, rng))


def run_trial(job: Job, make_world: WorldFactory, observe: Observer, stopped: Stopped) -> None:
    """Run a trial to its end, from its checkpoint if it has one. The folder must be locked.

    Raises:
        StoppedError: `stopped` said so; the folder can be resumed.
        StorageError: the disk refused; the last checkpoint is whole.
        RunError: the checkpoint cannot be used.
    """
    state = state_of(job)
    last = job.record.settings.generations
    check_populations(job.folder, state, job.record.settings)
    if state.completed >= last:
        complete(job, state)
        return
    world = make_world(job.threads)
    try:
        state = _run(job, state, world, observe, stopped)
    finally:
        world.close()
    if state.completed < last:
        raise StoppedError(
            f"{job.folder}: stopped after generation {state.completed} of {last}; "
            f"continue with `{command('resume', job.resume_folder)}`"
        )


def _run(
    job: Job, state: Checkpoint, world: World, observe: Observer, stopped: Stopped
) -> Checkpoint:
    """Run generations until the last or until stopped, and return a state that is saved."""
    settings = job.record.settings
    rng = stream(settings.fixed_starts_seed, 0, 0, Purpose.FIXED_STARTS)
    fixed_starts = world.draw_starts(rng, settings.fixed_starts)
    _check_best(job, state, world, fixed_starts)
    clock = _Clock(job, state.completed)
    saved_at, saved = time.monotonic(), state.completed
    while state.completed < settings.generations and not stopped():
        state = _generation(job, state, world, fixed_starts)
        done = state.completed
        due = done % SAVE_EVERY == 0 or done == settings.generations
        if due or time.monotonic() - saved_at > SAVE_AFTER_S:
            _save(job, state)
            saved_at, saved = time.monotonic(), done
        observe(clock.progress(state))
    if saved < state.completed:
        _save(job, state)
    return state


def _check_best(
    job: Job, state: Checkpoint, world: World, fixed_starts: NDArray[np.float64]
) -> None:
    """Let the best individual of a checkpoint play again: it must be as good as that says.

    Raises:
        RunError: it is not.
    """
    if state.best is None:
        return
    scores = world.evaluate(state.best.bits[None, :], fixed_starts)
    found = (float(scores.fitness[0]), float(scores.captured[0]))
    if found != (state.best.fitness, state.best.captured):
        raise checkpoint.damaged(
            str(job.folder / run_folder.CHECKPOINT),
            f"its best individual has fitness {found[0]}, not {state.best.fitness}",
        )


def _generation(
    job: Job, state: Checkpoint, world: World, fixed_starts: NDArray[np.float64]
) -> Checkpoint:
    """Evaluate the population, report it, and breed the one that follows."""
    settings, bits = job.record.settings, state.bits
    number = state.completed + 1
    rng = stream(settings.seed, job.trial, number, Purpose.STARTS)
    scores = world.evaluate(bits, world.draw_starts(rng, settings.starts_per_generation))
    training = (*state.training, _report(number, scores))
    fixed, best = state.fixed, state.best
    if settings.is_evaluated(number):
        on_fixed = world.evaluate(bits, fixed_starts)
        fixed = (*fixed, _report(number, on_fixed))
        best = _better(best, number, bits, on_fixed)
        if settings.is_written(number):
            text = run_folder.population_csv(
                bits, scores.fitness, on_fixed.fitness, on_fixed.captured
            )
            files.write_text(job.folder / run_folder.population_name(number), text)
    rng = stream(settings.seed, job.trial, number, Purpose.CHILDREN)
    children = next_generation(bits, scores.fitness, settings.evolution, rng)
    return replace(state, bits=children, training=training, fixed=fixed, best=best)


def _report(generation: int, scores: Scores) -> Report:
    """Return a population's figures; `fsum` rounds once, whatever the order of the summands."""
    fitness, captured = scores.fitness.tolist(), scores.captured.tolist()
    return Report(
        generation,
        math.fsum(fitness) / len(fitness),
        max(fitness),
        min(fitness),
        math.fsum(captured) / len(captured),
    )


def _better(best: Best | None, generation: int, bits: Bits, scores: Scores) -> Best:
    """Return the best individual so far; of equals the earlier one, then the lower index."""
    index = int(np.argmax(scores.fitness))
    fitness = float(scores.fitness[index])
    if best is not None and best.fitness >= fitness:
        return best
    return Best(generation, fitness, float(scores.captured[index]), bits[index].copy())


def _save(job: Job, state: Checkpoint) -> None:
    """Write what is reported so far, and the checkpoint last: it vouches for the others."""
    for name, text in _tables(job, state).items():
        files.write_text(job.folder / name, text)
    checkpoint.save(job.folder / run_folder.CHECKPOINT, state)


def _tables(job: Job, state: Checkpoint) -> dict[str, str]:
    """Return the files that follow from a state, by name."""
    tables = {
        run_folder.TRAINING: run_folder.reports_csv(state.training),
        run_folder.FITNESS: run_folder.reports_csv(state.fixed),
    }
    if state.best is not None:
        best = run_folder.best_genome(job.record, job.trial, state.best)
        tables[run_folder.BEST] = genome.to_text(best)
    return tables


def complete(job: Job, state: Checkpoint) -> None:
    """Make sure that a trial that is done has its files; what is missing is written again.

    Raises:
        RunError: one is cut, damaged or edited.
        StorageError: the disk refused.
    """
    for name, text in _tables(job, state).items():
        if not (job.folder / name).exists():
            files.write_text(job.folder / name, text)
    check_tables(job.folder, state)


class _Clock:
    """Rate and time left of a trial; the only place that asks the computer how long it took."""

    def __init__(self, job: Job, completed: int) -> None:
        self._settings = job.record.settings
        self._began = time.monotonic()
        self._done = 0
        last = self._settings.generations
        self._left = sum(self._starts(number) for number in range(completed + 1, last + 1))

    def _starts(self, generation: int) -> int:
        """Return how many starts a generation runs from."""
        settings = self._settings
        fixed = settings.fixed_starts if settings.is_evaluated(generation) else 0
        return settings.starts_per_generation + fixed

    def progress(self, state: Checkpoint) -> Progress:
        """Return what an observer is told; to be called once after each generation."""
        settings, starts = self._settings, self._starts(state.completed)
        self._done += starts
        self._left -= starts
        elapsed_s = max(time.monotonic() - self._began, 1e-9)
        steps = self._done * settings.evolution.population * settings.steps
        return Progress(
            trial=state.trial,
            generation=state.completed,
            generations=settings.generations,
            mean=state.training[-1].mean,
            steps_per_second=steps / elapsed_s,
            seconds_left=elapsed_s * self._left / self._done,
        )
