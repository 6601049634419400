"""Sockets that wait for clients."""

import socket
from collections.abc import Callable

from cgagen.errors import RigError

MOST_ROUNDS = 64
"""How often a host is read before another one is looked at. Choice: 16 kB."""


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


def accept(listener: socket.socket) -> socket.socket | None:
    """Return a client that has come; None where it went away again."""
    try:
        connection, _ = listener.accept()
    except OSError:
        return None
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return connection
