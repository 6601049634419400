"""The verbs with the real world: what is killed, resumed or shared out ends in the same bytes."""

import subprocess
import sys
import time

import pytest

from cgagen import cli

CGAGEN = [sys.executable, "-m", "cgagen"]
SMALL = ["--generations", "30", "--seed", "5"]


def contents(folder):
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
    }


@pytest.fixture(scope="module")
def unbroken(tmp_path_factory):
    folder = tmp_path_factory.mktemp("evolve") / "run"
    assert cli.main(["-q", "evolve", *SMALL, "--workers", "1", "--run", str(folder)]) == 0
    return contents(folder)


def test_killed_with_two_threads_and_resumed_with_one(unbroken, tmp_path):
    folder = tmp_path / "run"
    words = ["evolve", *SMALL, "--workers", "2", "--run", str(folder)]
    process = subprocess.Popen(
        [*CGAGEN, *words], stdout=subprocess.DEVNULL, stdin=subprocess.DEVNULL
    )
    deadline = time.monotonic() + 120
    while not (folder / "2-checkpoint.npz").exists() and time.monotonic() < deadline:
        assert process.poll() is None
        time.sleep(0.002)
    process.kill()
    process.wait()
    assert contents(folder) != unbroken
    assert cli.main(["-q", "resume", str(folder), "--workers", "1"]) == 0
    assert contents(folder) == unbroken


def test_trials_in_two_processes(unbroken, tmp_path):
    folder = tmp_path / "run"
    words = ["evolve", *SMALL, "--trials", "2", "--workers", "2", "--run", str(folder)]
    assert cli.main(["-q", *words]) == 0
    assert contents(folder / "trial-1") == unbroken


def test_the_population_learns(unbroken):
    rows = unbroken["2-fitness.csv"].decode().splitlines()
    first, last = (float(row.split(",")[1]) for row in (rows[1], rows[-1]))
    assert last > first + 5
