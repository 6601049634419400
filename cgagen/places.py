"""What stands at the name of an output, and so how it is written.

====================================  ==========================================================
nothing, or a file                    written whole under another name, and renamed
a link                                what it leads to, and the link stays one
`/dev/fd/N`, `/dev/stdout`            what this process was given, as a stream
a character device, a pipe, a socket  opened as it is and written to, as a stream
a folder, a disk, a loop of links     refused
====================================  ==========================================================

Whoever renames a file onto whatever bears a name takes the computer's null device away when the
name is that of it and the user is root; so everything that is written asks here first.
"""

import errno
import os
import re
import socket
import stat
import sys
from dataclasses import dataclass
from pathlib import Path

from cgagen.errors import StorageError
from cgagen.shown import short

_DESCRIPTOR = re.compile(r"(?:/proc/(\d+)(?:/task/\d+)?|/dev)/fd/(\d+)")
"""What a process has open, by number."""

_MOST_LINKS = 40
"""After which a kernel calls it a loop. Ref: path_resolution(7)."""

_NULL_DEVICE = "/dev/null"

_STDOUT, _STDERR = 1, 2
_MOVED: dict[int, int] = {}
"""Where a descriptor of ours has gone to."""

_STREAMS = (stat.S_ISCHR, stat.S_ISFIFO, stat.S_ISSOCK)


@dataclass(frozen=True, slots=True)
class Place:
    """Where an output goes.

    Attributes:
        path: as it was named.
        file: to be written whole, links followed; None for a stream.
        descriptor: the stream is this one of our own; None for others.
        status: of what stands there; None for nothing.
    """

    path: Path
    file: Path | None
    descriptor: int | None
    status: os.stat_result | None

    @property
    def is_stream(self) -> bool:
        """Whether it is written to as it comes."""
        return self.file is None

    @property
    def is_file_already(self) -> bool:
        """Whether a file stands there, with anything in it."""
        return self.file is not None and self.status is not None and self.status.st_size > 0

    @property
    def identity(self) -> tuple[object, ...] | None:
        """What two names of one place have in common; None where many may write to it at once."""
        if self.status is None:
            return ("new", os.path.realpath(self.path))
        if stat.S_ISCHR(self.status.st_mode) and self.status.st_rdev == _null_device():
            return None
        return ("is", self.status.st_dev, self.status.st_ino)


def place_of(path: Path) -> Place:
    """Return where an output of this name goes; nothing is opened for it.

    Raises:
        StorageError: nothing can be written there: a folder, a disk, no folder for it.
    """
    number = descriptor_of(path)
    try:
        status = os.stat(path) if number is None else os.fstat(number)
    except FileNotFoundError:
        return Place(path, _new(path), None, None)
    except (OSError, ValueError) as error:
        if isinstance(error, OSError) and error.errno == errno.EBADF:
            raise StorageError(
                f"{_said(path)}: cannot be written, nothing is open there; name a file"
            ) from error
        raise refused(path, error) from error
    mode = status.st_mode
    if stat.S_ISDIR(mode):
        raise StorageError(f"{_said(path)}: cannot be written, it is a folder; name a file")
    if number is not None or any(kind(mode) for kind in _STREAMS):
        return Place(path, None, number, status)
    if not stat.S_ISREG(mode):
        raise StorageError(f"{_said(path)}: cannot be written, it is a disk; name a file")
    return Place(path, Path(os.path.realpath(path)), None, status)


def descriptor_of(path: Path) -> int | None:
    """Return which of our descriptors a name means, such as /dev/stdout; None for no such name."""
    at = os.path.join(os.getcwd(), path)
    for _ in range(_MOST_LINKS):
        folder, name = os.path.split(at)
        try:
            at = os.path.join(os.path.realpath(folder), name)
            found = _DESCRIPTOR.fullmatch(at)
            if found is not None and found[1] in (None, str(os.getpid())):
                return int(found[2])
            at = os.path.join(os.path.dirname(at), os.readlink(at))
        except (OSError, ValueError):  # no link, or no name at all
            return None
    return None


def open_stream(place: Place) -> int:
    """Open what is written to as it comes; a pipe is waited for until somebody reads it.

    Raises:
        OSError: it cannot be written to.
    """
    if place.descriptor is not None:
        return os.dup(_MOVED.get(place.descriptor, place.descriptor))
    if place.status is not None and stat.S_ISSOCK(place.status.st_mode):
        return _connected(place.path)
    return os.open(place.path, os.O_WRONLY | os.O_NOCTTY | os.O_CLOEXEC)


def move_stdout() -> None:
    """Leave stdout to outputs that name it; whatever else is printed comes on stderr."""
    if _STDOUT not in _MOVED:
        _MOVED[_STDOUT] = os.dup(_STDOUT)
        os.dup2(_STDERR, _STDOUT)


def put_stdout_back() -> None:
    """Undo `move_stdout`."""
    moved = _MOVED.pop(_STDOUT, None)
    if moved is not None:
        sys.stdout.flush()
        os.dup2(moved, _STDOUT)
        os.close(moved)


def refused(path: Path, error: OSError | ValueError) -> StorageError:
    """Return (not raise) what is said where the system refuses an output."""
    if isinstance(error, ValueError):
        return StorageError(f"{_said(path)}: no file can have such a name; choose another")
    if error.errno == errno.ELOOP:
        return StorageError(f"{_said(path)}: is a link that leads to itself; name a file")
    return StorageError(
        f"{_said(path)}: cannot be written ({error.strerror or error}); "
        "free some space or choose another folder"
    )


def _new(path: Path) -> Path:
    """Return where a new file goes: where a link leads to, if there is one that leads nowhere."""
    file = Path(os.path.realpath(path))
    if not file.parent.is_dir():
        raise StorageError(
            f"{_said(path)}: cannot be written, there is no folder {_said(file.parent)}; make it, "
            "or name another"
        )
    return file


def _connected(path: Path) -> int:
    """Return a connection to whoever listens at a socket."""
    for kind in (socket.SOCK_STREAM, socket.SOCK_DGRAM):
        with socket.socket(socket.AF_UNIX, kind) as one:
            try:
                one.connect(str(path))
            except OSError as error:
                if error.errno == errno.EPROTOTYPE and kind is socket.SOCK_STREAM:
                    continue
                raise
            return one.detach()
    raise AssertionError("one of the two has returned or raised")


def _null_device() -> int | None:
    try:
        return os.stat(_NULL_DEVICE).st_rdev
    except OSError:
        return None


def _said(path: Path) -> str:
    return short(str(path), 300)
