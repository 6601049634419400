"""Clients of a served port, pyserial's and plain sockets, and programs that talk to them."""

import socket
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

import serial

from cgagen.emulator.bench import Bench
from cgagen.emulator.programs import bench_of_image
from cgagen.serve import Server
from cgagen.stamp.chips import EEPROM_BYTES, chip
from cgagen.stamp.image import Image
from cgagen.stamp.packets import packets_of

LIMIT_S = 60
"""How long a client waits for what must come; nothing is judged by how soon it comes."""


HELLO = '\' {$STAMP BS2}\nDEBUG "hello", CR\nEND\n'
TALKS = '\' {$STAMP BS2}\nagain:\nDEBUG "0123456789abcdefghijklmnopqrstuvwxyz"\nGOTO again\n'


def erased(model: str = "BS2") -> Bench:
    return bench_of_image(Image(chip(model), bytes(EEPROM_BYTES)))


class Client:
    """A computer with a port: pyserial's, and the socket with DTR and BREAK where it has none."""

    def __init__(self, server: Server) -> None:
        self.hand: socket.socket | None = None
        if server.control is not None:
            self.hand = connect(server.control)
        self.port = serial.serial_for_url(server.url, do_not_open=True)
        self.port.baudrate, self.port.timeout = 9600, LIMIT_S
        with suppress(OSError, ValueError):
            self.port.dtr = self.port.rts = False
        self.port.open()

    def line(self, name: str, on: bool) -> None:
        if self.hand is None:
            setattr(self.port, "dtr" if name == "DTR" else "break_condition", on)
            return
        said = f"{name} {int(on)}\n".encode()
        self.hand.sendall(said)
        assert self.hand.recv(64) == said

    def enter(self) -> None:
        for name, on in (("BREAK", True), ("DTR", True), ("DTR", False), ("BREAK", False)):
            self.line(name, on)
        time.sleep(0.01)
        self.port.reset_input_buffer()

    def ask(self, data: bytes, answers: int = 1) -> bytes:
        self.port.write(data)
        found: bytes = self.port.read(len(data) + answers)
        assert found[: len(data)] == data
        return found[len(data) :]

    def download(self, image: Image) -> None:
        self.enter()
        assert b"".join(self.ask(bytes([byte])) for byte in b"BS2\0") == b"\xbe\xad\xce\x10"
        for one in packets_of(image):
            assert self.ask(one) == b"\0"

    def close(self) -> None:
        self.port.close()
        if self.hand is not None:
            self.hand.close()


def connect(address: str) -> socket.socket:
    host, _, number = address.rpartition("/")[2].rpartition(":")
    return socket.create_connection((host, int(number)), LIMIT_S)


def heard(host: socket.socket, count: int) -> bytes:
    found = b""
    while len(found) < count and (piece := host.recv(count - len(found))):
        found += piece
    return found


@contextmanager
def client_of(server: Server) -> Iterator[Client]:
    client = Client(server)
    try:
        yield client
    finally:
        client.close()


def until(true: Callable[[], object]) -> None:
    """Wait for something that another thread brings about."""
    end = time.monotonic() + LIMIT_S
    while not true():
        assert time.monotonic() < end, "it never came"
        time.sleep(0.005)
