"""Signals that ask for the end: every one of them is a Ctrl-C, and the exit code says which."""

import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

ASKING: tuple[int, ...] = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

TWICE_S = 0.5
"""Signals so close are one wish: `timeout` sends its own to a process and to its group. Choice."""

BY_SHELL = 128
"""What a shell adds to a signal's number. Ref: POSIX, 2.8.2."""


class AskedToEndError(KeyboardInterrupt):
    """What a signal raises: Ctrl-C, whichever signal it was.

    Of a class of its own: where a plain KeyboardInterrupt leaves an `exec` of Python's own, as in
    the making of a dataclass, CPython ends the process as by SIGINT whatever exit code it is given.
    """


class _Hold:
    """Whether the main thread is at something that must not be torn apart."""

    depth = 0
    pending = False


@contextmanager
def held() -> Iterator[None]:
    """Put a signal off that comes in the block: what is made in it is made, and known, or not.

    For short blocks, in which nothing is waited for.

    Raises:
        AskedToEndError: behind the block, where one came.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    _Hold.depth += 1
    try:
        yield
    finally:
        _Hold.depth -= 1
        if not _Hold.depth and _Hold.pending:
            _Hold.pending = False
            raise AskedToEndError


class Asked:
    """Which signal has asked for the end.

    Attributes:
        number: of the first; None where none has.
    """

    def __init__(self) -> None:
        self.number: int | None = None
        self._last_s = float("-inf")

    def __call__(self, number: int, frame: FrameType | None) -> None:
        """Be the handler: end what is under way, as Ctrl-C does.

        Raises:
            AskedToEndError: unless this is the same wish again, or is to be put off.
        """
        self.number = self.number or number
        before_s, self._last_s = self._last_s, time.monotonic()
        if self._last_s - before_s > TWICE_S:
            if not _Hold.depth:
                raise AskedToEndError
            _Hold.pending = True

    @property
    def name(self) -> str:
        """What a user calls it."""
        if self.number in (None, signal.SIGINT):
            return "Ctrl-C"
        return signal.Signals(self.number or 0).name

    @property
    def exit_code(self) -> int:
        """What a shell makes of it; of Ctrl-C where no signal has asked."""
        return BY_SHELL + (self.number or signal.SIGINT)


@contextmanager
def signals_end(asked: Asked) -> Iterator[None]:
    """Take the signals that ask for the end, but those that whoever began us has switched off.

    Outside the main thread, where Python has no signals, nothing is changed.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    found = {number: signal.getsignal(number) for number in ASKING}
    ours = {
        number: handler
        for number, handler in found.items()
        if handler in (signal.SIG_DFL, signal.default_int_handler)
    }
    try:
        for number in ours:
            signal.signal(number, asked)
        yield
    finally:
        for number, handler in ours.items():
            signal.signal(number, handler)
