"""Folders that cannot be used for a run, or gone on with."""

import itertools

import pytest

from cgagen import files
from cgagen.errors import RunError, StoppedError, StorageError
from cgagen.run import folder as run_folder
from cgagen.run import start
from tests.run_cases import contents, resume_toy, unbroken
from tests.toy_run import ToyFactory, record


def test_a_folder_in_use_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(run_folder, "LOCK_WAIT_S", 0.1)
    folder = tmp_path / "run"
    start(folder, record(), ToyFactory())
    before = contents(folder)
    with run_folder.locked(folder), pytest.raises(RunError, match="in use"):
        resume_toy(folder)
    assert contents(folder) == before
    resume_toy(folder)


def test_a_folder_with_something_else_is_refused_and_untouched(tmp_path):
    for name in ("thesis.txt", "1-prey.toml"):
        folder = tmp_path / f"with {name}"
        folder.mkdir()
        (folder / name).write_text("mine")
        with pytest.raises(RunError, match=rf"not empty \(it holds {name}\)"):
            start(folder, record(), ToyFactory())
        assert contents(folder) == {name: b"mine"}


def test_a_run_is_never_overwritten(tmp_path):
    folder = tmp_path / "run"
    start(folder, record(), ToyFactory())
    with pytest.raises(RunError, match=r"holds a run already.*cgagen resume"):
        start(folder, record(seed=9), ToyFactory())
    assert contents(folder) == unbroken(1)[1]


def test_an_empty_folder_will_do(tmp_path):
    start(tmp_path, record(), ToyFactory())
    assert contents(tmp_path) == unbroken(1)[1]


def test_what_is_no_run_folder(tmp_path):
    (tmp_path / "file").write_text("x")
    for path, words in [
        (tmp_path / "none", "no such run folder"),
        (tmp_path, "holds no run"),
        (tmp_path / "file", "cannot be used as a run folder"),
    ]:
        with pytest.raises(RunError, match=words):
            resume_toy(path)
    with pytest.raises((RunError, StorageError), match="choose another"):
        start(tmp_path / "file", record(), ToyFactory())
    assert contents(tmp_path) == {"file": b"x"}


def stopped_run(folder):
    calls = itertools.count()
    with pytest.raises(StoppedError):
        start(folder, record(), ToyFactory(), stopped=lambda: next(calls) > 12)
    return folder


@pytest.mark.parametrize(
    ("name", "old", "new", "words"),
    [
        ("0-run.toml", b"cgagen-run-1", b"cgagen-run-2", "'cgagen-run-2'.*'cgagen-run-1'"),
        ("0-run.toml", b"seed = 7", b"seed = 8", "other settings"),
        ("0-run.toml", b"seed = 7", b"seed = -8", "has been changed.*seed is -8"),
        ("0-run.toml", b"seed = 7", b"sede = 7", "has been changed"),
        ("0-run.toml", b"seed = 7", b"seed = = 7", "is not TOML"),
        ("0-run.toml", b"population = 16", b"population = true", "has been changed"),
        ("0-run.toml", b"population = 16", b"population = 'x'", "has been changed"),
        ("0-run.toml", b"[world.options]", b"[world.option]", "has been changed"),
        ("0-run.toml", b"[inputs]", b"[[inputs]]", "has been changed"),
        ("0-run.toml", b"\n", b"\r\n", "has been changed"),
        ("0-run.toml", b"format", b"\xff", "not UTF-8"),
        ("1-prey.toml", b"prey", b"pray", "1-prey.toml: is not the file that the run began with"),
        ("2-checkpoint.npz", b"PK", b"KP", "2-checkpoint.npz: is damaged"),
    ],
)
def test_edited_files_are_refused(tmp_path, name, old, new, words):
    path = stopped_run(tmp_path / "run") / name
    assert old in path.read_bytes()
    path.write_bytes(path.read_bytes().replace(old, new))
    with pytest.raises(RunError, match=words) as caught:
        resume_toy(tmp_path / "run")
    assert "\n" not in str(caught.value)
    assert str(tmp_path) in str(caught.value)


def test_a_missing_input_is_named(tmp_path):
    (stopped_run(tmp_path / "run") / "1-arena.toml").unlink()
    with pytest.raises(RunError, match=r"1-arena.toml: cannot be read"):
        resume_toy(tmp_path / "run")


def test_a_checkpoint_that_was_cut_short(tmp_path):
    path = stopped_run(tmp_path / "run") / "2-checkpoint.npz"
    path.write_bytes(path.read_bytes()[:1000])
    with pytest.raises(RunError, match="delete it to resume the run from its first generation"):
        resume_toy(tmp_path / "run")
    path.unlink()
    resume_toy(tmp_path / "run")
    assert contents(tmp_path / "run") == unbroken(1)[1]


def test_a_run_of_another_version_is_refused(tmp_path, monkeypatch):
    stopped_run(tmp_path / "run")
    monkeypatch.setattr("cgagen.run.trials.__version__", "9.9")
    with pytest.raises(RunError, match=r"begun by cgagen .* this is 9\.9"):
        resume_toy(tmp_path / "run")


def test_a_trial_folder_of_another_run_is_refused(tmp_path):
    folder = tmp_path / "run"
    calls = itertools.count()
    with pytest.raises(StoppedError):
        start(folder, record(trials=2), ToyFactory(), stopped=lambda: next(calls) > 12)
    files.write_text(folder / "trial-2/0-run.toml", record(seed=9, first_trial=2, trials=1).text)
    with pytest.raises(RunError, match="trial-2: belongs to a run with other settings"):
        resume_toy(folder)
