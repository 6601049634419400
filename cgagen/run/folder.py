"""The run folder: who may write in it, what lies in it, and in which order it comes to be.

==========================  =====================================================================
`0-run.toml`                settings, seed, versions, digests of the inputs; written last of the
                            first files, so a folder that has it can be continued
`1-predator.toml` ...       the input files as they were
`2-training.csv`            each generation on its own random starts
`2-fitness.csv`             generation 1, 10, 20, ... on the fixed starts
`2-population-gNNN.csv`     whole populations with their fitness
`2-checkpoint.npz`          the state between two generations, written after all of the above
`best.genome`               the best individual on the fixed starts so far
`.lock`                     empty; locked by the process that writes here
==========================  =====================================================================

Fitness is a mean step score in arena units, `captured` a share from 0 to 1.
"""

import errno
import fcntl
import os
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cgagen import files
from cgagen.checkpoint import Best, Report
from cgagen.errors import CgagenError, RunError, StorageError
from cgagen.evolve import Bits
from cgagen.genome import FORMAT as GENOME_FORMAT
from cgagen.genome import Genome, Origin, from_array
from cgagen.inputs import RUN_FILE, read_text
from cgagen.outputs import begins, check_outputs
from cgagen.run.record import RunRecord, from_text
from cgagen.shell import command
from cgagen.temporaries import is_temporary

RECORD = "0-run.toml"
TRAINING = "2-training.csv"
FITNESS = "2-fitness.csv"
CHECKPOINT = "2-checkpoint.npz"
BEST = "best.genome"
LOCK = ".lock"
POPULATION_HEAD = "individual,training_fitness,fixed_fitness,fixed_captured,bits"
KINDS = {
    TRAINING: begins("a table of generations", ",".join(Report._fields) + "\n"),
    FITNESS: begins("a table of generations", ",".join(Report._fields) + "\n"),
    CHECKPOINT: begins("a checkpoint", "PK"),
    BEST: begins("a genome", f'format = "{GENOME_FORMAT}"'),
}
"""What a run writes over in its folder."""

POPULATION = begins("a population", POPULATION_HEAD + "\n")
LOCK_WAIT_S = 3.0
"""choice: a run that was just killed may have a worker that needs a moment to notice."""


def population_name(generation: int) -> str:
    """Return the file name of a written population.

    >>> population_name(1)
    '2-population-g001.csv'
    """
    return f"2-population-g{generation:03d}.csv"


def trial_folder(folder: Path, trial: int) -> Path:
    """Return the folder of one trial of several."""
    return folder / f"trial-{trial}"


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Be the only process that writes in a folder; the kernel unlocks it however we end.

    Raises:
        RunError: another process has it and does not let go within a few seconds.
        StorageError: the lock file cannot be made.
    """
    try:
        handle = os.open(folder / LOCK, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
    except OSError as error:
        raise StorageError(
            f"{folder}: cannot be written ({error.strerror}); choose another folder"
        ) from error
    try:
        _wait_for_lock(handle, folder)
        yield
    finally:
        os.close(handle)


def _wait_for_lock(handle: int, folder: Path) -> None:
    """Take the lock of an open file, waiting a few seconds at most."""
    deadline = time.monotonic() + LOCK_WAIT_S
    while True:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return
        except OSError as error:
            if error.errno not in (errno.EWOULDBLOCK, errno.EACCES):
                raise StorageError(
                    f"{folder}: its disk cannot lock files ({error.strerror}); "
                    "choose a folder on another disk"
                ) from error
        if time.monotonic() > deadline:
            raise RunError(
                f"{folder}: is in use by another cgagen; wait for it or stop it, or choose "
                "another folder"
            )
        time.sleep(0.05)


def refuse_unless_free(folder: Path, record: RunRecord) -> None:
    """Refuse a folder that holds anything but the beginnings of this very run.

    Raises:
        RunError: the folder holds a run or something else.
    """
    names = _names(folder)
    if RECORD in names:
        raise RunError(
            f"{folder}: holds a run already; continue it with `{command('resume', folder)}`, or "
            "choose another folder with --run"
        )
    texts = record.inputs.texts()
    for name in names:
        ours = name == LOCK or is_temporary(name)
        if not ours and not (name in texts and _read_text(folder / name) == texts[name]):
            raise RunError(
                f"{folder}: is not empty (it holds {name}); choose a new folder with --run"
            )


def write_beginning(folder: Path, record: RunRecord) -> None:
    """Write the input files and then the record, after which the run can be resumed.

    Raises:
        StorageError: the disk refused.
    """
    for name, text in record.inputs.texts().items():
        files.write_text(folder / name, text)
    files.write_text(folder / RECORD, record.text)


def read_record(folder: Path) -> RunRecord:
    """Read the record of a run folder and make sure that its input files are unchanged.

    Raises:
        RunError: no run folder, one that never began, another version, or edited files.
    """
    path = folder / RECORD
    if not folder.exists():
        raise RunError(f"{folder}: there is no such run folder; give the one named by `evolve`")
    if RECORD not in _names(folder):
        raise RunError(
            f"{folder}: holds no run ({RECORD} is missing, or the run was stopped before it "
            f"began); start it with `{command('evolve', '--run', folder)}`"
        )
    return from_text(_read_text(path), path, lambda name: _read_text(folder / name))


def refuse_strangers(folder: Path) -> None:
    """Refuse to go on where something else has taken the name of a file that a run writes.

    Raises:
        RunError: the sentence names it.
    """
    for name in _names(folder):
        kind = POPULATION if name.startswith("2-population-g") else KINDS.get(name)
        if kind is None:
            continue
        try:
            check_outputs([(folder / name, kind)])
        except CgagenError as error:
            raise RunError(
                f"{folder / name}: is not {kind.what} of a run, and the run would write over it; "
                "move it away, then resume"
            ) from error


def reports_csv(reports: Iterable[Report]) -> str:
    """Return reports as CSV: shortest decimals that give back the same numbers."""
    rows = (",".join(map(repr, report)) for report in reports)
    return "\n".join([",".join(Report._fields), *rows, ""])


def population_csv(
    bits: Bits,
    training: NDArray[np.float64],
    fixed: NDArray[np.float64],
    captured: NDArray[np.float64],
) -> str:
    """Return a population as CSV, in its own order.

    Args:
        bits: shape (population, bits).
        training: fitness on the generation's random starts, shape (population,).
        fixed: fitness on the fixed starts, same shape.
        captured: share of the fixed starts that ended in a capture, same shape.
    """
    columns = zip(bits.tolist(), training.tolist(), fixed.tolist(), captured.tolist(), strict=True)
    lines = [POPULATION_HEAD]
    for index, (row, *numbers) in enumerate(columns):
        lines.append(f"{index},{','.join(map(repr, numbers))},{''.join(map(str, row))}")
    return "\n".join([*lines, ""])


def best_genome(record: RunRecord, trial: int, best: Best) -> Genome:
    """Return the best individual as a genome that says where it comes from."""
    return from_array(
        best.bits,
        robot=record.inputs.robot,
        interface=record.inputs.interface,
        origin=Origin(
            seed=record.settings.seed,
            trial=trial,
            generation=best.generation,
            fitness=best.fitness,
            robot_digest=record.inputs.robot_digest,
            versions=tuple(pair for pair in record.versions if pair[0] == "cgagen"),
        ),
    ).attested()


def _names(folder: Path) -> list[str]:
    """Return what a folder holds, sorted; nothing where there is no folder."""
    try:
        return sorted(os.listdir(folder))
    except FileNotFoundError:
        return []
    except OSError as error:
        raise RunError(
            f"{folder}: cannot be used as a run folder ({error.strerror}); choose another"
        ) from None


def _read_text(path: Path) -> str:
    """Return a text file of a run, byte for byte, or the sentence that says why it cannot be."""
    return read_text(path, RUN_FILE)
