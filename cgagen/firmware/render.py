"""Jinja: finds templates, renders them strictly, and turns its errors into sentences."""

import traceback
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import jinja2

from cgagen.errors import CgagenError, TemplateError
from cgagen.files import digest
from cgagen.inputs import TEMPLATE, read_text

PACKAGED = Path(__file__).parent.parent / "_templates"
"""Where a wheel has them."""

CHECKOUT = Path(__file__).parent.parent.parent / "templates"
"""Where a checkout has them."""


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
        folders = [*([own] if own is not None else []), shipped_templates()]
        self._loader = _Recorder(folders)
        self._environment = jinja2.Environment(
            loader=self._loader,
            undefined=jinja2.StrictUndefined,
            autoescape=False,
            trim_blocks=True,
            lstrip_blocks=True,
            keep_trailing_newline=True,
        )

    def render(self, name: str, words: Mapping[str, Any]) -> str:
        """Return a template filled in, without trailing blanks and with single empty lines.

        Raises:
            TemplateError: template and line, what is wrong there, and which words there are; or
                the program is not ASCII.
        """
        try:
            text = self._environment.get_template(name).render(words)
        except jinja2.TemplateSyntaxError as error:
            raise TemplateError(
                f"{self._loader.place(error.name or name)}:{error.lineno}: {_sentence(error)}; "
                "mend the template's Jinja"
            ) from error
        except jinja2.TemplateNotFound as error:
            raise TemplateError(
                f"{self._place_of(error, name)}: wants the template {error.name}, which is neither "
                "in --templates nor among ours; see the folder templates/"
            ) from error
        except CgagenError:
            raise
        except RecursionError as error:
            raise TemplateError(f"{name}: includes itself; break the circle") from error
        except Exception as error:  # a template may raise anything that its expressions raise
            place = self._place_of(error, name)
            known = ", ".join(sorted(words))
            raise TemplateError(
                f"{place}: {_sentence(error)}; the words of {name} are {known}"
            ) from error
        for number, line in enumerate(text.splitlines(), 1):
            if not line.isascii():
                strange = next(character for character in line if not character.isascii())
                raise TemplateError(
                    f"{self._loader.place(name)}: line {number} of the program has {strange!r} in "
                    "it; a Stamp's program is plain ASCII"
                )
        return _tidy(text)

    def used(self) -> tuple[tuple[str, str], ...]:
        """Return (template, SHA-256 of its text) of all that have been rendered, by name."""
        return tuple(sorted(self._loader.digests.items()))

    def _place_of(self, error: BaseException, name: str) -> str:
        """Return template and line where an error came up: the innermost that is one of ours."""
        place = self._loader.place(name)
        for frame in traceback.extract_tb(error.__traceback__):
            if frame.filename in self._loader.paths:
                place = f"{frame.filename}:{frame.lineno}"
        return place


class _Recorder(jinja2.BaseLoader):
    """Loads from the first folder that has a file, and remembers what it has loaded."""

    def __init__(self, folders: list[Path]) -> None:
        self._folders = folders
        self.digests: dict[str, str] = {}
        self.paths: dict[str, str] = {}

    def get_source(
        self, environment: jinja2.Environment, template: str
    ) -> tuple[str, str, Callable[[], bool]]:
        for folder in self._folders:
            path = folder / template
            if path.is_file():
                text = read_text(path, TEMPLATE).replace("\r\n", "\n")
                self.digests[template] = digest(text)
                self.paths[str(path)] = template
                return text, str(path), lambda: True
        raise jinja2.TemplateNotFound(template)

    def place(self, name: str) -> str:
        """Return the path that a template was loaded from, or its name."""
        return next((path for path, known in self.paths.items() if known == name), name)


def _sentence(error: BaseException) -> str:
    words = (str(error) or type(error).__name__).strip().rstrip(".")
    return words.splitlines()[0]


def _tidy(text: str) -> str:
    lines: list[str] = []
    for line in (line.rstrip() for line in text.splitlines()):
        if line or (lines and lines[-1]):
            lines.append(line)
    while lines and not lines[-1]:
        lines.pop()
    return "\n".join(lines) + "\n"
