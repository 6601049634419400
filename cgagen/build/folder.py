"""A build on the disk: whole, or not there."""

import os
from collections.abc import Mapping
from pathlib import Path

from cgagen.build.record import FILES, RECORD_FILE, read_record
from cgagen.errors import FolderError, StorageError
from cgagen.files import make_folder, write_bytes
from cgagen.temporaries import temporary_folder


def write_build(folder: Path, files: Mapping[str, bytes], force: bool = False) -> None:
    """Write the files of a build as one folder.

    They are written to a temporary folder beside it, which then takes its name; an older build
    in that place is replaced. With `force`, a folder that holds anything else gets the files as
    well: all else in it stays, and `build.json` goes first and comes last.

    Args:
        folder: where to.
        files: content by name.
        force: put the build into a folder that is not a build, or not only one.

    Raises:
        FolderError: there is something else in that place.
        StorageError: the disk is full, read-only or gone; what was there before is there still.
    """
    folder = folder.absolute()
    foreign = _foreign(folder)
    if foreign is not None and not force:
        raise FolderError(
            f"{folder}: is not a build of cgagen alone ({foreign} is in it); choose another folder "
            "with -o, or add --force to put the build in there and keep the rest"
        )
    make_folder(folder.parent)
    try:
        with temporary_folder(folder.resolve().parent) as temporary:
            for name, content in files.items():
                write_bytes(temporary / name, content)
            if foreign is None:
                _exchange(temporary, folder)
            else:
                _fill(temporary, folder, files)
    except OSError as error:
        raise _storage_error(folder, error) from error


def _foreign(folder: Path) -> str | None:
    """Return what keeps a place from being overwritten: a name in it; None for nothing."""
    if not folder.exists() and not folder.is_symlink():
        return None
    if not folder.is_dir():
        raise FolderError(f"{folder}: is a file; choose another folder with -o")
    names = sorted(path.name for path in folder.iterdir())
    if not names:
        return None
    other = next((name for name in names if name not in FILES), None)
    if other is not None:
        return other
    try:
        read_record(folder)
    except FolderError:
        return names[0]
    return None


def _exchange(temporary: Path, folder: Path) -> None:
    """Give the temporary folder its name, and remove what had that name before."""
    if not folder.exists():
        os.rename(temporary, folder)
        return
    target = folder.resolve()
    with temporary_folder(target.parent) as old:
        os.replace(target, old)
        try:
            os.rename(temporary, target)
        except BaseException:
            os.replace(old, target)
            raise


def _fill(temporary: Path, folder: Path, files: Mapping[str, bytes]) -> None:
    """Move the files into a folder that holds other things; without the record it is no build."""
    (folder / RECORD_FILE).unlink(missing_ok=True)
    for name in sorted(files, key=lambda name: name == RECORD_FILE):
        os.replace(temporary / name, folder / name)


def _storage_error(folder: Path, error: OSError) -> StorageError:
    return StorageError(
        f"{folder}: cannot be written ({error.strerror or error}); "
        "free some space or choose another folder with -o"
    )
