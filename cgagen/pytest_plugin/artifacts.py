"""What a single test leaves behind: decisions, waveforms, and the words of its failure."""

import re
import shutil
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from cgagen.pytest_plugin.options import ALWAYS, OFF, HilConfig
from cgagen.pytest_plugin.ours import errors, load
from cgagen.pytest_plugin.session import SESSION

if TYPE_CHECKING:
    from cgagen.emulator.bench import Bench
    from cgagen.outputs import Kind
    from hil.decisions import Decision
    from hil.subject import Subject
    from hil.target import Stimulus, Target

FAILURE = "failure.txt"
AGAIN = "again: "
"""What the words of a failure begin with."""

DECISIONS = "decisions.jsonl"
WAVEFORM = "{}.vcd"


def file_name(nodeid: str) -> str:
    """Return the name of a test as a file's: the same on every machine.

    >>> file_name("hil/test_a.py::test_b[predator-serial:/dev/x]")
    'hil-test_a.py-test_b-predator-serial-dev-x'
    """
    return re.sub(r"[^\w.]+", "-", nodeid).strip("-.")


class TestFiles:
    """The artifacts of the test that runs.

    Args:
        item: the test.
        wanted: what was asked for.
    """

    __test__ = False

    def __init__(self, item: pytest.Item, wanted: HilConfig) -> None:
        self._item = item
        self._wanted = wanted
        self._name = file_name(item.nodeid)
        self._folder = wanted.folder / self._name if wanted.folder else None
        self._stack = ExitStack()
        self._waveforms: list[Path] = []
        self._asked: dict[str, tuple[Target, Subject, list[Decision]]] = {}

    def folder(self) -> Path:
        """Return the test's own folder, which is kept.

        Raises:
            pytest.UsageError: no folder for artifacts was named.
        """
        if self._folder is None:
            raise pytest.UsageError("hil_artifacts wants a folder; name one: --hil-artifacts DIR")
        return self._made(self._folder)

    def begin(self, funcargs: "dict[str, Any]") -> None:
        """Watch the targets that a test was given."""
        for name in ("hil_target", "hil_registers"):
            target: Any = funcargs.get(name)
            if hasattr(target, "decide") and "hil_subject" in funcargs:
                self.watch(name.removeprefix("hil_"), target, funcargs["hil_subject"])
        bench = getattr(funcargs.get("hil_target"), "bench", None)
        if bench is not None and self._wanted.vcd != OFF:
            compile_source = load("cgagen.tokenizer").compile_source
            load("hil.benches").know_lines(bench, funcargs["hil_subject"], compile_source)
            self.record(bench, "target")

    def watch(self, name: str, target: "Target", subject: "Subject") -> None:
        """Write down what a target is asked from now on."""
        if name in self._asked or not (self._folder or self._wanted.record):
            return
        if self._wanted.record is not None:
            self._check(self._record_files(self._wanted.record, name))
        decisions: list[Decision] = []
        self._asked[name] = (target, subject, decisions)
        made, ask = load("hil.decisions").Decision, target.decide

        def decide(stimulus: "Stimulus") -> Any:
            seen = ask(stimulus)
            decisions.append(made(stimulus, seen))
            return seen

        target.decide = decide  # type: ignore[method-assign]
        self._stack.callback(lambda: target.__dict__.pop("decide", None))

    def record(self, bench: "Bench", name: str) -> None:
        """Draw the wires of a bench from now on, where waveforms are wanted."""
        if self._wanted.vcd == OFF or self._folder is None:
            return
        path = self._made(self._folder) / WAVEFORM.format(file_name(name))
        self._check([(path, load("cgagen.emulator.vcd").WAVEFORM)])
        self._waveforms.append(path)
        recording = load("cgagen.emulator.recording").record_bench(path, bench)
        waveform = self._stack.enter_context(recording)
        bench.on_restore.append(waveform.rejoin)
        self._stack.callback(bench.on_restore.remove, waveform.rejoin)

    def finish(self, failure: str) -> None:
        """Close everything; keep what is to be kept.

        Args:
            failure: why the test has failed; "" where it has not.
        """
        self._stack.close()
        if self._wanted.record is not None:
            self._write_records(self._made(self._wanted.record))
        if not failure and self._wanted.vcd != ALWAYS:
            for path in self._waveforms:
                path.unlink(missing_ok=True)
        if failure and self._folder is not None:
            again = self._item.config.stash[SESSION].again(self._item.nodeid)
            failure = re.sub(r" at 0x[0-9a-f]+", "", failure.rstrip())  # another in every run
            text = f"{AGAIN}{again}\n\n{failure}"
            self._write_failure(self._made(self._folder), text)
        folder = self._folder
        if folder is not None and folder.is_dir() and not failure and not any(folder.iterdir()):
            shutil.rmtree(folder)

    def _write_failure(self, folder: Path, failure: str) -> None:
        words = load("cgagen.outputs").begins("the words of a failure", AGAIN)
        lines = load("hil.decisions").DECISION_LINES
        asked = [folder / f"{name}-{DECISIONS}" for name, (*_, told) in self._asked.items() if told]
        self._check([(folder / FAILURE, words), *((path, lines) for path in asked)])
        load("cgagen.files").write_text(folder / FAILURE, failure.rstrip() + "\n")
        for name, (_, _, decisions) in self._asked.items():
            if decisions:
                write = load("hil.decisions").write_decisions
                write(folder / f"{name}-{DECISIONS}", decisions)

    def _write_records(self, folder: Path) -> None:
        """Write the decisions as lines and as a trace that every target can replay."""
        for name, (target, subject, decisions) in self._asked.items():
            if not decisions:
                continue
            path = folder / f"{self._name}-{name}.jsonl"
            load("hil.decisions").write_decisions(path, decisions)
            trace = load("hil.records").trace_of(subject, target, decisions, self._wanted.seed)
            log = path.with_suffix(".log")
            load("hil.traces").write_trace(log, trace, subject.robot, force=True)

    def _record_files(self, folder: Path, name: str) -> "list[tuple[Path, Kind]]":
        """Return what will be written of a target, each with its kind."""
        path = folder / f"{self._name}-{name}.jsonl"
        if not folder.is_dir():
            return []
        frames: list[tuple[Path, Kind]]
        frames = load("hil.traces.storage").trace_files(path.with_suffix(".log"))
        return [(path, load("hil.decisions").DECISION_LINES), *frames]

    def _check(self, files: "list[tuple[Path, Kind]]") -> None:
        """Refuse to write over what is not of ours.

        Raises:
            pytest.UsageError: see `cgagen.outputs.check_outputs`.
        """
        try:
            load("cgagen.outputs").check_outputs(files, force=self._wanted.force)
        except errors().CgagenError as error:
            raise pytest.UsageError(f"{error} (here: --hil-force)") from error

    @staticmethod
    def _made(folder: Path) -> Path:
        load("cgagen.files").make_folder(folder)
        return folder


Draw = Callable[["Bench", str], None]
FILES = pytest.StashKey[TestFiles]()
