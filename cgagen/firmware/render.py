"""Finds templates, has them filled in, and tells what a user's folder does and does not replace."""

from collections.abc import Mapping
from itertools import islice
from pathlib import Path
from typing import Any

from cgagen.errors import TemplateError
from cgagen.firmware.confined import render_confined
from cgagen.firmware.sandbox import Rendered, render
from cgagen.near import did_you_mean
from cgagen.shown import short

PACKAGED = Path(__file__).parent.parent / "_templates"
"""Where a wheel has them."""

CHECKOUT = Path(__file__).parent.parent.parent / "templates"
"""Where a checkout has them."""


MOST_FILES = 1_000
"""Of a user's folder that are looked at for their names. Choice."""

MOST_NOTES = 10
"""On files of a user's folder that nothing asks for. Choice."""


def shipped_templates() -> Path:
    """Return the folder of the templates that come with cgagen.

    Raises:
        TemplateError: this installation has none.
    """
    for folder in (PACKAGED, CHECKOUT):
        if folder.is_dir():
            return folder
    raise TemplateError(
        f"{PACKAGED}: the templates are missing from this installation; install cgagen again"
    )


class Renderer:
    """The templates of one build.

    Args:
        own: a user's folder, whose files come before ours of the same name; None for ours alone.

    Raises:
        TemplateError: `own` is no folder, or ours are missing.
    """

    def __init__(self, own: Path | None = None) -> None:
        if own is not None and not own.is_dir():
            raise TemplateError(f"{own}: no such folder; --templates wants one with *.j2 files")
        self._own = own
        self._folders = [*([own] if own is not None else []), shipped_templates()]
        self._digests: dict[str, str] = {}

    def render(self, name: str, words: Mapping[str, Any]) -> Rendered:
        """Return a template filled in, without trailing blanks and with single empty lines.

        Raises:
            TemplateError: template and line, what is wrong there, and which words there are; or
                the program is not ASCII, or has no end.
        """
        fill = render if self._own is None else render_confined
        made = fill(self._folders, name, words)
        self._digests |= made.digests
        return made

    def used(self) -> tuple[tuple[str, str], ...]:
        """Return (template, SHA-256 of its text) of all that have been rendered, by name."""
        return tuple(sorted(self._digests.items()))

    def notes(self) -> tuple[str, ...]:
        """Return what a user should know of the own folder: files that nothing asked for."""
        if self._own is None:
            return ()
        ours = {path.name for path in shipped_templates().glob("*.j2")}
        found = islice(self._own.rglob("*"), MOST_FILES)
        files = sorted(path for path in found if path.is_file())
        names = {str(path.relative_to(self._own)): path for path in files}
        known = ", ".join(sorted(ours))
        notes = [
            f"{short(str(path), 300)}: no template of that name is used"
            f"{did_you_mean(name, ours)}; there are {known}"
            for name, path in names.items()
            if name not in self._digests and name not in ours
        ]
        if len(notes) > MOST_NOTES:
            notes[MOST_NOTES:] = [f"{self._own}: {len(notes) - MOST_NOTES} more files likewise"]
        if not names.keys() & self._digests.keys():
            notes.append(f"{self._own}: replaces no template of this robot's; there are {known}")
        return tuple(notes)
