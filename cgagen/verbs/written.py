"""What verbs write: named and checked before the work, and stdout left to it where it is asked for.

An output that is a folder, or ends in a slash, goes into that folder under a name of ours.
"""

import os
import sys
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import Any

import click

from cgagen.files import make_folder
from cgagen.outputs import Kind, check_outputs
from cgagen.places import move_stdout, put_stdout_back

STDOUT = 1

FOLDERS = f"{__name__}.folders"
"""Where a call keeps the names that ended in a slash."""


class OutputType(click.Path):
    """An output: a file, or a folder that it goes into. See `in_folder`."""

    def __init__(self) -> None:
        super().__init__(path_type=Path)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the path, and remember whether it was said to be a folder's."""
        path = super().convert(value, param, ctx)
        if ctx is not None and str(value).endswith(os.sep):
            ctx.meta.setdefault(FOLDERS, set()).add(path)
        return path


OUTPUT = OutputType()


def in_folder(path: Path, name: str) -> Path:
    """Return where an output goes.

    Args:
        path: a file, or a folder that is there or whose name ended in a slash.
        name: of the file in the folder.

    Raises:
        StorageError: the folder cannot be made.
    """
    return path / name if folder_at(path) else path


def folder_at(path: Path) -> bool:
    """Say whether an output is a folder; one that is not there is made.

    A folder that was made for nothing, because the verb has come to nothing, goes again.

    Raises:
        StorageError: it cannot be made.
    """
    context = click.get_current_context()
    if path not in context.meta.get(FOLDERS, ()):
        return os.path.isdir(path)
    new = [one for one in (path, *path.parents) if not os.path.lexists(one)]
    make_folder(path)
    context.call_on_close(lambda: _remove_empty(new))
    return True


def _remove_empty(folders: Iterable[Path]) -> None:
    with suppress(OSError):
        for folder in folders:
            folder.rmdir()


def check(
    outputs: Iterable[tuple[Path, Kind]], inputs: Iterable[Path] = (), force: bool = False
) -> None:
    """Refuse outputs as `check_outputs` does; and where one is stdout, keep all else from it.

    What the verb prints then comes on stderr, so that `-o /dev/stdout` gives a whole file.

    Raises:
        CgagenError: see `check_outputs`.
    """
    places = check_outputs(outputs, inputs, force)
    if any(place.descriptor == STDOUT for place in places):
        sys.stdout.flush()
        move_stdout()
        click.get_current_context().call_on_close(put_stdout_back)
