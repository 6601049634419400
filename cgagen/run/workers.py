"""Several trials at once: one process per trial, a pipe to each, and no way to hang.

A worker tells its progress over the pipe; a word or the end of the pipe from the other side means
stop. So a worker ends when its parent is killed, and the parent hears when a worker is.
"""

import multiprocessing
import os
import signal
import time
import traceback
from collections import deque
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import connection
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess

from cgagen.errors import CgagenError, StoppedError
from cgagen.run.folder import locked
from cgagen.run.loop import Job, Observer, Progress, WorldFactory, run_trial
from cgagen.run.stop import Stopped
from cgagen.shell import command
from cgagen.temporaries import sweep

PROGRESS_S = 0.1
"""Seconds between two words of progress. choice: as often as an eye can follow."""

LAST_GENERATION_S = 60.0
"""Seconds that a worker has for its last generation and checkpoint before it is killed. choice."""

DONE = "done"
STOP = "stop"


@dataclass(frozen=True, slots=True)
class _Bug:
    """An exception that is a bug of ours, as text, since not every exception can be sent."""

    text: str


@dataclass(frozen=True, slots=True)
class _Worker:
    """A running process and the job that it has."""

    process: SpawnProcess
    job: Job


def run_in_processes(
    jobs: Sequence[Job],
    make_world: WorldFactory,
    workers: int,
    observe: Observer,
    stopped: Stopped,
) -> None:
    """Run trials in processes, at most `workers` at a time.

    Raises:
        StoppedError: `stopped` said so, or a worker was killed.
        StorageError: the disk refused.
        RunError: a trial's folder cannot be continued.
    """
    waiting, running = deque(jobs), dict[Connection, _Worker]()
    failures: list[Exception] = []
    deadline: float | None = None
    try:
        while running or (waiting and deadline is None):
            if deadline is None and (failures or stopped()):
                deadline = time.monotonic() + LAST_GENERATION_S
                _ask_to_stop(running)
                continue
            while deadline is None and waiting and len(running) < workers:
                pipe, worker = _launch(waiting.popleft(), make_world)
                running[pipe] = worker
            if deadline is not None and time.monotonic() > deadline:
                break
            ready = connection.wait(list(running), timeout=0.2)
            for pipe in [pipe for pipe in running if pipe in ready]:
                _listen(pipe, running, observe, failures)
    finally:
        _kill(running)
    failures.sort(key=lambda failure: isinstance(failure, StoppedError))  # the cause first
    if failures:
        raise failures[0]
    if deadline is not None:
        raise StoppedError(f"stopped; continue with `{command('resume', jobs[0].resume_folder)}`")


def _launch(job: Job, make_world: WorldFactory) -> tuple[Connection, _Worker]:
    """Start the process of a trial and return our end of its pipe."""
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=_work, args=(job, make_world, theirs), daemon=True)
    with _safe_path():
        process.start()
    theirs.close()  # else its end would stay open here, and a killed worker would go unnoticed
    return ours, _Worker(process, job)


@contextmanager
def _safe_path() -> Iterator[None]:
    """Start Python without the current folder: a pickle.py in it is not ours to run."""
    before = os.environ.get("PYTHONSAFEPATH")
    os.environ["PYTHONSAFEPATH"] = "1"
    try:
        yield
    finally:
        if before is None:
            del os.environ["PYTHONSAFEPATH"]
        else:
            os.environ["PYTHONSAFEPATH"] = before


def _kill(running: dict[Connection, _Worker]) -> None:
    """End workers that did not end in time; their folders can be resumed like any other."""
    for pipe, worker in running.items():
        worker.process.kill()
        worker.process.join()
        pipe.close()


def _ask_to_stop(running: dict[Connection, _Worker]) -> None:
    """Ask every worker to end after its generation."""
    for pipe in running:
        try:
            pipe.send(STOP)
        except OSError:
            pass  # it has just ended; its last word is still in the pipe


def _listen(
    pipe: Connection,
    running: dict[Connection, _Worker],
    observe: Observer,
    failures: list[Exception],
) -> None:
    """Take one word from a worker; forget the worker at its last."""
    worker = running[pipe]
    try:
        word = pipe.recv()
    except (EOFError, OSError):
        worker.process.join()
        word = StoppedError(
            f"{worker.job.folder}: the process of this trial ended by itself "
            f"({_reason(worker.process.exitcode)}); "
            f"continue with `{command('resume', worker.job.resume_folder)}`"
        )
    if isinstance(word, Progress):
        observe(word)
        return
    if isinstance(word, _Bug):
        failures.append(RuntimeError(f"trial {worker.job.trial} failed:\n{word.text}"))
    elif isinstance(word, CgagenError):
        failures.append(word)
    worker.process.join()
    pipe.close()
    del running[pipe]


def _reason(exit_code: int | None) -> str:
    """Return how a process ended, in words."""
    if exit_code is not None and exit_code < 0:
        return f"killed by {signal.Signals(-exit_code).name}"
    return f"exit code {exit_code}"


def _work(job: Job, make_world: WorldFactory, pipe: Connection) -> None:
    """Run one trial: the whole life of a worker process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches the parent, who asks us
    told_at = 0.0

    def observe(progress: Progress) -> None:
        nonlocal told_at
        last = progress.generation == progress.generations
        if last or time.monotonic() - told_at > PROGRESS_S:
            told_at = time.monotonic()
            _tell(pipe, progress)

    try:
        with locked(job.folder):
            sweep(job.folder)
            run_trial(job, make_world, observe, pipe.poll)
        _tell(pipe, DONE)
    except CgagenError as error:
        _tell(pipe, error)
    except Exception:
        _tell(pipe, _Bug(traceback.format_exc()))


def _tell(pipe: Connection, word: object) -> None:
    """Say a word to the parent, if it still lives; if not, `pipe.poll` says so."""
    try:
        pipe.send(word)
    except OSError:
        pass
