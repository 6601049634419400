"""What a user types on stdin, for a program that asks for it."""

import codecs
import os
import select
import stat
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


def is_given(at_once: bool) -> bool:
    """Whether stdin is what a user gave a single program, although nobody has said `-`.

    A terminal is, and so are a pipe and a file, of which no more is taken than the program takes.
    A file that somebody has begun to read already is a shell's loop's over its list, and what is
    no such thing (a device, a socket) nobody has typed. A program in real time reads on and on,
    so a terminal alone is its user's.

    Args:
        at_once: the program runs in real time.
    """
    descriptor = _stdin()
    if descriptor is None:
        return False
    if os.isatty(descriptor):
        return True
    try:
        mode = os.fstat(descriptor).st_mode
        if at_once or not (stat.S_ISFIFO(mode) or stat.S_ISREG(mode)):
            return False
        return stat.S_ISFIFO(mode) or os.lseek(descriptor, 0, os.SEEK_CUR) == 0
    except OSError:
        return False


def from_nobody() -> More:
    """Return a source of which nothing comes."""
    return lambda _needed: None


def from_stdin(at_once: bool, waits: Callable[[], None]) -> More:
    """Return a source that reads stdin when the program wants a byte.

    A pipe is waited for whenever the program wants something, so that the same input gives the
    same run; a character at a time is taken out of it, so that the rest is left to others. A user
    at a terminal is waited for only where the program can do nothing else.

    Args:
        at_once: never wait, and take all there is: the program runs in real time.
        waits: called before the user is waited for.
    """
    descriptor = _stdin()
    if descriptor is None:
        return from_nobody()
    interactive = os.isatty(descriptor)
    text = _Typed(descriptor, _CHUNK_BYTES if at_once or interactive else 1)

    def more(needed: bool) -> bytes | None:
        if at_once or (interactive and not needed):
            if not select.select([descriptor], [], [], 0)[0]:
                return b""
        elif interactive:
            waits()
        return text.more()

    return more


class _Typed:
    """What comes from a descriptor, as a terminal sends it.

    Args:
        descriptor: open for reading.
        most: bytes to be read at once.
    """

    def __init__(self, descriptor: int, most: int) -> None:
        self._descriptor = descriptor
        self._most = most
        self._decoder = codecs.getincrementaldecoder("utf-8")("replace")
        self._after_cr = False

    def more(self) -> bytes | None:
        """Return one character or more; None at the end."""
        while True:
            data = os.read(self._descriptor, self._most)
            text = self._decoder.decode(data, final=not data)
            if self._after_cr and text.startswith("\n"):
                text = text[1:]
                self._after_cr = False
            if text:
                self._after_cr = text.endswith("\r")
                return typed(text)
            if not data:
                return None


def _stdin() -> int | None:
    """Return the descriptor of stdin; None where there is none, it is closed, or a test's."""
    try:
        return sys.stdin.fileno()
    except (AttributeError, OSError, ValueError):
        return None
