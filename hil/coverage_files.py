"""What of the programs was executed in a run: LCOV for tools, a listing and lines for people."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import groupby
from pathlib import Path
from typing import Any

from cgagen.emulator.coverage_report import (
    LISTING,
    TRACEFILE,
    SourceCoverage,
    coverage_listing,
    lcov,
)
from cgagen.files import make_folder, write_text
from cgagen.outputs import Kind
from cgagen.places import place_of
from hil.evidence import source_coverage

TRACEFILE_NAME, LISTING_NAME = "hil-coverage.info", "hil-coverage.txt"


def write_coverage(path: Path, robots: Sequence[Mapping[str, Any]]) -> list[str]:
    """Write a tracefile of LCOV's and a listing; return what they come to, in lines.

    Args:
        path: a folder, or a file with a suffix; the listing then lies beside it as .txt.
        robots: data of `Evidence`.

    Raises:
        StorageError: the disk refuses.
    """
    sources = [
        replace(source_coverage(data), name=f"{robot['role']}/{data['name']}")
        for robot in robots
        for data in robot["coverage"].values()
    ]
    files = coverage_files(path)
    texts = lcov(sources), coverage_listing(sources)
    for (file, _), text in zip(files, texts, strict=False):
        make_folder(file.parent)
        write_text(file, text)
    lines = [f"coverage {one.summary}{_missed(one)}" for one in sources]
    lines += [_genes(robot) for robot in robots]
    return [*lines, f"coverage: {', '.join(str(file) for file, _ in files)}"]


def coverage_files(path: Path) -> list[tuple[Path, Kind]]:
    """Return the files of a coverage, each with its kind; a stream gets the tracefile alone."""
    if path.exists() and not path.is_dir() and place_of(path).is_stream:
        return [(path, TRACEFILE)]
    if path.suffix:
        return [(path, TRACEFILE), (path.with_suffix(".txt"), LISTING)]
    return [(path / TRACEFILE_NAME, TRACEFILE), (path / LISTING_NAME, LISTING)]


def _genes(robot: Mapping[str, Any]) -> str:
    """Return how much of the table was met."""
    states = robot["states"]
    met = [row for row in states if row["table"][1] or row["readings"][1]]
    missing = [row["state"] for row in states if row not in met]
    words = f"coverage {robot['role']}: {len(met)} of {len(states)} entries of the table"
    return words + (f"; not met: {spans(missing)}" if missing else "")


def _missed(source: SourceCoverage) -> str:
    """Return the lines that were not executed, or not decided both ways."""
    missed = [
        line.line
        for line in source.lines
        if not line.count or any(one.taken < len(one.ways) for one in line.decisions)
    ]
    return f"; not met in full: lines {spans(missed)}" if missed else ""


def spans(numbers: Sequence[int]) -> str:
    """Return rising numbers, those in a row together.

    >>> spans([1, 2, 3, 7, 9, 10])
    '1-3, 7, 9-10'
    """
    parts = []
    for _, row in groupby(enumerate(numbers), lambda pair: pair[1] - pair[0]):
        found = [number for _, number in row]
        parts.append(str(found[0]) if len(found) == 1 else f"{found[0]}-{found[-1]}")
    return ", ".join(parts)
