"""Projects of several sources: the files that a $STAMP line names, found as Windows finds them.

Parallax's editor runs on Windows, where names of files ignore case and a backslash parts folders.
Ref: S2, $STAMP with files (names with and without quotes).
"""

import re
from collections.abc import Callable
from pathlib import Path

from cgagen.errors import SourceError
from cgagen.inputs import named_alike, others_alike
from cgagen.stamp.compiled import Compiled
from cgagen.tokenizer import Tokenizer
from cgagen.tokenizer.files import read_source

_PARTS = re.compile(r"[\\/]")
_DRIVE = re.compile(r"[A-Za-z]:")


class ProjectSources:
    """Sources of files, compiled one after the other; those that they name are found again.

    Args:
        tokenizer: asked about each.
        note: told of a file that lies outside the folder of the source that names it.
    """

    def __init__(self, tokenizer: Tokenizer, note: Callable[[str], None]) -> None:
        self._tokenizer = tokenizer
        self._note = note
        self._named: dict[Path, tuple[Path, str]] = {}

    def compile(self, path: Path) -> Compiled:
        """Return what a file compiles to.

        Args:
            path: a file; or a name of `project_files` in the folder of a source before it.

        Raises:
            SourceError: it is refused, cannot be read, or is named and not there.
            ToolchainError: as of `Tokenizer.compile`.
        """
        named = self._named.get(path)
        file = path if named is None else self._found(*named)
        compiled = self._tokenizer.compile(read_source(file), str(file))
        if named is None:  # what a further file names in turn has no slot
            self._named |= {path.parent / name: (file, name) for name in compiled.project_files}
        return compiled

    def compile_all(self, path: Path) -> list[Compiled]:
        """Return what a file and those that it names compile to, in the order of their slots.

        Raises:
            SourceError: see `compile`.
        """
        first = self.compile(path)
        return [first, *(self.compile(path.parent / name) for name in first.project_files)]

    def _found(self, source: Path, name: str) -> Path:
        file = found_in(source, name)
        home = source.parent.resolve()
        if not file.resolve().is_relative_to(home):
            self._note(
                f"note: {source}: its $STAMP line names {name}, which is {file.resolve()}, outside "
                "the project's folder"
            )
        twins = [one for one in others_alike(file) if one != file.name]
        if twins:
            self._note(
                f"note: {source}: its $STAMP line names {name}; {file.parent} has "
                f"{' and '.join(twins)}, too, which Windows would take for the same: {file.name} "
                "is read"
            )
        return file


def found_in(source: Path, name: str) -> Path:
    """Return the file that a source names, whatever the case of its letters.

    Args:
        source: whose folder the name starts from.
        name: as its $STAMP line has it.

    Raises:
        SourceError: it is not there, or two differ in case alone and neither is what was written.
    """
    parts = _PARTS.split(name)
    if _DRIVE.match(parts[0]):
        raise SourceError(
            f"{source}: its $STAMP line names {name}, a place of another computer; put the file "
            "beside the source, and name it without a folder"
        )
    place = Path("/") if not parts[0] else source.parent
    for part in filter(None, parts):
        found = named_alike(place, part)
        if len(found) == 1:
            place = place / found[0]
            continue
        if not found:
            raise SourceError(
                f"{source}: its $STAMP line names {name}, and {place} has no {part}; put it there, "
                "or change the line"
            )
        raise SourceError(
            f"{source}: its $STAMP line names {name}, and {place} has {' and '.join(found)}; "
            "write the line as the one that is meant"
        )
    return place
