"""A port behind RFC 2217: telnet with options for DTR, BREAK and the speed."""

import selectors
import struct
from typing import Any

from cgagen.serve.endpoint import Endpoint, Ready
from cgagen.serve.paced import PacedPort
from cgagen.serve.sockets import address_of, listen

MOST_OPTION_BYTES = 256
"""A telnet option longer than that is garbage. Choice."""

_GARBAGE = (KeyError, TypeError, ValueError, struct.error)
"""What `PortManager` raises at options that are none."""


class Rfc2217Endpoint(Endpoint):
    """A socket that carries DTR, BREAK and the speed as telnet options: `rfc2217://HOST:PORT`."""

    def __init__(self, port: PacedPort, host: str, number: int) -> None:
        super().__init__(port)
        self._listener = listen(host, number)
        self._listeners.append(self._listener)
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
