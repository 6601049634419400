"""What a user means by a folder where a file is wanted: a run's genome, a build's bench."""

from pathlib import Path
from typing import Any

import click

from cgagen.errors import BenchError, CgagenError, FolderError, GenomeError
from cgagen.shell import command

BENCH_FILE = "bench.toml"
BEST = "best.genome"
BUILD_RECORD = "build.json"
RUN_RECORD = "0-run.toml"
SOURCES = ("main.bsp", "locomotion.bs2")


class GenomeType(click.ParamType[Path]):
    """A genome's file, or the run whose best one is meant."""

    name = "GENOME"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        """Return the file; it need not be there."""
        return genome_at(Path(value))


def genome_at(path: Path) -> Path:
    """Return the best genome of a run; what is no folder stays as it is.

    Raises:
        GenomeError: a folder that is no run, or one that has no best genome yet; or another file
            of ours.
    """
    if not _is_folder(path):
        _refuse_other_sort(path)
        return path
    best = path / BEST
    if (path / BUILD_RECORD).is_file():
        raise GenomeError(
            f"{path}: is a build, not a genome; try it as it is with "
            f"`{command('verify', '--build', path)}`, or name its genome, {best}"
        )
    if not (path / RUN_RECORD).is_file():
        raise GenomeError(f"{path}: is a folder, and no run; give the {BEST} of a run")
    if not best.is_file():
        raise GenomeError(
            f"{path}: has no {BEST} yet; continue the run with `{command('resume', path)}`"
        )
    return best


def bench_at(path: Path) -> Path:
    """Return the bench of a build; what is no folder stays as it is.

    Raises:
        BenchError: a folder without one.
    """
    if not _is_folder(path):
        return path
    bench = path / BENCH_FILE
    if bench.is_file():
        return bench
    if (path / RUN_RECORD).is_file():
        raise BenchError(
            f"{path}: is a run, and has no programs; build them first: {command('build', path)}"
        )
    raise BenchError(
        f"{path}: is a folder without a {BENCH_FILE}; name a build, a bench, a source or an image"
    )


def source_at(path: Path) -> Path:
    """Refuse a folder where one source is wanted, and name those that a build has.

    Raises:
        FolderError: it is a folder.
    """
    if not _is_folder(path):
        return path
    there = [str(path / name) for name in SOURCES if (path / name).is_file()]
    named = f"; name one of its sources: {', '.join(there)}" if there else "; name a PBASIC source"
    raise FolderError(f"{path}: is a folder{named}")


def _refuse_other_sort(path: Path) -> None:
    """Say of a robot or an image what it is; what a genome's reader would say of it misleads."""
    from cgagen.verbs.info_sorts import Sort, sort_of

    try:
        sort = sort_of(path) if path.is_file() else Sort.GENOME
    except (CgagenError, OSError, ValueError):
        return
    if sort is not Sort.GENOME:
        raise GenomeError(f"{path}: is {sort}, not a genome; give the {BEST} of a run")


def _is_folder(path: Path) -> bool:
    try:
        return path.is_dir()
    except (OSError, ValueError):  # a name that no file can have is refused by who reads it
        return False
