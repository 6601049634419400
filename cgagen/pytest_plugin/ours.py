"""Modules of cgagen, imported when a test first asks for something; and what is on trial."""

import importlib
import importlib.util
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from cgagen.pytest_plugin.options import (
    BUILD,
    FIRMWARE,
    GENOME,
    ROBOT,
    HilConfig,
    asked,
    given,
    refuse_without_effect,
)

if TYPE_CHECKING:
    from hil.subject import Subject

ROLES = ("predator", "prey")
NAMED = ("named",)
REFERENCE = Path("firmware")
"""Folder of the reference builds, beside `hil/` in a checkout of cgagen."""

HERE = Path(__file__).parent.parent.parent
"""Where `cgagen`, `hil` and `sim` lie side by side."""


OUTPUTS = ("record", "vcd", "coverage", "artifacts", "report")
"""Options that change nothing of what is tried."""


def load(name: str) -> Any:
    """Import a module of ours, or say which folder is in the place of hil/ or sim/.

    Raises:
        pytest.UsageError: another hil/ or sim/ comes first on the path.
    """
    for room in ("hil", "sim"):
        spec = importlib.util.find_spec(room)
        ours = HERE / room
        if spec is None or not spec.origin or Path(spec.origin).parent.resolve() != ours.resolve():
            raise pytest.UsageError(
                f"cgagen's {name} cannot be imported: a folder {room}/ of your own hides ours, so "
                "rename it, or run pytest from elsewhere"
            )
    return importlib.import_module(name)


def reference_folder(role: str) -> Path:
    """Return where the reference build of a robot would be."""
    return HERE / REFERENCE / role


def errors() -> Any:
    """Return the tree of errors; it needs nothing else of ours, whatever lies in a project."""
    return importlib.import_module("cgagen.errors")


def make_folders(words: Iterable[str]) -> None:
    """Make what ends in a slash, for who writes into folders only where they are.

    Raises:
        StorageError: one cannot be made.
    """
    for word in words:
        if word.endswith("/"):
            load("cgagen.files").make_folder(Path(word))


def subjects_of(named: bool) -> tuple[str, ...]:
    """Return what is on trial: what was named, or in a checkout of cgagen both references."""
    return ROLES if not named and reference_folder(ROLES[0]).is_dir() else NAMED


def of_reference(config: pytest.Config, file: Path) -> bool:
    """Whether a test that asks for no firmware, in a file of hil/, is not of what was named."""
    named = any(given(config, name) for name in FIRMWARE)
    return named and file.is_relative_to(HERE / "hil")


def subject_for(wanted: HilConfig, role: str) -> "Subject":
    """Return what is on trial: what was named, or the reference.

    Raises:
        pytest.UsageError: nothing was named, and this is no checkout of cgagen; or a genome or a
            robot was named beside a build, and the build is not of it.
    """
    read = load("hil.subject").read_subject
    subject: Subject
    if wanted.build:
        subject = read(Path(wanted.build))
        return _held(subject, wanted)
    if wanted.genome or wanted.robot:
        return _built(wanted)
    folder = reference_folder(role)
    if not folder.is_dir():
        raise pytest.UsageError(
            "no firmware was named; give --hil-genome FILE, --hil-robot NAME or --hil-build DIR"
        )
    subject = read(folder)
    return subject


def _held(subject: "Subject", wanted: HilConfig) -> "Subject":
    """Return a build that is of the genome and the robot that were named beside it, if any were."""
    if not (wanted.genome or wanted.robot):
        return subject
    genome = load("cgagen.genome").load(Path(wanted.genome)) if wanted.genome else None
    robot = load("cgagen.robot").load_robot(wanted.robot) if wanted.robot else None
    try:
        same: Subject = load("hil.subject").held(subject, robot, genome)
    except errors().MismatchError as error:
        raise pytest.UsageError(str(error)) from error
    return same


def refuse_contradictions(config: pytest.Config) -> None:
    """Refuse options that have no effect, or a build that is not of what was named beside it.

    What is named in the environment alone may be meant for another run; it is looked at when a
    test asks for it.

    Raises:
        pytest.UsageError: the first of them, or something of a build cannot be read.
    """
    refuse_without_effect(config)
    ours = any(
        config.getoption(f"--hil-{name}", None) or config.getini(f"hil_{name}") for name in FIRMWARE
    )
    if ours and given(config, BUILD) and (given(config, GENOME) or given(config, ROBOT)):
        try:
            subject_for(asked(config), NAMED[0])
        except errors().CgagenError as error:
            raise pytest.UsageError(str(error)) from error


def _built(wanted: HilConfig) -> "Subject":
    """Return the firmware of a genome and a robot, built now."""
    read, robots = load("cgagen.genome").load, load("cgagen.robot")
    genome = read(Path(wanted.genome)) if wanted.genome else None
    if genome is not None and wanted.genome:
        robot = load("cgagen.whose").match(genome, Path(wanted.genome), wanted.robot).robot
    else:
        robot = robots.load_robot(wanted.robot or "")
    with load("cgagen.tokenizer").Tokenizer() as tokenizer:
        build = load("cgagen.build").make_build(robot, genome, tokenizer)
    subject: Subject = load("hil.subject").subject_of(build, wanted.genome or robot.name)
    return subject


def reason_of(report: pytest.TestReport) -> str:
    """Return why a test was skipped: the last of what pytest keeps of it."""
    kept = report.longrepr
    words = str(kept[-1]) if isinstance(kept, tuple) else str(kept)
    return " ".join(words.removeprefix("Skipped: ").split())


def without_outputs(words: list[str]) -> list[str]:
    """Return the words of a command line without those that only say where results go.

    >>> without_outputs(["hil/", "--hil-report", "x.html", "--hil-record=d", "-q"])
    ['hil/', '-q']
    """
    found, skip = list[str](), False
    for word in words:
        name, _, value = word.removeprefix("--hil-").partition("=")
        if skip or (word.startswith("--hil-") and name in OUTPUTS):
            skip = not skip and not value
        else:
            found.append(word)
    return found
