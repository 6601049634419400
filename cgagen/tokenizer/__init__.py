"""Parallax's own tokenizer: PBASIC in, the EEPROM image with its source map out.

The tokenizer is a program of 2001 to 2013 in a JavaScript wrapping of 2015; it runs in a Node
process of its own and is asked line by line. What is wrong with it stays inside this package:
it loses the memory of every source, never returns from some comments at the end of a file,
changes some characters silently, accepts pins that no chip has, and reports no place for some
errors. Ref: S3, every one of them measured.
"""

import os
import threading
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from cgagen.closing import Closing
from cgagen.errors import ToolchainError
from cgagen.stamp.chips import chip_of_target
from cgagen.stamp.compiled import Compiled, SourceMap, Statement, VariableCounts
from cgagen.stamp.image import Image
from cgagen.tokenizer.refusal import refusal, refuse_wrong_pins
from cgagen.tokenizer.text import Lines, Sent, sendable
from cgagen.tokenizer.warn import warnings_of
from cgagen.tokenizer.worker import Worker, WorkerDiedError, WorkerStuckError

__all__ = ["Tokenizer", "compile_source"]

ANSWER_LIMIT_S = 20.0
"""How long one source may take. Ref: choice; the longest measured took 0.1 s."""


class Tokenizer(Closing):
    r"""The tokenizer, ready for any number of sources from any number of threads.

    The process starts with the first source, is started anew when it dies, and is never shared
    with a forked child, which gets its own.

    Args:
        limit_s: how long one source may take before the process is killed.
        command: another program in the worker's place.
        warn: told every warning once, as a sentence with file, line and column; they are in
            `Compiled.warnings` all the same.

    >>> with Tokenizer() as tokenizer:
    ...     compiled = tokenizer.compile("' {$STAMP BS2}\nHIGH 3\n", "led.bs2")
    >>> compiled.image.eeprom[-4:].hex(), compiled.source_map.statements[0].line
    ('140e07c0', 2)
    """

    def __init__(
        self,
        limit_s: float = ANSWER_LIMIT_S,
        *,
        command: list[str] | None = None,
        warn: Callable[[str], None] = lambda _: None,
    ) -> None:
        self._limit_s = limit_s
        self._command = command
        self._warn = warn
        self._warned: set[str] = set()
        self._worker: Worker | None = None
        self._owner = os.getpid()
        self._lock = threading.Lock()
        self._closed = False

    def compile(self, source: str, name: str = "program") -> Compiled:
        """Return what the tokenizer makes of a source.

        Args:
            source: PBASIC 2.0 or 2.5, with a `$STAMP` directive.
            name: what the source is called in messages.

        Raises:
            SourceError: it is refused; the sentence has line and column where there is one.
            ToolchainError: no Node, no tokenizer, or one that dies or hangs.
            ValueError: this tokenizer is closed.
        """
        sent = sendable(source, name)
        record = self._ask(sent.text, name)
        if not record["ok"]:
            raise refusal(
                sent.text, name, record["error"], record["error_start"], record["error_length"]
            )
        compiled = _compiled(sent, name, record)
        refuse_wrong_pins(compiled)
        compiled = replace(compiled, warnings=warnings_of(compiled, source, sent.strays))
        for warning in compiled.warnings:
            words = f"{name}:{warning.line}:{warning.column}: warning: {warning.text}"
            if words not in self._warned:
                self._warned.add(words)
                self._warn(words)
        return compiled

    def close(self) -> None:
        """End the process. Harmless when repeated."""
        self._closed = True
        if self._worker is not None and self._owner == os.getpid():
            self._worker.kill()
        self._worker = None

    @property
    def pid(self) -> int | None:
        """The worker's process number; None while none runs."""
        return self._worker.pid if self._worker is not None and self._worker.usable else None

    def _ask(self, text: str, name: str) -> dict[str, Any]:
        if self._owner != os.getpid():
            # Forked: the lock may be held by a thread that does not exist here.
            self._owner, self._lock, self._worker = os.getpid(), threading.Lock(), None
        with self._lock:
            for last in (False, True):
                if self._closed:
                    raise ValueError("this tokenizer is closed")
                if self._worker is None or not self._worker.usable:
                    self._worker = Worker(self._command)
                try:
                    return self._worker.ask(text, self._limit_s)
                except WorkerStuckError as error:
                    raise ToolchainError(
                        f"{name}: the tokenizer gave no answer in {self._limit_s:g} s and was "
                        "stopped; shorten the source until it does, and report what was left out"
                    ) from error
                except WorkerDiedError as error:
                    if last:
                        raise ToolchainError(
                            f"{name}: the tokenizer's process died twice ({error}); "
                            "run `cgagen doctor`, or try again with more memory free"
                        ) from error
        raise AssertionError("unreachable")  # the loop returns or raises


_shared: Tokenizer | None = None


def compile_source(source: str, name: str = "program") -> Compiled:
    """Return what `Tokenizer.compile` returns, from one tokenizer that this process shares.

    Raises:
        SourceError: see `Tokenizer.compile`.
        ToolchainError: likewise.
    """
    global _shared  # noqa: PLW0603  one process, one worker: that is the point
    if _shared is None:
        _shared = Tokenizer()
    return _shared.compile(source, name)


def _compiled(sent: Sent, name: str, record: dict[str, Any]) -> Compiled:
    lines = Lines(sent.source)
    places = ((sent.original(offset), bit) for offset, bit in record["map"])
    image = Image(chip_of_target(record["target"]), record["eeprom"], record["flags"])
    return Compiled(
        name=name,
        source=sent.source,
        image=image,
        variables=VariableCounts(*record["variables"]),
        source_map=SourceMap(
            tuple(Statement(offset, *lines.place(offset), bit) for offset, bit in places)
        ),
        project_files=tuple(record["files"]),
        port=record["port"],
        language=record["language"],
        debugs=record["debugs"],
    )
