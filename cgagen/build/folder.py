"""A build on the disk: whole, or not there."""

import ctypes
import os
import stat
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import NamedTuple

from cgagen.build.record import FILES, RECORD_FILE, read_record
from cgagen.errors import FolderError, StorageError
from cgagen.files import digest, make_folder, write_bytes
from cgagen.inputs import BUILD_FILE, start_of
from cgagen.temporaries import is_temporary, temporary_folder

_AT_CWD, _EXCHANGE = -100, 2
"""AT_FDCWD and RENAME_EXCHANGE. Ref: renameat2(2)."""


class Standing(NamedTuple):
    """What stands in the place of a build.

    Attributes:
        foreign: a name that keeps it from being a build alone; None for nothing.
        edited: files of the build that are not as they were built.
        links: some of its files are links.
    """

    foreign: str | None = None
    edited: tuple[str, ...] = ()
    links: bool = False


def write_build(folder: Path, files: Mapping[str, bytes], force: bool = False) -> None:
    """Write the files of a build as one folder.

    They are written to a temporary folder beside it, which then takes its name; an older build
    in that place is replaced. With `force`, a folder that holds anything else gets the files as
    well: all else in it stays, and `build.json` goes first and comes last.

    Args:
        folder: where to.
        files: content by name.
        force: put the build into a folder that is not a build, or not only one, or was edited.

    Raises:
        FolderError: there is something else in that place.
        StorageError: the disk is full, read-only or gone; what was there before is there still.
    """
    folder = folder.absolute()
    there = check_build_folder(folder, force, files)
    make_folder(folder.parent)
    try:
        with temporary_folder(folder.resolve().parent) as temporary:
            for name, content in files.items():
                write_bytes(temporary / name, content)
            if there.foreign is not None or there.links:
                _fill(temporary, folder, files)
            else:
                _exchange(temporary, folder)
    except OSError as error:
        raise _storage_error(folder, error) from error


def check_build_folder(
    folder: Path,
    force: bool = False,
    files: Mapping[str, bytes] | None = None,
    inputs: Iterable[Path] = (),
) -> Standing:
    """Refuse a place where a build would cost something of the user's; before the work, too.

    Args:
        folder: where to.
        force: see `write_build`.
        files: what will be written, where that is known: what says the same may stand there.
        inputs: what the build is made of; an edit of those goes into it.

    Raises:
        FolderError: there is something else in that place.
    """
    there = _standing(folder, files or {}, [one for one in inputs if one.exists()])
    if force:
        return there
    if there.foreign is not None:
        lost = f" (but for changes in {', '.join(there.edited)})" if there.edited else ""
        raise FolderError(
            f"{folder}: is not a build of cgagen alone ({there.foreign} is in it); choose another "
            f"folder with -o, or add --force to put the build in there and keep the rest{lost}"
        )
    if there.edited:
        raise FolderError(
            f"{folder}: {', '.join(there.edited)}: changed since cgagen has built this; choose "
            "another folder with -o, or add --force to lose the changes"
        )
    return there


def _standing(folder: Path, files: Mapping[str, bytes], inputs: list[Path]) -> Standing:
    """Look at what is in a folder."""
    if not folder.exists() and not folder.is_symlink():
        return Standing()
    if not folder.is_dir():
        raise FolderError(f"{folder}: is a file; choose another folder with -o")
    names = sorted(path.name for path in folder.iterdir() if not is_temporary(path.name))
    ours = [name for name in names if name in FILES]
    for name in ours:
        if not (folder / name).is_file():
            raise FolderError(
                f"{folder / name}: is no file, and a build has one of that name; move it away, or "
                "choose another folder with -o"
            )
    links = any(stat.S_ISLNK((folder / name).lstat().st_mode) for name in ours)
    other = next((name for name in names if name not in FILES), None)
    if other is not None or not names:
        return Standing(other, _edited(folder, ours, files, inputs), links)
    if not _is_build(folder):
        return Standing(names[0], (), links)
    return Standing(None, _edited(folder, ours, files, inputs), links)


def _is_build(folder: Path) -> bool:
    try:
        read_record(folder)
    except FolderError:
        return False
    return True


def _edited(
    folder: Path, names: Iterable[str], files: Mapping[str, bytes], inputs: list[Path]
) -> tuple[str, ...]:
    """Return which files are neither as they were built nor as they will be."""
    known = read_record(folder).get("files", {}) if _is_build(folder) else {}
    edited = []
    for name in names:
        path = folder / name
        if name == RECORD_FILE or any(path.samefile(one) for one in inputs):
            continue
        content = start_of(path, BUILD_FILE.most)
        if content is None or (digest(content) != known.get(name) and content != files.get(name)):
            edited.append(name)
    return tuple(edited)


def _exchange(temporary: Path, folder: Path) -> None:
    """Give the temporary folder its name; what had that name before is the temporary one then."""
    if not folder.exists():
        os.rename(temporary, folder)
        return
    target = folder.resolve()
    temporary.chmod(stat.S_IMODE(target.stat().st_mode))
    if _exchanged(temporary, target):
        return
    with temporary_folder(target.parent) as old:
        os.replace(target, old)
        try:
            os.rename(temporary, target)
        except BaseException:
            os.replace(old, target)
            raise


def _exchanged(one: Path, other: Path) -> bool:
    """Exchange two names at once; False where the system, or the disk, cannot."""
    rename = getattr(ctypes.CDLL(None), "renameat2", None)
    if rename is None:
        return False
    done: int = rename(_AT_CWD, os.fsencode(one), _AT_CWD, os.fsencode(other), _EXCHANGE)
    return done == 0


def _fill(temporary: Path, folder: Path, files: Mapping[str, bytes]) -> None:
    """Move the files into a folder that holds other things; without the record it is no build.

    A link stays one, and what it leads to gets the content.
    """
    (folder / RECORD_FILE).unlink(missing_ok=True)
    for name in sorted(files, key=lambda name: name == RECORD_FILE):
        if (folder / name).is_symlink():
            write_bytes(folder / name, files[name])
        else:
            os.replace(temporary / name, folder / name)


def _storage_error(folder: Path, error: OSError) -> StorageError:
    return StorageError(
        f"{folder}: cannot be written ({error.strerror or error}); "
        "free some space or choose another folder with -o"
    )
