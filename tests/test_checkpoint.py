"""Checkpoints: they come back to the last bit, and what is none is refused."""

import io

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cgagen import checkpoint
from cgagen.checkpoint import Best, Checkpoint, Report
from cgagen.errors import RunError, StorageError

numbers = st.floats(allow_nan=False)


def state(seed=1, population=5, bits=13, reports=3, with_best=True):
    rng = np.random.Generator(np.random.Philox(key=seed))
    rows = tuple(Report(n + 1, *rng.random(4).tolist()) for n in range(reports))
    array = (rng.random((population, bits)) < 0.5).astype(np.uint8)
    best = Best(2, float(rng.random()), 0.25, array[1]) if with_best else None
    return Checkpoint("ab" * 32, 4, array, rows, rows[::2], best)


def same(one, other):
    if (one.best is None) != (other.best is None):
        return False
    bests = one.best is None or (
        one.best[:3] == other.best[:3] and np.array_equal(one.best.bits, other.best.bits)
    )
    return bests and (
        (one.run_digest, one.trial, one.training, one.fixed)
        == (other.run_digest, other.trial, other.training, other.fixed)
        and np.array_equal(one.bits, other.bits)
        and one.bits.dtype == other.bits.dtype
    )


@given(
    seed=st.integers(0, 2**32),
    population=st.integers(2, 9),
    bits=st.integers(1, 70),
    reports=st.integers(0, 4),
    with_best=st.booleans(),
)
def test_bytes_and_back(seed, population, bits, reports, with_best):
    one = state(seed, population, bits, reports, with_best)
    data = checkpoint.to_bytes(one)
    assert data == checkpoint.to_bytes(one)
    back = checkpoint.from_bytes(data, "x")
    assert same(one, back)
    assert checkpoint.to_bytes(back) == data
    assert back.completed == reports


@given(value=numbers)
def test_numbers_come_back_to_the_last_bit(value):
    one = Checkpoint("d", 1, np.zeros((2, 2), np.uint8), (Report(1, value, value, value, 0.1),))
    back = checkpoint.from_bytes(checkpoint.to_bytes(one), "x")
    assert repr(back.training[0].mean) == repr(value)


def test_file_and_back(tmp_path):
    path, one = tmp_path / "2-checkpoint.npz", state()
    checkpoint.save(path, one)
    assert same(one, checkpoint.restore(path, one.run_digest, 4, (5, 13)))
    with np.load(path) as archive:  # anybody's NumPy reads it
        assert str(archive["format"]) == "cgagen-checkpoint-1"


def test_no_date_of_today_is_in_the_file():
    import zipfile

    with zipfile.ZipFile(io.BytesIO(checkpoint.to_bytes(state()))) as archive:
        assert {info.date_time for info in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}


def test_every_cut_is_refused():
    data = checkpoint.to_bytes(state())
    for length in [*range(0, len(data), 37), len(data) - 1]:
        with pytest.raises(RunError, match="is damaged or no checkpoint"):
            checkpoint.from_bytes(data[:length], "x")


def test_a_flipped_bit_is_refused_or_without_effect():
    one = state()
    data = checkpoint.to_bytes(one)
    refused = 0
    for place in range(0, len(data), 3):
        damaged = bytearray(data)
        damaged[place] ^= 1 << place % 8
        try:
            assert same(one, checkpoint.from_bytes(bytes(damaged), "x")), place
        except RunError:
            refused += 1
    assert refused > len(data) / 6


@pytest.mark.parametrize("data", [b"", b"hello", b"PK\x03\x04", b"\x93NUMPY\x01\x00", b"0" * 999])
def test_foreign_bytes_are_refused(data):
    with pytest.raises(RunError, match=r"mine\.npz: is damaged or no checkpoint"):
        checkpoint.from_bytes(data, "mine.npz")


def archive_with(**changes):
    with np.load(io.BytesIO(checkpoint.to_bytes(state()))) as archive:
        arrays = {name: archive[name] for name in archive.files} | changes
    buffer = io.BytesIO()
    np.savez(buffer, **{name: array for name, array in arrays.items() if array is not None})
    return buffer.getvalue()


def test_another_version_is_named():
    with pytest.raises(RunError, match=r"'cgagen-checkpoint-7'.*'cgagen-checkpoint-1'"):
        checkpoint.from_bytes(archive_with(format=np.array("cgagen-checkpoint-7")), "x")


@pytest.mark.parametrize(
    "changes",
    [
        {"bits": None},
        {"bits": np.zeros(3, np.uint8)},
        {"shape": np.array([5])},
        {"shape": np.array([-5, 13])},
        {"training": np.array([[2.0, 1, 1, 1, 1]])},
        {"training": np.array([["a"]])},
        {"best_bits": np.zeros(12, np.uint8)},
        {"best": np.array([[1.0, 2.0]])},
        {"trial": np.array([1, 2])},
    ],
)
def test_a_whole_archive_with_wrong_arrays_is_refused(changes):
    with pytest.raises(RunError, match="is damaged or no checkpoint"):
        checkpoint.from_bytes(archive_with(**changes), "x")


def test_a_pickle_is_never_opened():
    with pytest.raises(RunError, match="damaged"):
        checkpoint.from_bytes(archive_with(trial=np.array([print], dtype=object)), "x")


def test_a_checkpoint_of_another_run_is_refused(tmp_path):
    path, one = tmp_path / "c.npz", state()
    checkpoint.save(path, one)
    with pytest.raises(RunError, match="other settings"):
        checkpoint.restore(path, "cd" * 32, 4, (5, 13))
    with pytest.raises(RunError, match="other settings"):
        checkpoint.restore(path, one.run_digest, 5, (5, 13))
    with pytest.raises(RunError, match="shape"):
        checkpoint.restore(path, one.run_digest, 4, (5, 12))
    with pytest.raises(RunError, match="is a folder"):
        checkpoint.restore(tmp_path, one.run_digest, 4, (5, 13))


def test_a_full_disk_leaves_the_last_checkpoint_whole(tmp_path, monkeypatch):
    path, one = tmp_path / "c.npz", state()
    checkpoint.save(path, one)

    def full(handle):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("cgagen.files.os.fsync", full)
    with pytest.raises(StorageError, match="No space left"):
        checkpoint.save(path, state(seed=2))
    assert same(one, checkpoint.restore(path, one.run_digest, 4, (5, 13)))
    assert [file.name for file in tmp_path.iterdir()] == ["c.npz"]
