"""The report: all that is known of the firmware on trial, as `hil-report.json` and as one page.

The same trials give the same bytes: no dates, no names or folders of the machine.
"""

import json
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from cgagen import __version__
from cgagen.emulator.coverage_report import LineCoverage, SourceCoverage
from cgagen.errors import FolderError, RunError
from cgagen.files import write_text
from cgagen.inputs import KILLS, read_bytes
from cgagen.notations import parse_json
from cgagen.outputs import Kind, begins
from cgagen.places import place_of
from cgagen.stamp.scan import lines_of
from hil.equivalence import Verdict, worst
from hil.evidence import source_coverage
from hil.kills import FORMAT as KILLS_FORMAT
from hil.report_page import PAGE_MARK, page_text

FORMAT = "cgagen-hil-report-1"
FILES = {".json": "hil-report.json", ".html": "hil-report.html"}
"""What a folder is given, by suffix."""

KINDS = {
    ".json": begins("a report", f'{{\n "format": "{FORMAT}"'),
    ".html": Kind("a report", lambda head: PAGE_MARK.encode() in head[:1000]),
}


def report_of(
    robots: Iterable[Mapping[str, Any]],
    level: str,
    seed: int,
    again: str,
    kills: Sequence[Mapping[str, Any]] = (),
    requirements: Sequence[Mapping[str, Any]] = (),
    verdicts: Iterable[Verdict] = (),
    left_out: Mapping[str, str] | None = None,
) -> dict[str, Any]:
    """Return the report, as JSON has it.

    Args:
        robots: data of each `Evidence`.
        level: how much was tried.
        seed: of what was chosen by chance.
        again: the command that repeats it.
        kills: matrices of `hil.kills`; those of other images are left out.
        requirements: rows of `hil.requirements.matrix`.
        verdicts: of what is no trial of a robot, such as tests that failed otherwise.
        left_out: why tests were skipped, by name; the whole is UNPROVEN then.
    """
    rows = [_robot(data, kills) for data in sorted(robots, key=lambda one: (one["role"], str(one)))]
    skipped = dict(left_out or {})
    found = [*verdicts, *(Verdict(row["verdict"]) for row in rows)]
    found += [Verdict.NOT_TRIED] * len(skipped)
    return {
        "format": FORMAT,
        "cgagen": __version__,
        "verdict": str(worst(found)),
        "level": level,
        "seed": seed,
        "again": again,
        "robots": rows,
        "requirements": list(requirements),
        "not_tried": [{"test": name, "reason": why} for name, why in sorted(skipped.items())],
    }


def report_files(paths: Iterable[Path]) -> list[tuple[Path, Kind]]:
    """Return the files that reports go to, and of which kind each is; before the work.

    Args:
        paths: files whose names end in .html or .json; folders get both; a stream gets JSON.

    Raises:
        FolderError: a name says no kind of report, or its folder is missing.
    """
    files: list[tuple[Path, Kind]] = []
    for path in paths:
        if path.is_dir():
            files += [(path / name, KINDS[suffix]) for suffix, name in FILES.items()]
        else:
            files.append((path, KINDS[_suffix(path)]))
    return files


def write_reports(paths: Iterable[Path], report: Mapping[str, Any]) -> list[Path]:
    """Write a report: `.json`, `.html`, or a folder for both.

    Returns:
        What was written.

    Raises:
        FolderError: see `report_files`.
        StorageError: the disk refuses.
    """
    written = []
    for file, kind in report_files(paths):
        is_page = kind is KINDS[".html"]
        write_text(file, page_text(report) if is_page else json.dumps(report, indent=1) + "\n")
        written.append(file)
    return written


def _suffix(path: Path) -> str:
    """Return which form of a report is meant."""
    suffix = path.suffix.lower()
    if not path.parent.is_dir():
        raise FolderError(f"{path}: there is no folder {path.parent}; make it first")
    if suffix in FILES:
        return suffix
    if place_of(path).is_stream:
        return ".json"
    raise FolderError(
        f"{path}: a report's name ends in .html or .json; name such a file, or a folder that "
        "exists for both"
    )


def read_kills(path: Path) -> dict[str, Any]:
    """Read a kill matrix that `make hil-mutants` has written.

    Raises:
        RunError: it is none.
    """
    try:
        record: dict[str, Any] = parse_json(read_bytes(path, KILLS))
        if record["format"] != KILLS_FORMAT:
            raise ValueError(f"its format is {record['format']}")
        return record
    except (ValueError, KeyError, TypeError) as error:
        raise RunError(
            f"{path}: is no kill matrix ({error}); make one with make hil-mutants"
        ) from error


def _robot(data: Mapping[str, Any], kills: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return what is said of one robot."""
    data = _without_folders(data)
    trials = data["trials"]
    found = [Verdict(trial["verdict"]) for trial in trials.values()]
    if data["proof"] and "cells" not in trials:
        found.append(Verdict(data["proof"]["verdict"]))
    sources = [source_coverage(one) for one in data["coverage"].values()]
    return data | {
        "verdict": str(worst(found)),
        "coverage": [_coverage(one) for one in sources],
        "genes": _genes(data["states"]),
        "kills": next((_kills(one) for one in kills if one["images"] == data["images"]), None),
    }


def _without_folders(data: Mapping[str, Any]) -> dict[str, Any]:
    """Return the data with the name of the build in place of its path."""
    where = str(data["where"])
    name = "/".join(Path(where).parts[-2:]) if Path(where).is_absolute() else where
    if name == where:
        return dict(data)
    text = json.dumps(data).replace(json.dumps(where)[1:-1], json.dumps(name)[1:-1])
    clean: dict[str, Any] = json.loads(text)
    return clean


def _genes(states: Sequence[Mapping[str, Any]]) -> dict[str, int]:
    """Return how many entries of the table there are, were right, and were met by readings."""
    return {
        "all": len(states),
        "agreed": sum(_right(row["table"]) or _right(row["readings"]) for row in states),
        "by_readings": sum(_right(row["readings"]) for row in states),
        "reached": sum(row["reached"] for row in states),
    }


def _right(pair: Sequence[int]) -> bool:
    """Whether something was tried, and all of it agreed."""
    return 0 < pair[0] == pair[1]


def _coverage(source: SourceCoverage) -> dict[str, Any]:
    gone, ways = source.ways
    texts = lines_of(source.source)
    return {
        "name": source.name,
        "lines": len(source.lines),
        "lines_hit": source.lines_hit,
        "branches": ways,
        "branches_hit": gone,
        "missed": [
            {"line": line.line, "text": texts[line.line - 1].strip(), "what": what}
            for line in source.lines
            if (what := _missed(line))
        ],
    }


def _missed(line: LineCoverage) -> str:
    """Return what was not met of a line; "" for nothing."""
    if not line.count:
        return "never executed"
    ways = [
        way
        for one in line.decisions
        for way, count in zip(one.ways, one.counts or (0, 0), strict=True)
        if not count
    ]
    return f"never {' nor '.join(dict.fromkeys(ways))}" if ways else ""


def _kills(record: Mapping[str, Any]) -> dict[str, Any]:
    """Return a kill matrix as it is shown: sums, a row per chip and kind, the survivors."""
    rows = record["rows"]
    checks = sorted({check for row in rows for check in row["by"]})
    sums: Counter[str] = Counter()
    for row in rows:
        sums.update({key: row[key] for key in ("mutants", "killed", "equal", "same_image")})
    reviewed = [one for one in record["survivors"] if one["reason"]]
    return {
        "sums": dict(sums)
        | {"reviewed": len(reviewed), "survived": len(record["survivors"]) - len(reviewed)},
        "checks": checks,
        "rows": rows,
        "reviewed": reviewed,
        "survived": [one for one in record["survivors"] if not one["reason"]],
        "proven": record["proven"],
    }
