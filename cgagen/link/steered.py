"""A port whose DTR and BREAK travel beside it: as lines of text on a second socket.

A plain socket and a pty carry bytes alone. Whoever serves a Stamp on one of them can offer a
second socket, where `DTR 1`, `DTR 0`, `BREAK 1` and `BREAK 0` are said, each answered by itself
when the chip has seen it. The port's name then has that address behind it::

    socket://127.0.0.1:4000?control=127.0.0.1:4001
    /dev/pts/5?control=127.0.0.1:4001
"""

import socket
from contextlib import suppress
from typing import Any

SIGN = "?control="

CONTROL_S = 5.0
"""How long a line may take until the chip has seen it. Choice."""


def split_control(name: str) -> tuple[str, str]:
    """Return a port's own name, and where its lines of control are; "" where nowhere.

    >>> split_control("/dev/pts/5?control=127.0.0.1:4001")
    ('/dev/pts/5', '127.0.0.1:4001')
    """
    base, _, control = name.partition(SIGN)
    return base, control


def has_lines(name: str) -> bool:
    """Say whether a port of this name may have DTR and BREAK: a plain socket has neither.

    >>> has_lines("socket://bench:4000"), has_lines("socket://bench:4000?control=bench:4001")
    (False, True)
    """
    base, control = split_control(name)
    return bool(control) or not base.startswith(("socket://", "loop://"))


class SteeredPort:
    """A port of pyserial's with its lines elsewhere; everything else is the port's own.

    Args:
        port: open.
        control: HOST:PORT.

    Raises:
        OSError: nobody is there.
        ValueError: that is no address.
    """

    def __init__(self, port: Any, control: str) -> None:
        host, _, number = control.rpartition(":")
        self._port = port
        self._levels = {"DTR": False, "BREAK": False}
        self._socket = socket.create_connection((host, int(number)), CONTROL_S)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._port, name)

    @property
    def dtr(self) -> bool:
        """DTR, asserted or not."""
        return self._levels["DTR"]

    @dtr.setter
    def dtr(self, on: bool) -> None:
        self._set("DTR", on)

    @property
    def break_condition(self) -> bool:
        """Whether the line is held at space."""
        return self._levels["BREAK"]

    @break_condition.setter
    def break_condition(self, on: bool) -> None:
        self._set("BREAK", on)

    def close(self) -> None:
        """Close both."""
        self._socket.close()
        self._port.close()

    def _set(self, line: str, on: bool) -> None:
        word = f"{line} {int(on)}"
        self._socket.sendall(f"{word}\n".encode("ascii"))
        answer = b""
        with suppress(TimeoutError):
            while not answer.endswith(b"\n") and (piece := self._socket.recv(64)):
                answer += piece
        if answer.strip() != word.encode("ascii"):
            raise OSError(f"{word} was answered with {answer!r}")
        self._levels[line] = on
