"""What may stand at the name of an output, each made for the test."""

import os
import socket
import stat
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest


def null_device(path: Path) -> Path:
    """Make a null device of the test's own; skip where this user may not."""
    try:
        os.mknod(path, 0o666 | stat.S_IFCHR, os.stat("/dev/null").st_rdev)
        path.write_bytes(b"x")
    except OSError as error:
        pytest.skip(f"no device can be made here: {error}")
    return path


def is_null_device(path: Path) -> bool:
    """Whether a null device is still one."""
    found = path.stat()
    return stat.S_ISCHR(found.st_mode) and found.st_rdev == os.stat("/dev/null").st_rdev


class Reader:
    """Reads something to its end in a thread."""

    def __init__(self, handle: int | None = None, path: Path | None = None) -> None:
        self._handle, self._path = handle, path
        self._data = b""
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def _read(self) -> None:
        if self._handle is None and self._path is not None:
            self._handle = os.open(self._path, os.O_RDONLY)
        while self._handle is not None and (data := os.read(self._handle, 1 << 16)):
            self._data += data

    def text(self) -> bytes:
        """Return all that came, once the writer has closed."""
        self._thread.join(60)
        assert not self._thread.is_alive(), "nobody has closed it"
        return self._data


@contextmanager
def fifo(path: Path) -> Iterator[Reader]:
    """A named pipe that somebody reads."""
    os.mkfifo(path)
    yield Reader(path=path)


@contextmanager
def pipe_name() -> Iterator[tuple[str, Reader]]:
    """A pipe by the name that a shell's `>(...)` has."""
    reading, writing = os.pipe()
    reader = Reader(reading)
    try:
        yield f"/dev/fd/{writing}", reader
    finally:
        os.close(writing)
        reader.text()
        os.close(reading)


@contextmanager
def listening() -> Iterator[tuple[Path, Reader]]:
    """A socket that somebody listens at; its name is short enough for one."""
    with tempfile.TemporaryDirectory() as folder, socket.socket(socket.AF_UNIX) as server:
        path = Path(folder) / "s"
        server.bind(str(path))
        server.listen()
        held: list[socket.socket] = []

        class Taken(Reader):
            def _read(self) -> None:
                held.append(server.accept()[0])
                self._handle = held[0].fileno()
                super()._read()

        yield path, Taken()
        for one in held:
            one.close()
