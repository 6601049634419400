"""Runs that are killed, stopped or out of disk, and go on as if nothing had been."""

import errno
import itertools
import os
import random
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from cgagen.errors import RunError, StoppedError, StorageError
from cgagen.run import resume, start
from cgagen.temporaries import is_temporary
from tests import toy_run
from tests.run_cases import contents, resume_toy, unbroken
from tests.toy_run import ToyFactory, record

TOY = [sys.executable, toy_run.__file__]


# --- interruptions


class Crash(BaseException):
    """What nothing catches: the power goes."""


@pytest.mark.parametrize("after", [False, True])
@pytest.mark.parametrize("trials", [1, 3])
def test_a_crash_at_any_file_then_resume(tmp_path, monkeypatch, trials, after):
    """The process ends just before, or just after, the n-th file takes its name; n = 1, 2, ..."""
    whole = unbroken(trials)[1]
    real = os.replace
    for crash_at in itertools.count(1, 1 if trials == 1 else 7):
        folder, count = tmp_path / str(crash_at), itertools.count(1)

        def replaced(source, target, crash_at=crash_at, count=count):
            crash = next(count) == crash_at
            if crash and not after:
                Path(source).with_name(".cgagen-abcdef12.tmp").write_bytes(b"half")
                raise Crash
            real(source, target)
            if crash:
                raise Crash

        monkeypatch.setattr("cgagen.files.os.replace", replaced)
        try:
            start(folder, record(trials=trials), ToyFactory())
            break
        except Crash:
            monkeypatch.setattr("cgagen.files.os.replace", real)
        if (folder / "0-run.toml").exists():
            resume_toy(folder)
        else:
            with pytest.raises(RunError, match="cgagen evolve --run"):
                resume_toy(folder)
            start(folder, record(trials=trials), ToyFactory())
        assert contents(folder) == whole, crash_at
    assert crash_at > 15 * trials


@pytest.mark.parametrize(
    ("trials", "workers", "pause_s", "latest_s"), [(1, 1, 0.015, 0.5), (2, 2, 0.04, 1.2)]
)
def test_killed_again_and_again_then_resumed(tmp_path, trials, workers, pause_s, latest_s):
    """41 evaluations take longer than the latest moment, so the first attempt is always killed."""
    whole, folder = tmp_path / "whole", tmp_path / "run"
    start(whole, record(trials=trials), ToyFactory())
    moments = random.Random(trials)
    verb, kills = "start", 0
    for _ in range(12):
        words = [verb, str(folder), str(pause_s), str(trials), str(workers)]
        process = subprocess.Popen([*TOY, *words], stdout=subprocess.PIPE, stdin=subprocess.DEVNULL)
        process.stdout.readline()  # it is past its imports
        time.sleep(moments.uniform(0.05, latest_s))
        process.kill()
        code = process.wait()
        process.stdout.close()
        if code == 0:
            break
        kills += 1
        verb = "resume" if (folder / "0-run.toml").exists() else "start"
    assert kills >= 1
    resume_toy(folder)  # workers of a killed parent notice within a generation
    assert contents(folder) == contents(whole)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize(("trials", "workers"), [(1, 1), (2, 2)])
def test_ctrl_c_is_a_sentence_and_exit_10(tmp_path, number, trials, workers):
    folder = tmp_path / "run"
    words = ["start", str(folder), "0.03", str(trials), str(workers)]
    process = subprocess.Popen(
        [*TOY, *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        stdin=subprocess.DEVNULL,
    )
    place = folder if trials == 1 else folder / "trial-1"
    while process.poll() is None and not (place / "2-checkpoint.npz").exists():
        time.sleep(0.05)
    if number == signal.SIGINT:
        os.killpg(process.pid, number)  # a terminal sends it to the whole group
    else:
        process.send_signal(number)
    _, sentence = process.communicate(timeout=60)
    assert process.returncode == 10, sentence
    assert f"cgagen resume {folder}`" in sentence
    assert len(sentence.strip().splitlines()) == 1
    resume_toy(folder)
    for name, data in unbroken(1)[1].items():
        assert (place / name).read_bytes() == data


def test_stopped_between_any_two_generations(tmp_path):
    folder, stops = tmp_path / "run", itertools.count()
    with pytest.raises(StoppedError, match="generation 0 of 35"):
        start(folder, record(), ToyFactory(), stopped=lambda: True)
    for generation in range(1, 35):
        calls = itertools.count()
        with pytest.raises(StoppedError, match=f"after generation {generation} of 35"):
            resume_toy(folder, stopped=lambda calls=calls: next(calls) > 0)
        next(stops)
    assert not resume_toy(folder).was_complete
    assert contents(folder) == unbroken(1)[1]


def test_a_complete_run_stays_as_it_is(tmp_path):
    for trials in (1, 2):
        folder = tmp_path / str(trials)
        start(folder, record(trials=trials), ToyFactory())
        before = {path: path.stat().st_mtime_ns for path in folder.rglob("*.*")}
        outcome = resume(folder, lambda record: pytest.fail("nothing is left to do"))
        assert outcome.was_complete
        assert {path: path.stat().st_mtime_ns for path in folder.rglob("*.*")} == before


# --- a disk that is full


@pytest.mark.parametrize("trials", [1, 2])
def test_a_full_disk_at_any_file(tmp_path, monkeypatch, trials):
    real = os.fsync
    for full_at in itertools.count(1, 1 if trials == 1 else 3):
        folder, count = tmp_path / str(full_at), itertools.count(1)

        def fsync(handle, full_at=full_at, count=count):
            if next(count) >= full_at:
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            real(handle)

        monkeypatch.setattr("cgagen.files.os.fsync", fsync)
        try:
            start(folder, record(trials=trials), ToyFactory())
            break
        except StorageError:
            assert not (folder / "0-run.toml").exists()
            continue
        except StoppedError as error:
            sentence = str(error)
        finally:
            monkeypatch.setattr("cgagen.files.os.fsync", real)
        assert "No space left on device" in sentence
        assert f"cgagen resume {folder}`" in sentence
        assert "\n" not in sentence
        assert not [name for name in contents(folder) if is_temporary(name)]
        resume_toy(folder)
        place = folder if trials == 1 else folder / "trial-1"
        assert contents(place) == unbroken(1)[1]
    assert full_at > 15


def test_a_real_limit_on_files(tmp_path):
    """The kernel refuses files above 4,200 bytes: the populations fit, the checkpoint does not."""
    folder = tmp_path / "run"
    done = subprocess.run(
        [*TOY, "start", str(folder), "0", "1", "1"],
        capture_output=True,
        check=False,
        text=True,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (4_200, 4_200)),
        stdin=subprocess.DEVNULL,
    )
    assert done.returncode == 10
    assert "2-checkpoint.npz" in done.stderr
    assert "cgagen resume" in done.stderr
    resume_toy(folder)
    assert contents(folder) == unbroken(1)[1]
