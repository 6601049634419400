"""Where a host finds a chip's port, and a plain socket with another one for its lines.

Every endpoint has one host at a time; who comes second is let go at once, for a Stamp has one
plug. A host that goes away lets go of DTR and BREAK. Nothing here waits.
"""

import selectors
import socket
from collections.abc import Callable

from cgagen.serve.control import ControlText
from cgagen.serve.paced import PacedPort
from cgagen.serve.sockets import accept, address_of, drain, listen
from cgagen.serve.stream import Stream

Ready = Callable[[], object]


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
        self._listeners: list[socket.socket] = []
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
        self.hang_up()

    def hang_up(self) -> None:
        """Let hosts know that nothing comes any more, without asking the chip for anything."""
        for listener in self._listeners:
            listener.close()
        if self.data is not None:
            self.data.close()

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
        self._listeners.append(self._control_listener)
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

    def hang_up(self) -> None:
        """See `Endpoint`."""
        super().hang_up()
        if self._hand is not None:
            self._hand.close()

    def close(self) -> None:
        """Let both hosts go, and be found no more."""
        self._lose_hand()
        super().close()

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
        self._listeners.append(self._listener)
        self.url = f"socket://{address_of(self._listener)}"

    def wanted(self) -> dict[int, tuple[int, Ready]]:
        """Return what is waited for; see `Endpoint`."""
        return {
            **super().wanted(),
            self._listener.fileno(): (selectors.EVENT_READ, self._comes),
        }

    def _comes(self) -> None:
        self._welcome(self._listener)
