"""Locks on ports: one session of a user's at a time.

A lock is an empty file in a folder that is the user's alone, there as long as its session. What
keeps two users of one machine apart is the device's own lock (`cgagen.link.quiet`): a file that
everybody can foresee, in a folder that everybody can write to, would be anybody's to take.
"""

import fcntl
import os
import stat
from contextlib import suppress
from pathlib import Path

from cgagen.errors import RigError
from cgagen.files import digest
from cgagen.link.steered import split_control

PREFIX, SUFFIX = "port-", ".lock"
_PRIVATE = 0o700
_OTHERS = 0o077
_FLAGS = os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC
"""Nothing that stands there is followed, and none of it holds us up."""

_TRIES = 100
"""Files that may vanish between opening and locking, before that is no chance. Choice."""


class PortLock:
    """A lock on a port's name, gone with the process that has it.

    Args:
        port: device path or URL.
    """

    def __init__(self, port: str) -> None:
        self._port = port
        name, _ = split_control(port)
        real = os.path.realpath(name) if "://" not in name else name
        self._name = f"{PREFIX}{digest(real)[:16]}{SUFFIX}"
        self._path: Path | None = None
        self._handle: int | None = None

    def take(self) -> None:
        """Take it.

        Raises:
            RigError: another session has it, or there is no folder for it.
        """
        try:
            path = lock_folder() / self._name
            handle = _locked(path)
        except (OSError, RuntimeError) as error:  # the latter: nobody's home
            what = getattr(error, "strerror", None) or error
            raise RigError(
                f"{self._port}: no lock can be had for it ({what}); set XDG_RUNTIME_DIR to a "
                "folder of your own"
            ) from error
        if handle is None:
            raise RigError(
                f"{self._port}: another session of cgagen has this port; wait for its end"
            )
        self._path, self._handle = path, handle

    def release(self) -> None:
        """Give it back, and remove its file. Harmless when repeated."""
        if self._handle is not None and self._path is not None:
            with suppress(OSError):
                self._path.unlink()
            os.close(self._handle)
            self._handle = None


def lock_folder() -> Path:
    """Return the folder of this user's locks, made where there is none.

    Raises:
        OSError: it cannot be made, or is not this user's alone.
        RuntimeError: nobody says where this user is at home.
    """
    base = os.environ.get("XDG_RUNTIME_DIR", "")
    if not (os.path.isabs(base) and _is_private(Path(base))):
        cache = os.environ.get("XDG_CACHE_HOME", "")
        base = cache if os.path.isabs(cache) else str(Path.home() / ".cache")
    folder = Path(base) / "cgagen" / "ports"
    folder.mkdir(_PRIVATE, parents=True, exist_ok=True)
    found = folder.lstat()
    if stat.S_ISDIR(found.st_mode) and found.st_uid == os.geteuid() and found.st_mode & _OTHERS:
        folder.chmod(_PRIVATE)
    if not _is_private(folder):
        raise PermissionError(0, f"{folder} is not a folder of this user's alone")
    return folder


def _is_private(folder: Path) -> bool:
    """Whether a folder is this user's, and nobody else's."""
    try:
        found = folder.lstat()
    except OSError:
        return False
    mine = stat.S_ISDIR(found.st_mode) and found.st_uid == os.geteuid()
    return mine and not found.st_mode & _OTHERS


def _locked(path: Path) -> int | None:
    """Return a lock's file, open and locked; None where somebody else has it.

    Raises:
        OSError: something else stands there.
    """
    for _ in range(_TRIES):
        handle = os.open(path, _FLAGS, 0o600)
        try:
            if not stat.S_ISREG(os.fstat(handle).st_mode):
                raise OSError(0, f"{path} is no file")
            if not _take(handle):
                os.close(handle)
                return None
            if os.fstat(handle).st_nlink:
                return handle
        except OSError:
            os.close(handle)
            raise
        os.close(handle)  # whose it was has removed it meanwhile
    raise OSError(0, f"{path} is removed as soon as it is made")


def _take(handle: int) -> bool:
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True
