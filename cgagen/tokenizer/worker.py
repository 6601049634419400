"""The tokenizer's process: started when needed, never shared, killed when it does not answer."""

import base64
import json
import os
import select
import subprocess
import tempfile
import time
import weakref
from importlib import resources
from pathlib import Path
from typing import IO, Any

from cgagen.errors import ToolchainError
from cgagen.signals import held
from cgagen.toolchain import TOKENIZER_SHA256, find_node, find_tokenizer
from cgagen.toolchain.node import clean_environment

START_LIMIT_S = 60.0
"""How long the worker may take to load the tokenizer. Ref: choice; measured 0.2 s."""


class WorkerDiedError(Exception):
    """The process ended in the middle of a question."""


class WorkerStuckError(Exception):
    """The process gave no answer in time and was killed."""


class Worker:
    """One Node process that answers one line with one line.

    Raises:
        ToolchainError: Node or the tokenizer is missing, or the process does not start.
    """

    def __init__(self, command: list[str] | None = None, start_limit_s: float = START_LIMIT_S):
        self._owner = os.getpid()
        self._questions = 0
        self._rest = b""
        words, environment = command or _command(), clean_environment()
        # stderr goes to a file, so that a chatty Node can neither block nor disturb the terminal.
        with _scratch() as errors:
            try:
                with held():  # a process that has begun is known, and so is ended
                    self._process = subprocess.Popen(
                        words,
                        stdin=subprocess.PIPE,
                        stdout=subprocess.PIPE,
                        stderr=errors,
                        env=environment,
                        bufsize=0,
                        process_group=0,  # Ctrl-C is for us; the worker ends with its stdin
                    )
                    _alive.add(self)
                    self._end = weakref.finalize(self, _end, self._process, self._owner)
            except OSError as error:
                raise ToolchainError(
                    f"the tokenizer's process does not start ({error.strerror}); "
                    "run `cgagen doctor`"
                ) from error
            try:
                self._greet(start_limit_s)
            except (WorkerDiedError, WorkerStuckError) as error:
                self.kill()
                errors.seek(0)
                told = errors.read(2000).decode("utf-8", "replace").strip().splitlines()
                raise ToolchainError(
                    f"the tokenizer's process did not start ({_cause(error, told)}); "
                    "run `cgagen doctor`"
                ) from error
            except BaseException:
                self.kill()
                raise

    @property
    def pid(self) -> int:
        """The process's number, for those who want to kill it."""
        return self._process.pid

    @property
    def usable(self) -> bool:
        """Whether this very process started it and it has not ended."""
        return self._owner == os.getpid() and self._process.poll() is None

    def ask(self, source: str, limit_s: float) -> dict[str, Any]:
        """Return the tokenizer's record for one source.

        Raises:
            WorkerDiedError: the process ended, or threw.
            WorkerStuckError: no answer in `limit_s` seconds; the process is gone.
        """
        self._questions += 1
        question = json.dumps({"id": self._questions, "source": source})
        try:
            self._write(question.encode("ascii") + b"\n", time.monotonic() + limit_s)
            answer = self._read(time.monotonic() + limit_s)
        except BaseException:
            self.kill()  # also on Ctrl-C: a late answer must not meet the next question
            raise
        if answer.get("id") != self._questions or "fatal" in answer:
            self.kill()
            raise WorkerDiedError(str(answer.get("fatal", "an answer out of turn")))
        for field in ("eeprom", "flags"):
            answer[field] = base64.b64decode(answer[field])
        return answer

    def kill(self) -> None:
        """End the process and wait for it; harmless when it is over already."""
        self.forget()

    def forget(self) -> None:
        """Close this side's pipes without touching the process: what a forked child does."""
        self._end()

    def _greet(self, limit_s: float) -> None:
        for pipe in (self._process.stdin, self._process.stdout):
            assert pipe is not None  # both were asked for
            os.set_blocking(pipe.fileno(), False)
        answer = self._read(time.monotonic() + limit_s)
        if "ready" not in answer:
            raise WorkerDiedError(str(answer.get("fatal", "no greeting")))

    def _write(self, data: bytes, deadline_s: float) -> None:
        pipe = self._process.stdin
        assert pipe is not None
        rest = memoryview(data)
        while rest:
            _wait(pipe.fileno(), select.POLLOUT, deadline_s)
            try:
                rest = rest[os.write(pipe.fileno(), rest) :]
            except BlockingIOError:
                continue
            except OSError as error:
                raise WorkerDiedError(error.strerror or "broken pipe") from error

    def _read(self, deadline_s: float) -> dict[str, Any]:
        pipe = self._process.stdout
        assert pipe is not None
        chunks = [self._rest]
        while b"\n" not in chunks[-1]:
            _wait(pipe.fileno(), select.POLLIN, deadline_s)
            try:
                chunk = os.read(pipe.fileno(), 1 << 16)
            except BlockingIOError:
                continue
            if not chunk:
                raise WorkerDiedError("it ended")
            chunks.append(chunk)
        line, _, self._rest = b"".join(chunks).partition(b"\n")
        try:
            answer = json.loads(line)
        except ValueError as error:
            raise WorkerDiedError("an answer that is not JSON") from error
        if not isinstance(answer, dict):
            raise WorkerDiedError("an answer that is no record")
        return answer


def _wait(descriptor: int, event: int, deadline_s: float) -> None:
    poll = select.poll()
    poll.register(descriptor, event)
    if not poll.poll(max(0.0, deadline_s - time.monotonic()) * 1000):
        raise WorkerStuckError("no answer in time")


def _scratch() -> IO[bytes]:
    try:
        return tempfile.TemporaryFile()
    except OSError:  # a full disk must not keep anyone from compiling
        return open(os.devnull, "w+b")


def _end(process: subprocess.Popen[bytes], owner: int) -> None:
    if owner == os.getpid():  # a forked child has no right to end its parent's worker
        process.kill()
        process.wait()
    for pipe in (process.stdin, process.stdout):
        if pipe is not None and not pipe.closed:
            pipe.close()


_alive: "weakref.WeakSet[Worker]" = weakref.WeakSet()


def _after_fork() -> None:
    # A child that kept the pipes open would keep the worker alive after its parent's death.
    for worker in list(_alive):
        worker.forget()


os.register_at_fork(after_in_child=_after_fork)


def _command() -> list[str]:
    script = resources.files("cgagen.tokenizer") / "worker.cjs"
    return [str(find_node().path), str(Path(str(script))), str(find_tokenizer()), TOKENIZER_SHA256]


def _cause(error: Exception, words: list[str]) -> str:
    for line in words:
        if "Error" in line:
            return line.strip()
    return words[0] if words else str(error)
