"""Temporary files and folders: one name, and a lock that says whether their maker lives.

What is to be whole or not there is written under a name like `.cgagen-0a1b2c3d.tmp` first. Who was
killed leaves it behind; then nobody holds its lock any more, and the next one that writes in that
folder removes it.
"""

import errno
import fcntl
import os
import re
import secrets
import shutil
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from cgagen.signals import held

PREFIX, SUFFIX = ".cgagen-", ".tmp"
_NAME = re.compile(r"\.cgagen-[0-9a-f]{8}\.tmp")

_TRIES = 100
"""Names, before it is called impossible. Choice; a second one is needed once in a lifetime."""

_MADE: dict[str, int] = {}
"""Temporaries of this process by path, with the process that has made them: a fork has them, too,
and is not to remove them."""


def is_temporary(name: str) -> bool:
    """Whether a name is one of a temporary.

    >>> is_temporary(".cgagen-0123abcd.tmp"), is_temporary("best.genome")
    (True, False)
    """
    return _NAME.fullmatch(name) is not None


@contextmanager
def temporary_file(folder: Path) -> Iterator[tuple[Path, int]]:
    """Give a new file, open for writing, that is gone at the end unless it was renamed.

    Its mode is that of any new file of this user.

    Raises:
        OSError: the folder takes no files.
    """
    with _made(folder) as path:
        with held():
            handle = _new_file(path)
        try:
            yield path, handle
        finally:
            os.close(handle)


@contextmanager
def temporary_folder(folder: Path | None = None) -> Iterator[Path]:
    """Give a new folder, which is gone at the end with all that is in it unless it was renamed.

    Args:
        folder: where; None for the system's place, where nobody else gets at it.

    Raises:
        OSError: the folder takes no folders.
    """
    with _made(folder or Path(tempfile.gettempdir())) as path:
        with held():
            handle = _new_folder(path, 0o700 if folder is None else 0o777)
        try:
            yield path
        finally:
            os.close(handle)


def sweep(folder: Path) -> None:
    """Remove what killed processes of this user have left in a folder."""
    try:
        names = [entry.name for entry in os.scandir(folder) if is_temporary(entry.name)]
    except OSError:
        return
    for name in names:
        path = folder / name
        if str(path) not in _MADE:
            with suppress(OSError):
                _remove_unlocked(path)


def remove_own() -> None:
    """Remove what this process has made and, interrupted at a bad moment, not removed."""
    for path, maker in list(_MADE.items()):
        if maker == os.getpid():
            _remove(Path(path))
            _MADE.pop(path, None)


@contextmanager
def _made(folder: Path) -> Iterator[Path]:
    """Give a name that nobody has, and remove what bears it afterwards."""
    folder = folder.absolute()
    sweep(folder)
    path = folder / f"{PREFIX}{secrets.token_hex(4)}{SUFFIX}"
    for _ in range(_TRIES):
        if not os.path.lexists(path):
            break
        path = folder / f"{PREFIX}{secrets.token_hex(4)}{SUFFIX}"
    _MADE[str(path)] = os.getpid()
    try:
        yield path
    finally:
        _remove(path)
        _MADE.pop(str(path), None)


def _new_file(path: Path) -> int:
    """Create a file and lock it; who sweeps may have looked between the two."""
    for _ in range(_TRIES):
        handle = os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o666)
        if _locked(handle):
            return handle
    raise _hunted(path)


def _new_folder(path: Path, mode: int) -> int:
    """Create a folder and lock it, likewise."""
    for _ in range(_TRIES):
        path.mkdir(mode)
        with suppress(FileNotFoundError):
            handle = os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
            if _locked(handle):
                return handle
    raise _hunted(path)


def _locked(handle: int) -> bool:
    """Lock what is open; False, and closed, where it has been removed meanwhile."""
    with suppress(OSError):  # a disk that cannot lock is never swept either
        fcntl.flock(handle, fcntl.LOCK_EX)
    if os.fstat(handle).st_nlink:
        return True
    os.close(handle)
    return False


def _hunted(path: Path) -> OSError:
    return FileExistsError(errno.EEXIST, "somebody removes it whenever it is made", str(path))


def _remove_unlocked(path: Path) -> None:
    """Remove a temporary whose maker is gone.

    Raises:
        OSError: its maker lives, or it is not ours to remove.
    """
    flags = os.O_RDWR if stat.S_ISREG(path.lstat().st_mode) else os.O_RDONLY | os.O_DIRECTORY
    handle = os.open(path, flags | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        mine, there = os.fstat(handle), path.lstat()
        same = (mine.st_dev, mine.st_ino) == (there.st_dev, there.st_ino)
        if same and mine.st_uid == os.geteuid():
            _remove(path)
    finally:
        os.close(handle)


def _remove(path: Path) -> None:
    with suppress(OSError):
        if stat.S_ISDIR(path.lstat().st_mode):
            shutil.rmtree(path, ignore_errors=True)
        else:
            path.unlink()
