"""A port as a pseudo terminal."""

import os
import pty
import select
import termios
import tty
from contextlib import suppress

from cgagen.serve.endpoint import Controlled, Ready
from cgagen.serve.paced import PacedPort
from cgagen.serve.stream import Stream


class PtyEndpoint(Controlled):
    """A pseudo terminal. Its own speed and BREAK reach nobody; the control socket has BREAK."""

    sleepless = True

    def __init__(self, port: PacedPort, host: str) -> None:
        super().__init__(port, host)
        self._master, slave = pty.openpty()
        tty.setraw(slave)
        self.url = os.ttyname(slave)
        os.close(slave)

    def wanted(self) -> dict[int, tuple[int, Ready]]:
        """Return what is waited for; a host that has come is seen here."""
        if self.data is None and _somebody_has(self._master):
            self.data = Stream(os.dup(self._master))
        return super().wanted()

    def lose(self) -> None:
        """The host is gone, and what it has not read goes too."""
        super().lose()
        with suppress(termios.error):
            termios.tcflush(self._master, termios.TCIOFLUSH)

    def close(self) -> None:
        """See `Controlled`."""
        super().close()
        os.close(self._master)


def _somebody_has(master: int) -> bool:
    """Say whether a host has opened the other end of a pty."""
    poll = select.poll()
    poll.register(master, select.POLLIN)
    return not any(event & select.POLLHUP for _, event in poll.poll(0))
