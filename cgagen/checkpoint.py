"""A run between two generations, saved and restored.

What a restored run promises: every file that it still writes has, bit for bit, the content that
it would have had if the run had never stopped. Three things make that true:

* Random numbers are a function of (seed, trial, generation, purpose) (`cgagen.run.streams`), so
  no generator has a state to be saved.
* The population of the next generation, everything already reported, and the best individual are
  all that one generation hands to the next, and all of it is in the file, as exact binary.
* The file carries the digest of the run's settings and inputs; with others it is refused.

The file is a NumPy archive (`numpy.load` opens it) with fixed dates and no compression, so the
same state gives the same bytes.
"""

import io
import math
import zipfile
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cgagen import files
from cgagen.errors import RunError
from cgagen.evolve import Bits
from cgagen.inputs import CHECKPOINT, read_bytes
from cgagen.shown import short, shown

FORMAT = "cgagen-checkpoint-1"


class Report(NamedTuple):
    """What one evaluation of a whole population said.

    Attributes:
        generation: from 1.
        mean: mean fitness of the population, arena units.
        best: fitness of the best individual, arena units.
        worst: fitness of the worst, arena units.
        captured: share of all (individual, start) pairs that ended in a capture, 0 to 1.
    """

    generation: int
    mean: float
    best: float
    worst: float
    captured: float


class Best(NamedTuple):
    """The best individual on the fixed starts so far; the earlier one where two are equal.

    Attributes:
        generation: that held it, from 1.
        fitness: on the fixed starts, arena units.
        captured: share of the fixed starts that ended in a capture, 0 to 1.
        bits: 0 and 1, shape (bits,).
    """

    generation: int
    fitness: float
    captured: float
    bits: NDArray[np.uint8]


@dataclass(frozen=True, slots=True, eq=False)
class Checkpoint:
    """The state of a trial between two generations.

    Attributes:
        run_digest: digest of the settings and inputs that it belongs to.
        trial: from 1.
        bits: population of generation `completed + 1`, shape (population, bits).
        training: a report on the starts of each generation so far, in order.
        fixed: reports on the fixed starts so far, in order.
        best: best individual so far; None before the first evaluation on the fixed starts.
    """

    run_digest: str
    trial: int
    bits: Bits
    training: tuple[Report, ...] = ()
    fixed: tuple[Report, ...] = ()
    best: Best | None = None

    @property
    def completed(self) -> int:
        """Generations that are done."""
        return len(self.training)


def save(path: Path, state: Checkpoint) -> None:
    """Write a checkpoint; the one that was there stays whole until the new one is.

    Raises:
        StorageError: the disk refused; the old file is as it was.
    """
    files.write_bytes(path, to_bytes(state))


def restore(path: Path, run_digest: str, trial: int, shape: tuple[int, int]) -> Checkpoint:
    """Read a checkpoint and make sure that it belongs to this run.

    Args:
        path: the file.
        run_digest: digest of the run's settings and inputs.
        trial: the trial that shall be continued.
        shape: (population, bits) of the settings.

    Raises:
        RunError: damaged, of another version, of another run, or not readable.
    """
    most = max(CHECKPOINT.most, shape[0] * shape[1])
    state = from_bytes(read_bytes(path, replace(CHECKPOINT, most=most)), str(path))
    if state.run_digest != run_digest or state.trial != trial:
        raise RunError(
            f"{path}: belongs to a run with other settings; put back the 0-run.toml that it was "
            "written with, or start a new run in another folder"
        )
    if state.bits.shape != shape:
        raise damaged(str(path), f"its population has shape {state.bits.shape}")
    return state


def to_bytes(state: Checkpoint) -> bytes:
    """Return the content of a checkpoint file; the same state gives the same bytes."""
    best = state.best
    arrays: dict[str, NDArray[np.generic]] = {
        "format": np.array(FORMAT),
        "run_digest": np.array(state.run_digest),
        "trial": np.array(state.trial, np.int64),
        "shape": np.array(state.bits.shape, np.int64),
        "bits": np.packbits(state.bits),
        "training": np.array(state.training, np.float64).reshape(-1, len(Report._fields)),
        "fixed": np.array(state.fixed, np.float64).reshape(-1, len(Report._fields)),
        "best": np.array([best[:3]] if best else [], np.float64).reshape(-1, 3),
        "best_bits": best.bits if best else np.zeros(0, np.uint8),
    }
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_STORED) as archive:
        for name, array in arrays.items():
            member = io.BytesIO()
            np.lib.format.write_array(member, array, version=(1, 0), allow_pickle=False)
            info = zipfile.ZipInfo(f"{name}.npy", date_time=(1980, 1, 1, 0, 0, 0))
            info.create_system = 3  # Unix, whatever the machine
            info.external_attr = 0o644 << 16
            archive.writestr(info, member.getvalue())
    return buffer.getvalue()


def from_bytes(data: bytes, name: str) -> Checkpoint:
    """Return the state that the bytes of a checkpoint file hold.

    Args:
        data: the whole file.
        name: what sentences call the file.

    Raises:
        RunError: the bytes are damaged, cut short, foreign, or of another version.
    """
    try:
        members = _members(data)
        form = str(_array("format", members.get("format", b"")))
    except Exception as error:  # a damaged archive can raise a dozen kinds
        raise damaged(name, _words(error)) from None
    if form != FORMAT:
        raise RunError(
            f"{name}: is a checkpoint of format {shown(form)}, and this version reads {FORMAT!r}; "
            "continue it with the version that wrote it, or start a new run"
        )
    try:
        return _from_arrays({key: _array(key, members[key]) for key in _ARRAYS})
    except Exception as error:
        raise damaged(name, _words(error)) from None


_ARRAYS: dict[str, tuple[str, int]] = {
    "format": ("U", 0),
    "run_digest": ("U", 0),
    "trial": ("i", 0),
    "shape": ("i", 1),
    "bits": ("u", 1),
    "training": ("f", 2),
    "fixed": ("f", 2),
    "best": ("f", 2),
    "best_bits": ("u", 1),
}
"""Kind of NumPy's types, and dimensions, of every array."""


def _members(data: bytes) -> dict[str, bytes]:
    """Return the members of an archive, which may not be packed: no byte of it becomes two."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        entries = archive.infolist()
        if len(entries) > len(_ARRAYS) or sum(one.file_size for one in entries) > len(data):
            raise ValueError("it holds more than a checkpoint's arrays")
        if any(one.compress_type != zipfile.ZIP_STORED for one in entries):
            raise ValueError("it is packed, and a checkpoint never is")
        return {one.filename.removesuffix(".npy"): archive.read(one) for one in entries}


def _array(name: str, data: bytes) -> NDArray[np.generic]:
    """Return the array of a member whose head says no more than the member holds."""
    file = io.BytesIO(data)
    if np.lib.format.read_magic(file) != (1, 0):
        raise ValueError(f"{name} is an array of another version of NumPy's format")
    shape, by_columns, dtype = np.lib.format.read_array_header_1_0(file)
    kind, dimensions = _ARRAYS[name]
    rest = len(data) - file.tell()
    if dtype.hasobject or dtype.kind != kind or len(shape) != dimensions or by_columns:
        raise ValueError(f"{name} is an array of another kind")
    if math.prod(shape) * dtype.itemsize != rest or min(shape, default=0) < 0:
        raise ValueError(f"{name} has another size than its head says")
    return np.frombuffer(data, dtype, offset=file.tell()).reshape(shape)


def _words(error: Exception) -> str:
    """Return what a sentence says of an error inside the file."""
    kind = "" if type(error) is ValueError else f"{type(error).__name__}: "
    return short(f"{kind}{error}", 200)


def _from_arrays(arrays: dict[str, NDArray[np.generic]]) -> Checkpoint:
    """Return the state of an archive's arrays; any mismatch is a ValueError or KeyError."""
    population, bits = arrays["shape"].tolist()
    if population < 0 or bits < 0 or len(arrays["bits"]) != (population * bits + 7) // 8:
        raise ValueError("the population has another size than its shape says")
    unpacked = np.unpackbits(arrays["bits"].astype(np.uint8), count=population * bits)
    training, fixed = _reports(arrays["training"]), _reports(arrays["fixed"])
    if [report.generation for report in training] != list(range(1, len(training) + 1)):
        raise ValueError("its generations are not 1, 2, 3 and so on")
    best = None
    if arrays["best"].shape not in {(0, 3), (1, 3)}:
        raise ValueError("it has more or less than one best individual")
    if len(arrays["best"]):
        generation, fitness, captured = (float(value) for value in arrays["best"][0])
        best = Best(_whole(generation), fitness, captured, arrays["best_bits"].astype(np.uint8))
        if best.bits.shape != (bits,):
            raise ValueError("its best individual has another size than the others")
        if best.bits.max(initial=0) > 1:
            raise ValueError("its best individual has other genes than 0 and 1")
    return Checkpoint(
        run_digest=str(arrays["run_digest"]),
        trial=int(arrays["trial"]),
        bits=unpacked.reshape(population, bits),
        training=training,
        fixed=fixed,
        best=best,
    )


def _reports(table: NDArray[np.generic]) -> tuple[Report, ...]:
    """Return the rows of a table as reports."""
    if table.shape[1:] != (len(Report._fields),):
        raise ValueError("its reports have other columns")
    rows = table.astype(np.float64).tolist()
    return tuple(Report(_whole(row[0]), *(float(value) for value in row[1:])) for row in rows)


def _whole(number: float) -> int:
    """Return a number of a generation; what is none is a ValueError."""
    if not number.is_integer():  # nor is what is infinite
        raise ValueError(f"{number} is no number of a generation")
    return int(number)


def damaged(name: str, why: str) -> RunError:
    """Return the sentence for a file that is not a whole checkpoint."""
    return RunError(
        f"{name}: is damaged or no checkpoint ({why}); put back a whole copy, or delete it to "
        "resume the run from its first generation"
    )
