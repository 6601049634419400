"""One session per port: a second one is refused in a sentence instead of spoiling both."""

import fcntl
import os
import tempfile
from pathlib import Path
from typing import IO

from cgagen.errors import RigError
from cgagen.files import digest


class PortLock:
    """A lock on a port's name, gone with the process that has it.

    Args:
        port: device path or URL.
    """

    def __init__(self, port: str) -> None:
        self._port = port
        real = os.path.realpath(port) if "://" not in port else port
        self._path = Path(tempfile.gettempdir()) / f"cgagen-port-{digest(real)[:16]}.lock"
        self._file: IO[bytes] | None = None

    def take(self) -> None:
        """Take it.

        Raises:
            RigError: another session has it.
        """
        try:
            file = open(self._path, "a+b")  # held as long as the port
        except OSError as error:
            raise RigError(
                f"{self._port}: its lock {self._path} cannot be opened ({error.strerror}); "
                "remove that file, or ask whose it is"
            ) from error
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            file.close()
            raise RigError(
                f"{self._port}: another session of cgagen has this port; wait for its end"
            ) from error
        self._file = file

    def release(self) -> None:
        """Give it back. Harmless when repeated."""
        if self._file is not None:
            self._file.close()
            self._file = None
