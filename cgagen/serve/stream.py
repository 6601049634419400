"""Bytes to and from one host, without ever waiting for it."""

import os
import socket

READ_BYTES = 256
"""What is taken from a host at once. Choice: a quarter of a second of the chip's time."""

MOST_BACKLOG = 65_536
"""What may wait for a host that does not read; then the chip's time stands still. Choice."""


class Stream:
    """One host.

    Args:
        handle: of a socket or a terminal; it is closed with the stream.

    Attributes:
        open: the host is there.
    """

    def __init__(self, handle: socket.socket | int) -> None:
        self._socket = handle if isinstance(handle, socket.socket) else None
        self._number = handle if isinstance(handle, int) else handle.fileno()
        self._backlog = bytearray()
        self.open = True
        os.set_blocking(self._number, False)

    def fileno(self) -> int:
        """Return what a selector wants."""
        return self._number

    @property
    def backlog(self) -> int:
        """Bytes that the host has not taken."""
        return len(self._backlog)

    @property
    def full(self) -> bool:
        """Whether so much waits for the host that no more should come."""
        return len(self._backlog) > MOST_BACKLOG

    def read(self) -> bytes:
        """Return what the host has said; nothing where it has not, or is gone (see `open`)."""
        try:
            data = os.read(self._number, READ_BYTES)
        except BlockingIOError:
            return b""
        except OSError:
            data = b""
        if not data:
            self.open = False
        return data

    def write(self, data: bytes) -> None:
        """Give the host bytes behind those that wait."""
        self._backlog += data
        self.flush()

    def flush(self) -> None:
        """Give the host what it takes of what waits."""
        while self._backlog and self.open:
            try:
                del self._backlog[: os.write(self._number, self._backlog)]
            except BlockingIOError:
                return
            except OSError:
                self.open = False

    def close(self) -> None:
        """Let the host go."""
        self.open = False
        if self._socket is not None:
            self._socket.close()
        elif self._number >= 0:
            os.close(self._number)
            self._number = -1
