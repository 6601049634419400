"""Files written whole or not at all, and the digests that name their content.

Every output of every verb is written by one of these functions, and every one of them asks
`cgagen.places` first what stands at the name that it was given.
"""

import hashlib
import io
import os
import select
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any, BinaryIO, TextIO

from cgagen.errors import StorageError
from cgagen.places import Place, open_stream, place_of, refused
from cgagen.temporaries import temporary_file

_ANSWERS = 0o777
"""Of a file's mode, what a new file in its place keeps."""


def write_bytes(path: Path, data: bytes) -> None:
    """Write a file so that a reader, or a crash, sees the old content or the new one.

    The bytes go to a temporary name in the same folder, are flushed to the disk, and take the
    final name in one step. A stream gets them as they are.

    Raises:
        StorageError: nothing can be written there, or the disk is full, read-only or gone;
            `path` is as it was.
        BrokenPipeError: who read the stream has gone.
    """
    with _written(path) as file:
        file.write(data)


def write_text(path: Path, text: str) -> None:
    """Write text as UTF-8 with line feeds, whole or not at all.

    Raises:
        CgagenError: see `write_bytes`.
    """
    write_bytes(path, text.encode())


@contextmanager
def text_stream(path: Path) -> Iterator[TextIO]:
    """Write text of any length; a file takes its name when the block ends.

    It does so where the block ends in an error, too: what led to the error is what one wants to
    read then. Not so where a signal has torn the block apart: it may have been amid a line.

    Raises:
        CgagenError: see `write_bytes`.
    """
    with _written(path, in_any_case=True) as file:
        text = io.TextIOWrapper(file, encoding="utf-8", newline="\n")
        try:
            yield text
        finally:
            text.detach()


@contextmanager
def live_file(path: Path) -> Iterator[BinaryIO]:
    """Write a file that others may read meanwhile, and that is whole up to its last byte.

    Raises:
        CgagenError: see `write_bytes`.
    """
    place = place_of(path)
    try:
        if place.file is None:
            handle = open_stream(place)
        else:
            flags = os.O_WRONLY | os.O_CREAT | os.O_CLOEXEC | os.O_TRUNC
            handle = os.open(place.file, flags, 0o666)
    except OSError as error:
        raise refused(path, error) from error
    with _Written(handle, path) as file:
        yield file


class _Written(io.FileIO):
    """A file whose refusals to be written are sentences."""

    def __init__(self, handle: int, path: Path, closefd: bool = True) -> None:
        super().__init__(handle, "wb", closefd=closefd)
        self._path = path

    def write(self, data: Any) -> int:
        """Write all of the data.

        Raises:
            StorageError: the disk refuses.
            BrokenPipeError: who read it has gone.
        """
        left = memoryview(data).cast("B")
        try:
            while left:
                count = super().write(left)
                if count is None:  # somebody has made it not wait
                    select.select([], [self.fileno()], [])
                left = left[count or 0 :]
        except BrokenPipeError:
            raise
        except OSError as error:
            raise refused(self._path, error) from error
        return len(data)


@contextmanager
def _written(path: Path, in_any_case: bool = False) -> Iterator[BinaryIO]:
    """Give what an output is written to."""
    place = place_of(path)
    if place.file is None:
        try:
            handle = open_stream(place)
        except OSError as error:
            raise refused(path, error) from error
        with io.BufferedWriter(_Written(handle, path)) as stream:
            yield stream
        return
    if place.status is not None and not os.access(place.file, os.W_OK):
        raise StorageError(f"{path}: is write-protected; name another, or change its mode")
    with ExitStack() as stack:
        try:
            temporary, handle = stack.enter_context(temporary_file(place.file.parent))
        except OSError as error:
            raise refused(path, error) from error
        file = stack.enter_context(io.BufferedWriter(_Written(handle, path, closefd=False)))
        try:
            yield file
        except Exception:
            if in_any_case:
                _take_over(file, temporary, place)
            raise
        _take_over(file, temporary, place)


def _take_over(file: BinaryIO, temporary: Path, place: Place) -> None:
    """Give a temporary file its name, with mode and owner of what had that name before."""
    file.flush()
    handle = file.fileno()
    try:
        os.fsync(handle)
        if place.status is not None:
            before, now = place.status, os.fstat(handle)
            with suppress(OSError):  # not every disk has owners and modes
                if (before.st_uid, before.st_gid) != (now.st_uid, now.st_gid):
                    os.fchown(handle, before.st_uid, before.st_gid)
            with suppress(OSError):
                os.fchmod(handle, before.st_mode & _ANSWERS)
        os.replace(temporary, place.file or place.path)
    except OSError as error:
        raise refused(place.path, error) from error


def make_folder(path: Path) -> None:
    """Create a folder and its parents; an existing one is fine.

    Raises:
        StorageError: it cannot be created, or a file stands in its place.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise StorageError(
            f"{path}: the folder cannot be made ({error.strerror or error}); choose another"
        ) from error


def digest(data: bytes | str) -> str:
    """Return the SHA-256 of bytes, or of a text's UTF-8, as 64 hexadecimal digits.

    >>> digest("")[:8]
    'e3b0c442'
    """
    return hashlib.sha256(data.encode() if isinstance(data, str) else data).hexdigest()
