"""Runs whose files were cut, damaged or forged: every one is named, and nothing goes on from it."""

import io
import itertools
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cgagen import checkpoint
from cgagen.checkpoint import Best, Checkpoint, Report
from cgagen.errors import RunError, StoppedError
from cgagen.run import start
from tests.run_cases import contents, resume_toy, unbroken
from tests.toy_run import ToyFactory, record


@pytest.fixture
def done(tmp_path: Path) -> Path:
    """A run of one trial that is complete."""
    folder = tmp_path / "run"
    for name, content in unbroken(1)[1].items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)
    return folder


def stopped(folder: Path) -> Path:
    """A run that was stopped after some generations."""
    calls = itertools.count()
    with pytest.raises(StoppedError):
        start(folder, record(), ToyFactory(), stopped=lambda: next(calls) > 16)
    return folder


def state_in(folder: Path) -> Checkpoint:
    return checkpoint.from_bytes((folder / "2-checkpoint.npz").read_bytes(), "x")


def put(folder: Path, state: Checkpoint) -> None:
    checkpoint.save(folder / "2-checkpoint.npz", state)


def other_report(state: Checkpoint, **changes: float) -> Checkpoint:
    first: Report = state.training[0]._replace(**changes)
    return replace(state, training=(first, *state.training[1:]))


def other_best(state: Checkpoint, **changes: object) -> Checkpoint:
    assert state.best is not None
    return replace(state, best=state.best._replace(**changes))


NAN, INFINITE = float("nan"), float("inf")

FORGED = {
    "NaN": (lambda s: other_report(s, mean=NAN), "generation 1 says mean is nan"),
    "infinite": (lambda s: other_report(s, best=INFINITE), "generation 1 says best is inf"),
    "negative": (lambda s: other_report(s, worst=-1.0), "generation 1 says worst is -1.0"),
    "share": (lambda s: other_report(s, captured=1.5), "captured is 1.5, a share up to 1"),
    "mean": (lambda s: other_report(s, mean=0.0), "a mean of 0.0, which is not between"),
    "fixed": (lambda s: replace(s, fixed=s.fixed[:-1]), "reports on the fixed starts are not"),
    "no best": (lambda s: replace(s, best=None), "it has no best individual"),
    "fitness": (lambda s: other_best(s, fitness=999.0), "with fitness 999.0, and its reports say"),
    "NaN best": (lambda s: other_best(s, fitness=NAN), "with fitness nan"),
    "generation": (lambda s: other_best(s, generation=2), "best individual is of generation 2"),
    "captures": (lambda s: other_best(s, captured=NAN), "captures a share of nan"),
    "too many": (
        lambda s: replace(
            s,
            training=tuple(s.training[0]._replace(generation=n) for n in range(1, 60)),
        ),
        "it has 59 generations, and the run 35",
    ),
}


@pytest.mark.parametrize("which", FORGED)
@pytest.mark.parametrize("complete", [True, False])
def test_a_checkpoint_with_numbers_that_cannot_be(tmp_path, done, which, complete) -> None:
    forge, words = FORGED[which]
    folder = done if complete else stopped(tmp_path / "half")
    put(folder, forge(state_in(folder)))
    with pytest.raises(RunError, match=rf"2-checkpoint\.npz: is damaged .*{words}"):
        resume_toy(folder)


def test_a_best_individual_that_is_another_is_found_by_letting_it_play(tmp_path) -> None:
    folder = stopped(tmp_path / "run")
    state = state_in(folder)
    assert state.best is not None
    bits = state.best.bits.copy()
    bits[:9] = 0
    put(folder, other_best(state, bits=bits))
    with pytest.raises(RunError, match="its best individual has fitness"):
        resume_toy(folder)


def archive(done: Path, **changes: np.ndarray) -> bytes:
    with np.load(done / "2-checkpoint.npz") as whole:
        arrays = {name: whole[name] for name in whole.files} | changes
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)
    return buffer.getvalue()


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"best": np.array([[np.inf, 1, 0]])}, "inf is no number of a generation"),
        ({"best": np.array([[np.nan, 1, 0]])}, "nan is no number of a generation"),
        ({"best": np.array([[1.5, 1, 0]])}, "1.5 is no number of a generation"),
        ({"best": np.zeros((2, 3))}, "more or less than one best individual"),
        ({"best_bits": np.full(192, 2, np.uint8)}, "other genes than 0 and 1"),
        ({"training": np.full((1, 5), np.inf)}, "inf is no number of a generation"),
        ({"training": np.zeros((0, 0))}, "other columns"),
        ({"bits": np.zeros(384, np.int64)}, "bits is an array of another kind"),
        ({"trial": np.array("one")}, "trial is an array of another kind"),
        ({"extra": np.zeros(3)}, "holds more than a checkpoint's arrays"),
    ],
)
def test_arrays_that_cannot_be(done, changes, words) -> None:
    (done / "2-checkpoint.npz").write_bytes(archive(done, **changes))
    with pytest.raises(RunError, match=rf"is damaged .*{words}"):
        resume_toy(done)


def test_a_packed_archive_is_not_unpacked(done) -> None:
    """Some 200 kB became 2.3 GB."""
    buffer = io.BytesIO()
    np.savez_compressed(buffer, bits=np.zeros(100_000_000, np.uint8))
    assert len(buffer.getvalue()) < 200_000
    (done / "2-checkpoint.npz").write_bytes(buffer.getvalue())
    with pytest.raises(RunError, match=r"holds more than|is packed"):
        resume_toy(done)


def test_a_head_that_promises_more_than_there_is(done) -> None:
    data = (done / "2-checkpoint.npz").read_bytes()
    state = checkpoint.from_bytes(data, "x")
    member = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        member, {"descr": "|u1", "fortran_order": False, "shape": (1 << 40,)}
    )
    with pytest.raises(ValueError, match="another size than its head says"):
        checkpoint._array("bits", member.getvalue() + bytes(state.bits.size))


@pytest.mark.parametrize(
    "name",
    [name for name in sorted(unbroken(1)[1]) if name not in {".lock", "2-checkpoint.npz"}],
)
@pytest.mark.parametrize("how", ["cut", "emptied", "flipped"])
def test_a_complete_run_with_a_damaged_file_names_it(done, name, how) -> None:
    content = (done / name).read_bytes()
    middle = len(content) * 2 // 5
    changed = {
        "cut": content[: middle + 1],
        "emptied": b"",
        "flipped": content[:middle] + bytes([content[middle] ^ 1]) + content[middle + 1 :],
    }[how]
    (done / name).write_bytes(changed)
    if name == "best.genome" and how == "flipped":
        (done / name).write_bytes(content.replace(b"000", b"001", 1))
    if "population" in name and how == "flipped":  # genes alone nothing vouches for
        (done / name).write_bytes(re.sub(rb"\n3,\d", b"\n3,5", content))
    with pytest.raises(RunError, match=rf"run/{name}: "):
        resume_toy(done)


@pytest.mark.parametrize("name", ["2-training.csv", "2-fitness.csv", "best.genome"])
def test_a_complete_run_without_a_file_that_follows_writes_it_again(done, name) -> None:
    (done / name).unlink()
    resume_toy(done)
    assert contents(done) == unbroken(1)[1]


def test_a_complete_run_without_a_population_says_so(done) -> None:
    (done / "2-population-g015.csv").unlink()
    with pytest.raises(RunError, match=r"2-population-g015\.csv: cannot be read"):
        resume_toy(done)


def test_the_best_genome_above_several_trials_is_looked_at_too(tmp_path) -> None:
    folder = tmp_path / "run"
    start(folder, record(trials=2), ToyFactory())
    assert resume_toy(folder).was_complete
    text = (folder / "best.genome").read_text("utf-8")
    (folder / "best.genome").write_text(text.replace("trial = ", "trial = 7"), "utf-8")
    with pytest.raises(RunError, match=r"run/best\.genome: is damaged or edited"):
        resume_toy(folder)


def test_a_damaged_population_stops_a_run_that_goes_on(tmp_path) -> None:
    folder = stopped(tmp_path / "run")
    path = folder / "2-population-g001.csv"
    path.write_bytes(path.read_bytes()[:-200])
    with pytest.raises(RunError, match=r"g001\.csv: is not as the run wrote it \(line 17 is"):
        resume_toy(folder)


def test_the_toy_has_a_best(done) -> None:
    """The tests above forge it."""
    assert isinstance(state_in(done).best, Best)
