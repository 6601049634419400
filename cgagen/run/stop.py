"""A signal that asks for the end, as a wish: the run ends after the generation that it is in."""

import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

from cgagen.signals import ASKING, TWICE_S

Stopped = Callable[[], bool]
"""Says whether somebody asked for the end; asked once per generation."""


def never() -> bool:
    """Nobody asks for the end."""
    return False


@contextmanager
def stop_on_signals() -> Iterator[Stopped]:
    """Turn the first signal that asks for the end into a wish; a second one ends all at once.

    Outside the main thread, where Python has no signals, nothing is changed.
    """
    if threading.current_thread() is not threading.main_thread():
        yield never
        return
    wished_s: list[float] = []

    def ask(number: int, frame: FrameType | None) -> None:
        now_s = time.monotonic()
        if not wished_s:
            wished_s.append(now_s)
        elif now_s - wished_s[0] > TWICE_S:
            handler = before[number]
            if callable(handler):
                handler(number, frame)
            raise KeyboardInterrupt

    found = {number: signal.getsignal(number) for number in ASKING}
    before = {number: handler for number, handler in found.items() if handler is not signal.SIG_IGN}
    try:
        for number in before:
            signal.signal(number, ask)
        yield lambda: bool(wished_s)
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
