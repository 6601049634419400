"""Ctrl-C as a wish: the run ends after the generation that it is in."""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

Stopped = Callable[[], bool]
"""Says whether somebody asked for the end; asked once per generation."""


def never() -> bool:
    """Nobody asks for the end."""
    return False


@contextmanager
def stop_on_signals() -> Iterator[Stopped]:
    """Turn the first SIGINT or SIGTERM into a wish, and a second one into `KeyboardInterrupt`.

    Outside the main thread, where Python has no signals, nothing is changed.
    """
    if threading.current_thread() is not threading.main_thread():
        yield never
        return
    wish = threading.Event()

    def ask(number: int, frame: FrameType | None) -> None:
        if wish.is_set():
            raise KeyboardInterrupt
        wish.set()

    before = {number: signal.signal(number, ask) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield wish.is_set
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
