"""What sort of file it is that `cgagen info` was given: by its content, and then by its name."""

import re
from collections.abc import Callable
from enum import StrEnum
from pathlib import Path

from cgagen.errors import CgagenError, StrangerError
from cgagen.inputs import MIB, Kind, read_bytes, start_of
from cgagen.near import did_you_mean
from cgagen.shown import short
from cgagen.stamp.chips import EEPROM_BYTES


class Sort(StrEnum):
    """What there is, as sentences call it."""

    RUN = "a run"
    BUILD = "a build"
    REPORTS = "a folder of reports"
    ROBOT = "a robot"
    ARENA = "an arena"
    GENOME = "a genome"
    IMAGE = "an image"
    SOURCE = "a PBASIC source"
    BENCH = "a bench"
    TRACE = "a trace"
    SIDECAR = "what lies beside a trace"
    FRAMES = "a description of frames"
    REPORTS_CSV = "a table of generations"
    POPULATION = "a table of a population"
    MEASUREMENTS = "a table of measurements"
    INSTRUCTIONS = "a trace of instructions"
    SOURCE_MAP = "a source map"
    WAVEFORM = "a waveform"
    COVERAGE = "coverage for LCOV"
    LISTING = "a listing of coverage"
    CHECKPOINT = "a checkpoint"
    DECISIONS = "decisions"
    REPORT = "a report"
    PAGE = "a report's page"
    KILLS = "a kill matrix"
    MEMORY = "a memory report"
    WIRING = "a wiring table"
    TEMPLATE = "a template"
    RECORD = "a run's record"
    BUILD_RECORD = "a build's record"


LARGEST = 64 * MIB
"""Bytes of a file that is looked into. Choice: of the largest kind that cgagen writes itself."""

ANY = Kind(
    "a file of cgagen's",
    LARGEST,
    StrangerError,
    "name a genome, a run, a build, a robot, an arena, a bench, a source, an image or a trace",
)

_HEAD = 65_536
"""Bytes that tell what a file is. Choice."""

_FORMATS = {
    "cgagen-robot-1": Sort.ROBOT,
    "cgagen-arena-1": Sort.ARENA,
    "cgagen-genome-1": Sort.GENOME,
    "cgagen-bench-1": Sort.BENCH,
    "cgagen-run-1": Sort.RECORD,
    "cgagen-build-1": Sort.BUILD_RECORD,
    "cgagen-trace-1": Sort.SIDECAR,
    "cgagen-hil-report-1": Sort.REPORT,
    "cgagen-kills-1": Sort.KILLS,
}
_FORMAT = re.compile(r'^[\s{]*"?format"?\s*[=:]\s*"([a-z-]+-\d+)"', re.MULTILINE)
_TRACE_NAME = re.compile(r"\.(log(\.gz)?|csv|asc|blf|trc)$", re.IGNORECASE)
_SOURCE_NAME = re.compile(r"\.(bs2|bse|bsx|bsp|bpe)$", re.IGNORECASE)

_TEXTS: tuple[tuple[Sort, re.Pattern[str]], ...] = (
    (Sort.PAGE, re.compile(r"<!doctype html>.*firmware on trial</title>", re.DOTALL | re.I)),
    (Sort.DECISIONS, re.compile(r'\{"seq": \d+, "reading": ')),
    (Sort.FRAMES, re.compile(r'VERSION "cgagen-rig-\d+"')),
    (Sort.WAVEFORM, re.compile(r"\$(timescale|version|date|comment|scope)\s")),
    (Sort.COVERAGE, re.compile(r"TN:")),
    (Sort.LISTING, re.compile(r"coverage of .*: \d+ of \d+ lines")),
    (Sort.REPORTS_CSV, re.compile(r"generation,mean,best,worst,captured\s*$", re.MULTILINE)),
    (Sort.POPULATION, re.compile(r"individual,training_fitness,")),
    (Sort.INSTRUCTIONS, re.compile(r"time_us,slot,bit,line,instruction\s*$", re.MULTILINE)),
    (Sort.SOURCE_MAP, re.compile(r"line,column,bit\s*$", re.MULTILINE)),
    (Sort.MEASUREMENTS, re.compile(r"movement,cycles,along_|sensor,distance_")),
    (Sort.MEMORY, re.compile(r"\S.* \(BS2\w*\): \d+ bytes of EEPROM\n")),
    (Sort.WIRING, re.compile(r"Wiring of .*, a (predator|prey)\n")),
    (Sort.SOURCE, re.compile(r".*'\s*\{\$(STAMP|PBASIC)\b", re.DOTALL | re.I)),
    (Sort.GENOME, re.compile(r"[01\s]+\Z")),
)
"""How texts of ours begin. The first that fits counts."""

_STRANGERS: tuple[tuple[str, Callable[[bytes], bool]], ...] = (
    ("a PNG picture", lambda head: head.startswith(b"\x89PNG")),
    ("a JPEG picture", lambda head: head.startswith(b"\xff\xd8\xff")),
    ("a GIF picture", lambda head: head.startswith(b"GIF8")),
    ("an SVG picture", lambda head: b"<svg" in head[:1000]),
    ("a PDF document", lambda head: head.startswith(b"%PDF")),
    ("a program", lambda head: head.startswith((b"\x7fELF", b"MZ", b"\xcf\xfa\xed\xfe"))),
    ("a script", lambda head: head.startswith(b"#!")),
    ("a ZIP archive", lambda head: head.startswith(b"PK")),
    ("packed by gzip", lambda head: head.startswith(b"\x1f\x8b")),
    ("a NumPy array", lambda head: head.startswith(b"\x93NUMPY")),
    ("text of 16 bits a character (UTF-16)", lambda head: head[:2] in (b"\xff\xfe", b"\xfe\xff")),
    ("binary data", lambda head: b"\0" in head),
    ("a web page", lambda head: bool(re.match(rb"\s*<(!doctype )?html", head, re.I))),
    ("XML", lambda head: head.lstrip().startswith(b"<?xml")),
    ("JSON", lambda head: bool(re.match(rb'\s*(\{\s*("|\})|\[\s*["{\[\d])', head))),
)
"""What is none of ours, and how one sees it."""


def sort_of(path: Path) -> Sort:
    """Return what a file or a folder is.

    Args:
        path: as the user has named it; a robot's or an arena's name where no file has it.

    Raises:
        StrangerError: it is none of ours, with what it seems to be; or it is not there.
    """
    if _is(path, Path.is_dir):
        return _folder(path)
    if not _is(path, Path.exists):
        return _named(path)
    head = start_of(path, _HEAD)
    if head is None:
        read_bytes(path, ANY)  # says what is in the way
        raise StrangerError(f"{path}: cannot be looked at; {ANY.mend}")
    if not head.strip() and path.suffix.lower() != ".bin":
        what = "is empty" if not head else "holds nothing but blanks"
        raise StrangerError(f"{path}: {what}; {ANY.mend}")
    found = _binary(path, head) or _text(path, head)
    if found is None:
        raise StrangerError(
            f"{path}: seems to be {_stranger(path, head)}, none of ours; {ANY.mend}"
        )
    return found


def _folder(path: Path) -> Sort:
    for name, sort in (("build.json", Sort.BUILD), ("0-run.toml", Sort.RUN)):
        if (path / name).is_file():
            return sort
    if any((path / f"hil-report{suffix}").is_file() for suffix in (".html", ".json")):
        return Sort.REPORTS
    try:
        names = sorted(one.name for one in path.iterdir())
    except OSError as error:
        raise StrangerError(f"{path}: cannot be read ({error.strerror}); {ANY.mend}") from error
    holds = f"it holds {', '.join(names[:4])}{', ...' if len(names) > 4 else ''}"
    raise StrangerError(
        f"{path}: is a folder, and neither a run nor a build "
        f"({holds if names else 'it is empty'}); {ANY.mend}"
    )


def _named(path: Path) -> Sort:
    """Return what a name stands for that no file bears."""
    from cgagen.robot import shipped

    robots, arenas = shipped("robot"), shipped("arena")
    if str(path) in robots:
        return Sort.ROBOT
    if str(path) in arenas:
        return Sort.ARENA
    meant = did_you_mean(path.name, [*_beside(path), *robots, *arenas])
    raise StrangerError(
        f"{path}: no such file{meant}; name a file or folder, or one of "
        f"{', '.join([*robots, *arenas])}"
    )


def _beside(path: Path) -> list[str]:
    try:
        return [one.name for one in path.parent.iterdir()]
    except (OSError, ValueError):
        return []


def _binary(path: Path, head: bytes) -> Sort | None:
    name = path.name.lower()
    if name.endswith(".bin") or (len(head) == EEPROM_BYTES and b"\0" in head):
        return Sort.IMAGE
    if head.startswith(b"PK") and b"format.npy" in head[:200]:
        return Sort.CHECKPOINT
    if name.endswith((".blf", ".log.gz")):
        return Sort.TRACE
    return None


def _text(path: Path, head: bytes) -> Sort | None:
    if b"\0" in head and not _SOURCE_NAME.search(path.name):
        return None
    text = head.decode("utf-8", "replace").removeprefix("\ufeff").replace("\r\n", "\n")
    format_found = _FORMAT.search(text)
    if format_found and format_found[1] in _FORMATS:
        return _FORMATS[format_found[1]]
    if _SOURCE_NAME.search(path.name):
        return Sort.SOURCE
    for sort, pattern in _TEXTS:
        if pattern.match(text):
            return sort
    if path.suffix == ".genome":
        return Sort.GENOME  # whatever is wrong with it, its reader says
    if path.name.endswith((".j2", ".jinja")):
        return Sort.TEMPLATE
    return Sort.TRACE if _TRACE_NAME.search(path.name) else None


def _stranger(path: Path, head: bytes) -> str:
    if path.suffix == ".toml" and b"\0" not in head:
        given = _FORMAT.search(head.decode("utf-8", "replace"))
        said = f"of the format {short(given[1])}" if given else "without a format of ours"
        known = ", ".join(sorted(key for key in _FORMATS if key.split("-")[1] in _OF_TOML))
        return f"TOML {said} ({known})"
    for what, fits in _STRANGERS:
        if fits(head):
            return what
    try:
        head.decode()
    except UnicodeDecodeError as error:
        if len(head) < _HEAD or error.start < _HEAD - 4:  # the last character may be cut
            return "binary data, or text that is not UTF-8"
    return "text"


_OF_TOML = ("robot", "arena", "genome", "bench", "run")


def _is(path: Path, asks: Callable[[Path], bool]) -> bool:
    try:
        return asks(path)
    except (OSError, ValueError) as error:
        raise _refused(path, error) from error


def _refused(path: Path, error: OSError | ValueError) -> CgagenError:
    why = error.strerror if isinstance(error, OSError) else "no file can have such a name"
    return StrangerError(f"{str(path)[:80]!r}: cannot be looked at ({why}); {ANY.mend}")
