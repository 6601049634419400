"""What one run of pytest has found out about the firmware, and what it writes at its end.

Under pytest-xdist every worker has a session of its own; what it has found goes to the
controller as JSON, and only that one writes.
"""

import json
import os
import shlex
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from cgagen.pytest_plugin.options import HilConfig, asked, given, in_ini_file
from cgagen.pytest_plugin.ours import (
    HERE,
    ROLES,
    errors,
    load,
    make_folders,
    reason_of,
    reference_folder,
    subject_for,
    without_outputs,
)
from cgagen.pytest_plugin.told import NOT_TRIED, chips_not_asked, told

if TYPE_CHECKING:
    from hil.benches import Counted
    from hil.equivalence import Trial
    from hil.evidence import Evidence
    from hil.subject import Subject

WORKER = "cgagen_hil"
"""Key of what a worker hands over."""

REQUIREMENT, VERDICT, LEVEL = "hil_req", "hil_verdict", "hil_level"
"""Properties of a test in JUnit's file."""

DECIDING = ("target", "legs", "genome", "robot", "build", "level", "seed", "trace")
"""Options without which a test is another."""

PASSED, FAILED, SKIPPED = "passed", "failed", "skipped"

BLOCKED, UNPROVEN = "BLOCKED", "UNPROVEN"
"""Of a test that has failed, and not because a decision was wrong."""


class HilSession:
    """The run.

    Args:
        config: pytest's.

    Attributes:
        config: see there.
        outcomes: of tests of firmware, by name: passed, failed, skipped, BLOCKED or UNPROVEN.
        requirements: names of tests, by the id of the requirement.
        left_out: why tests of firmware were skipped, by name.
        failed: what was asked for could not be written.
    """

    def __init__(self, config: pytest.Config) -> None:
        self.config = config
        self.outcomes: dict[str, str] = {}
        self.requirements: dict[str, list[str]] = {}
        self.left_out: dict[str, str] = {}
        self.failed = False
        self._asked: HilConfig | None = None
        self._evidence: dict[str, Evidence] = {}
        self._handed: list[dict[str, Any]] = []
        self._lost = 0
        self._counted: Counted | None = None
        self._stack = ExitStack()

    @property
    def asked(self) -> HilConfig:
        """What was asked for.

        Raises:
            pytest.UsageError: see `options.asked`.
        """
        if self._asked is None:
            self._asked = asked(self.config)
        return self._asked

    def start(self) -> None:
        """Begin to count executed lines, if they are wanted, and look at the files of a report.

        Raises:
            pytest.UsageError: a file that could not be read or written at the end.
        """
        if self.asked.writes or self.asked.kills or self.asked.requirements:
            self._check_files()
        if self.asked.counts and self._counted is None:
            benches = load("hil.benches")
            self._counted = benches.Counted()
            self._stack.enter_context(benches.looking(self._counted))

    def _check_files(self) -> None:
        """Refuse what could not be read or written at the end, before the tests.

        Raises:
            pytest.UsageError: a sentence that says what and where.
        """
        asked, report = self.asked, load("hil.report")
        read = [*asked.traces, *asked.kills, asked.genome, asked.robot, asked.requirements]
        try:
            make_folders(given(self.config, "report"))
            files = report.report_files(asked.reports)
            if asked.coverage is not None:
                files += load("hil.coverage_files").coverage_files(asked.coverage)
            load("cgagen.outputs").check_outputs(
                [(path, kind) for path, kind in files if path.parent.is_dir()],
                [Path(one) for one in read if one is not None],
                asked.force,
            )
            list(map(report.read_kills, asked.kills))  # read again for the report
            load("hil.requirements").read_requirements(self.asked.requirements)
        except errors().CgagenError as error:
            raise pytest.UsageError(str(error)) from error

    def evidence(self, subject: "Subject") -> "Evidence":
        """Return what is known of a firmware."""
        key = " ".join([subject.robot.digest, *(one.digest for one in subject.images.values())])
        if key not in self._evidence:
            self._evidence[key] = load("hil.evidence").Evidence(subject)
        return self._evidence[key]

    def note(self, name: str, subject: "Subject", trial: "Trial") -> None:
        """Remember what came of a test's trial."""
        self.evidence(subject).trial(name, trial)

    def note_test(self, report: pytest.TestReport) -> None:
        """Remember how a test of firmware has ended; a phase that is worse stays."""
        words = [name for name, _ in report.user_properties]
        if {LEVEL, REQUIREMENT, VERDICT}.isdisjoint(words):
            return
        last = [str(value) for name, value in report.user_properties if name == VERDICT][-1:]
        unknown = report.failed and last in ([BLOCKED], [UNPROVEN])
        outcome = last[0] if unknown else str(report.outcome)
        before = self.outcomes.get(report.nodeid, PASSED)
        self.outcomes[report.nodeid] = outcome if before == PASSED else before
        if report.skipped and last == [NOT_TRIED]:
            self.left_out[report.nodeid] = reason_of(report)
        for name, value in report.user_properties:
            if name == REQUIREMENT:
                tests = self.requirements.setdefault(str(value), [])
                tests += [] if report.nodeid in tests else [report.nodeid]

    def take(self, handed: str | None) -> None:
        """Take what a worker hands over; None from one that has died."""
        self._lost += handed is None
        self._handed += json.loads(handed or "[]")

    def hand_over(self) -> str:
        """Return what was found, for the controller."""
        return json.dumps(self._robots())

    def finish(self) -> list[str]:
        """Write what was asked for; returns lines for the terminal."""
        self._stack.close()
        if not self._knows:
            return []
        robots = self._robots()
        lines = [
            line for robot in robots for line in told(robot, self.asked.level, self.asked.seed)
        ]
        lines += [f"{NOT_TRIED} {name}: {why}" for name, why in sorted(self.left_out.items())]
        if self.left_out:
            lines.append(f"UNPROVEN: {len(self.left_out)} tests of firmware were not tried")
        lines += chips_not_asked(robots)
        if self._lost:
            lines.append(f"BLOCKED: {self._lost} workers have died with what they had found")
        try:
            if self.asked.coverage is not None:
                lines += load("hil.coverage_files").write_coverage(self.asked.coverage, robots)
            if self.asked.reports:
                lines += [f"report: {file}" for file in self._write_reports(robots)]
        except errors().CgagenError as error:
            self.failed = True
            lines.append(f"not written: {error}")
        return lines

    def again(self, nodeid: str = "") -> str:
        """Return the command that repeats this run, or one test of it.

        Folders of this machine are left out where the run began in them.
        """
        if nodeid:
            file, *rest = nodeid.split("::", 1)
            here = os.path.relpath(self.config.rootpath / file, self.config.invocation_params.dir)
            words = ["::".join([here, *rest]), *self._options()]
        else:
            words = without_outputs(list(map(str, self.config.invocation_params.args)))
        root = str(self.config.invocation_params.dir)
        near = ("." if word == root else word.replace(f"{root}/", "") for word in words)
        return shlex.join(["pytest", *near])

    def _options(self) -> list[str]:
        """Return the options of this run that say what is tried; the ini file says its own."""
        return [
            part
            for name in DECIDING
            if not in_ini_file(self.config, name)
            for one in given(self.config, name)
            for part in (f"--hil-{name}", one)
        ]

    @property
    def _knows(self) -> bool:
        """Whether there is anything to tell; in the runs of others nothing of ours is imported."""
        return bool(self._evidence or self._handed or self._counted or self.left_out)

    def _robots(self) -> list[dict[str, Any]]:
        """Return what is known of each firmware, by this process and by all workers."""
        if not self._knows:
            return []
        module = load("hil.evidence")
        if self._counted is not None:
            self._count()
        found: dict[str, dict[str, Any]] = {}
        for data in [*(one.data() for one in self._evidence.values()), *self._handed]:
            key = module.key_of(data)
            both = module.merged(found[key], data) if key in found else data
            found[key] = both | {"trials": dict(sorted(both["trials"].items()))}
        return [found[key] for key in sorted(found)]

    def _count(self) -> None:
        """Put the counted lines to the firmware that they are of."""
        counted, compile_source = self._counted, load("cgagen.tokenizer").compile_source
        if counted is None:
            return
        known = {image.digest for one in self._evidence.values() for image in _images(one)}
        for role in ROLES:
            if reference_folder(role).is_dir():
                subject = subject_for(HilConfig((), None, None, None, "", 1, False), role)
                met = {image.digest for image in subject.images.values()} & {*counted.coverage}
                if met - known:
                    self.evidence(subject)
        for one in self._evidence.values():
            one.count(counted, compile_source)

    def _write_reports(self, robots: list[dict[str, Any]]) -> list[Path]:
        report, requirements = load("hil.report"), load("hil.requirements")
        verdict = load("hil.equivalence").Verdict
        words = {FAILED: "FAIL", BLOCKED: BLOCKED, UNPROVEN: UNPROVEN, SKIPPED: NOT_TRIED}
        texts = requirements.read_requirements(self._requirements_file())
        data = report.report_of(
            robots,
            self.asked.level,
            self.asked.seed,
            self.again(),
            [report.read_kills(path) for path in self.asked.kills],
            requirements.matrix(texts, self.requirements, self.outcomes),
            [verdict(words[one]) for one in self.outcomes.values() if one in words]
            + [verdict.BLOCKED] * self._lost,
            self.left_out,
        )
        files: list[Path] = report.write_reports(self.asked.reports, data)
        return files

    def _requirements_file(self) -> Path | None:
        """Return what was named; for a run of cgagen's own tests, their own."""
        ours = any(name.startswith("hil/test_") for name in self.outcomes)
        own = HERE / "hil" / "requirements.toml"
        return self.asked.requirements or (own if ours and own.is_file() else None)


def _images(evidence: "Evidence") -> list[Any]:
    return list(evidence.subject.images.values())


SESSION = pytest.StashKey[HilSession]()


class Ears:
    """Hears how tests end, those of the workers, too; the hook says nothing of whose run it is."""

    def __init__(self, session: HilSession) -> None:
        self._session = session

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Remember how tests of firmware have ended."""
        self._session.note_test(report)
