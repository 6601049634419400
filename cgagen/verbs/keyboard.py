"""What a user types on stdin, for a program that asks for it."""

import os
import select
import sys
from collections.abc import Callable

from cgagen.emulator.conversation import More

_CHUNK_BYTES = 1024


def typed(text: str) -> bytes:
    r"""Return what a terminal sends for a text: CR for the end of a line.

    >>> typed("one\ntwo")
    b'one\rtwo'
    """
    return text.replace("\r\n", "\r").replace("\n", "\r").encode("cp1252", "replace")


def from_text(text: str) -> More:
    """Return a source of text that is there from the beginning."""
    left = [typed(text)] if text else []
    return lambda _needed: left.pop() if left else None


def from_stdin(at_once: bool, waits: Callable[[], None]) -> More:
    """Return a source that reads stdin when the program wants a byte.

    A pipe is waited for whenever the program wants something, so that the same input gives the
    same run. A user at a terminal is waited for only where the program can do nothing else.

    Args:
        at_once: never wait: the program runs in real time.
        waits: called before the user is waited for.
    """
    try:
        descriptor = sys.stdin.fileno()
    except (AttributeError, OSError, ValueError):  # no stdin, closed, or a test's
        return lambda _needed: None
    interactive = os.isatty(descriptor)

    def more(needed: bool) -> bytes | None:
        if at_once or (interactive and not needed):
            if not select.select([descriptor], [], [], 0)[0]:
                return b""
        elif interactive:
            waits()
        data = os.read(descriptor, _CHUNK_BYTES)
        return typed(data.decode("utf-8", "replace")) if data else None

    return more
