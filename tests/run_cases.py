"""Runs in the toy world: what their folders hold, and one that nobody disturbed."""

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from cgagen.run import resume, start
from tests.toy_run import ToyFactory, record


def contents(folder):
    """All files of a folder, by their path in it."""
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
    }


def resume_toy(folder, **options):
    return resume(folder, lambda record: ToyFactory(), **options)


@cache
def unbroken(trials):
    """Return the outcome and the files of a run that nobody disturbed."""
    with TemporaryDirectory() as folder:
        outcome = start(Path(folder) / "run", record(trials=trials), ToyFactory())
        return outcome, contents(Path(folder) / "run")
