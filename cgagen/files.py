"""Files written whole or not at all, and the digests that name their content."""

import errno
import hashlib
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TextIO

from cgagen.errors import StorageError


def write_bytes(path: Path, data: bytes) -> None:
    """Write a file so that a reader, or a crash, sees the old content or the new one.

    The bytes go to a temporary name in the same folder, are flushed to the disk, and take the
    final name in one step.

    Raises:
        StorageError: the disk is full, read-only or gone; `path` is as it was.
    """
    temporary: str | None = None
    try:
        handle, temporary = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
        with os.fdopen(handle, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.chmod(temporary, 0o644)
        os.replace(temporary, path)
        temporary = None
    except OSError as error:
        raise _refused(path, error) from error
    finally:
        if temporary is not None:
            Path(temporary).unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Write text as UTF-8 with line feeds, whole or not at all.

    Raises:
        StorageError: see `write_bytes`.
    """
    write_bytes(path, text.encode())


@contextmanager
def text_stream(path: Path) -> Iterator[TextIO]:
    """Write text of any length; the file takes its name when the block ends.

    It does so where the block ends in an error, too: what led to the error is what one wants to
    read then.

    Raises:
        StorageError: the disk is full, read-only or gone.
    """
    try:
        handle, temporary = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
    except OSError as error:
        raise _refused(path, error) from error
    try:
        with os.fdopen(handle, "w", encoding="utf-8", newline="\n") as file:
            try:
                yield file
            finally:
                file.flush()
                os.fsync(file.fileno())
                os.chmod(temporary, 0o644)
                os.replace(temporary, path)
    except OSError as error:
        # Other errors of the block, such as a reader that has gone, are none of the disk's.
        if error.errno not in _OF_THE_DISK:
            raise
        raise _refused(path, error) from error
    finally:
        Path(temporary).unlink(missing_ok=True)


_OF_THE_DISK = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EROFS, errno.EISDIR}


def _refused(path: Path, error: OSError) -> StorageError:
    return StorageError(
        f"{path}: cannot be written ({error.strerror or error}); "
        "free some space or choose another folder"
    )


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
