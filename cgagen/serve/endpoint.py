"""Where a host finds a chip's port: a socket, a pty, or a socket with RFC 2217.

Every endpoint has one host at a time; who comes second is let go at once, for a Stamp has one
plug. A host that goes away lets go of DTR and BREAK. Nothing here waits.
"""

import os
import pty
import select
import selectors
import socket
import struct
import termios
import tty
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from cgagen.errors import RigError
from cgagen.serve.control import ControlText
from cgagen.serve.paced import PacedPort
from cgagen.serve.stream import Stream, accept

Ready = Callable[[], object]

MOST_OPTION_BYTES = 256
"""A telnet option longer than that is garbage. Choice."""

MOST_ROUNDS = 64
"""How often a host is read before another one is looked at. Choice: 16 kB."""

_GARBAGE = (KeyError, TypeError, ValueError, struct.error)
"""What `PortManager` raises at options that are none."""


class Endpoint:
    """What all kinds have in common.

    Args:
        port: of the chip.

    Attributes:
        url: what pyserial opens.
        control: address of the socket for DTR and BREAK, `127.0.0.1:PORT`; None for RFC 2217.
        outgoing: what the host is given of what the chip has sent; for tests that spoil it.
        sleepless: must be looked at now and then even if nothing is ready.
    """

    sleepless = False

    def __init__(self, port: PacedPort) -> None:
        self.port = port
        self.url = ""
        self.control: str | None = None
        self.outgoing: Callable[[bytes], bytes] = lambda data: data
        self.data: Stream | None = None
        port.deliver = self.deliver

    @property
    def present(self) -> bool:
        """Whether a host is there."""
        return self.data is not None

    @property
    def full(self) -> bool:
        """Whether the host does not take what it is given."""
        return self.data is not None and self.data.full

    def deliver(self) -> None:
        """Give the host what has been heard."""
        heard = self.port.take()
        if self.data is not None and heard:
            self.data.write(self.packed(self.outgoing(heard)))

    def packed(self, data: bytes) -> bytes:
        """Return data as it goes over the line."""
        return data

    def wanted(self) -> dict[int, tuple[int, Ready]]:
        """Return what is waited for: events and what to do then, by file number."""
        if self.data is None:
            return {}
        events = selectors.EVENT_READ
        if self.data.backlog:
            events |= selectors.EVENT_WRITE
        return {self.data.fileno(): (events, self._data_ready)}

    def close(self) -> None:
        """Let the host go, and be found no more."""
        self.lose()

    def lose(self) -> None:
        """The host is gone."""
        if self.data is not None:
            self.data.close()
            self.data = None
            self.port.forget()

    def hear(self, data: bytes) -> None:
        """The host has said something."""
        self.port.say(data)

    def _data_ready(self) -> bool:
        """Take what the host has said; returns whether there was something."""
        if self.data is None:
            return False
        data = self.data.read()
        if data:
            self.hear(data)
        if self.data is not None:
            self.deliver()
            self.data.flush()
            if not self.data.open:
                self.lose()
        return bool(data)

    def _welcome(self, listener: socket.socket) -> None:
        """Take a client that comes, unless one is there."""
        drain(self._data_ready)
        connection = accept(listener)
        if connection is None:
            return
        if self.data is not None:
            connection.close()
            return
        self.data = Stream(connection)
        self.came()

    def came(self) -> None:
        """A host has come."""


class Controlled(Endpoint):
    """A port with a second socket for DTR and BREAK."""

    def __init__(self, port: PacedPort, host: str) -> None:
        super().__init__(port)
        self._control_listener = listen(host, 0)
        self.control = address_of(self._control_listener)
        self._text = ControlText(port)
        self._hand: Stream | None = None

    @property
    def present(self) -> bool:
        """Whether a host is there, on either socket."""
        return self.data is not None or self._hand is not None

    def wanted(self) -> dict[int, tuple[int, Ready]]:
        """Return what is waited for; see `Endpoint`."""
        found = super().wanted()
        found[self._control_listener.fileno()] = (selectors.EVENT_READ, self._control_comes)
        if self._hand is not None:
            found[self._hand.fileno()] = (selectors.EVENT_READ, self._hand_ready)
        return found

    def close(self) -> None:
        """Let both hosts go, and be found no more."""
        super().close()
        self._lose_hand()
        self._control_listener.close()

    def _control_comes(self) -> None:
        drain(self._hand_ready)
        connection = accept(self._control_listener)
        if connection is None:
            return
        if self._hand is not None:
            connection.close()
            return
        self._hand = Stream(connection)
        self._text = ControlText(self.port)

    def _hand_ready(self) -> bool:
        if self._hand is None:
            return False
        self._data_ready()  # what was said before the change of a line comes before it
        commands = self._hand.read()
        answers = self._text.take(commands)
        self.deliver()
        self._hand.write("".join(f"{line}\n" for line in answers).encode("ascii"))
        if not self._hand.open or self._hand.full:
            self._lose_hand()
        return bool(commands)

    def _lose_hand(self) -> None:
        if self._hand is not None:
            self._hand.close()
            self._hand = None
            self.port.release()


class TcpEndpoint(Controlled):
    """A plain socket: `socket://HOST:PORT`."""

    def __init__(self, port: PacedPort, host: str, number: int) -> None:
        self._listener = listen(host, number)
        super().__init__(port, host)
        self.url = f"socket://{address_of(self._listener)}"

    def wanted(self) -> dict[int, tuple[int, Ready]]:
        """Return what is waited for; see `Endpoint`."""
        return {
            **super().wanted(),
            self._listener.fileno(): (selectors.EVENT_READ, self._comes),
        }

    def close(self) -> None:
        """See `Controlled`."""
        super().close()
        self._listener.close()

    def _comes(self) -> None:
        self._welcome(self._listener)


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


class Rfc2217Endpoint(Endpoint):
    """A socket that carries DTR, BREAK and the speed as telnet options: `rfc2217://HOST:PORT`."""

    def __init__(self, port: PacedPort, host: str, number: int) -> None:
        super().__init__(port)
        self._listener = listen(host, number)
        self.url = f"rfc2217://{address_of(self._listener)}"
        self._manager: Any = None

    def wanted(self) -> dict[int, tuple[int, Ready]]:
        """Return what is waited for; see `Endpoint`."""
        return {
            **super().wanted(),
            self._listener.fileno(): (selectors.EVENT_READ, self._comes),
        }

    def hear(self, data: bytes) -> None:
        """Tell options from bytes, in the order in which they came."""
        if self._manager is None:
            return
        try:
            for byte in self._manager.filter(data):
                self.port.say(byte)
            garbage = len(self._manager.suboption or b"") > MOST_OPTION_BYTES
        except _GARBAGE:
            garbage = True
        if garbage:
            self.lose()

    def packed(self, data: bytes) -> bytes:
        """Return data with every FFh doubled, which is telnet's sign for an option."""
        return data.replace(b"\xff", b"\xff\xff")

    def close(self) -> None:
        """See `Endpoint`."""
        super().close()
        self._listener.close()

    def lose(self) -> None:
        """The host is gone, and lets go of its lines."""
        if self.data is not None:
            super().lose()
            self.port.release()

    def came(self) -> None:
        """Begin to speak telnet."""
        from serial.rfc2217 import PortManager

        self._manager = PortManager(self.port, self.data)

    def _comes(self) -> None:
        self._welcome(self._listener)


def drain(take: Callable[[], bool]) -> None:
    """Take what a host has said that may be gone, so that another one can come."""
    for _ in range(MOST_ROUNDS):
        if not take():
            return


def listen(host: str, number: int) -> socket.socket:
    """Return a socket that waits for clients.

    Raises:
        RigError: somebody else has that number, or there is no such host.
    """
    try:
        listener = socket.create_server((host, number))
    except (OSError, OverflowError) as error:
        raise RigError(
            f"{host}:{number}: cannot be listened on ({error}); take another number, or 0 for any"
        ) from error
    listener.setblocking(False)
    return listener


def address_of(listener: socket.socket) -> str:
    """Return HOST:PORT."""
    host, number = listener.getsockname()[:2]
    return f"{host}:{number}"


def _somebody_has(master: int) -> bool:
    """Say whether a host has opened the other end of a pty."""
    poll = select.poll()
    poll.register(master, select.POLLIN)
    return not any(event & select.POLLHUP for _, event in poll.poll(0))
