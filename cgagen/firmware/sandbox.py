"""Templates filled in: from their folders and no others, as data and not as programs.

Jinja's sandbox lets a template at what it was given, and at nothing behind it. Marks in the text
tell which line of which template made each line of a program; they are taken out at the end.
"""

import re
import traceback
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import jinja2
from jinja2 import nodes
from jinja2.exceptions import SecurityError
from jinja2.sandbox import ImmutableSandboxedEnvironment

from cgagen.errors import CgagenError, TemplateError
from cgagen.files import digest
from cgagen.inputs import MIB, TEMPLATE, read_text
from cgagen.shown import short

LONGEST_PROGRAM = MIB
"""Characters; a Stamp holds 2,048 bytes. Choice."""

_MARK = re.compile("\x02(\\d{1,6}):(\\d{1,6})\x03")

_UNMARKED = (nodes.Macro, nodes.AssignBlock, nodes.FilterBlock, nodes.CallBlock)
"""Text inside of these is looked at by expressions before it is put out."""


class Rendered(NamedTuple):
    """A program's text.

    Attributes:
        text: without trailing blanks and with single empty lines.
        origins: file and line of the template for each line of the text; "" and 0 where unknown.
        digests: (template, SHA-256 of its text) of all that were loaded.
    """

    text: str
    origins: list[tuple[str, int]]
    digests: dict[str, str]


def render(folders: list[Path], name: str, words: Mapping[str, Any]) -> Rendered:
    """Return a template filled in.

    Args:
        folders: that have templates; the first that has a name counts.
        name: of the template.
        words: what it is filled with.

    Raises:
        TemplateError: template and line, what is wrong there, and which words there are; or
            the program is not ASCII.
    """
    loader = _Loader(folders)
    environment = _Environment(
        loader=loader,
        undefined=jinja2.StrictUndefined,
        autoescape=False,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    try:
        pieces, length = [], 0
        for piece in environment.get_template(name).generate(words):
            pieces.append(piece)
            length += len(piece)
            if length > 8 * LONGEST_PROGRAM:  # marks among them
                break
    except jinja2.TemplateSyntaxError as error:
        raise TemplateError(
            f"{loader.place(error.name or name)}:{error.lineno}: {_sentence(error)}; "
            "mend the template's Jinja"
        ) from error
    except jinja2.TemplateNotFound as error:
        raise TemplateError(
            f"{_place_of(loader, error, name)}: wants the template {short(str(error.name))}, which "
            "is neither in --templates nor among ours; see the folder templates/"
        ) from error
    except CgagenError:
        raise
    except RecursionError as error:
        raise TemplateError(f"{name}: includes itself; break the circle") from error
    except SecurityError as error:
        raise TemplateError(
            f"{_place_of(loader, error, name)}: {_sentence(error)}; a template may use what it is "
            "given, and nothing behind that"
        ) from error
    except MemoryError as error:
        raise TemplateError(f"{name}: needs too much memory; make less of it") from error
    except Exception as error:  # a template may raise anything that its expressions raise
        raise TemplateError(
            f"{_place_of(loader, error, name)}: {_sentence(error)}; the words of {name} are "
            f"{', '.join(sorted(words))}"
        ) from error
    text, origins = _unmarked("".join(pieces), environment.files)
    _check(text, origins, loader.place(name))
    text, origins = _tidy(text, origins)
    return Rendered(text, origins, loader.digests)


class _Environment(ImmutableSandboxedEnvironment):
    """Marks the text of templates with the places that it comes from."""

    def __init__(self, **given: Any) -> None:
        super().__init__(**given)
        self.files: list[str] = []

    def _parse(self, source: str, name: str | None, filename: str | None) -> nodes.Template:
        tree = super()._parse(source, name, filename)
        self.files.append(filename or name or "")
        self._mark(tree, len(self.files) - 1)
        return tree

    def _mark(self, node: nodes.Node, file: int) -> None:
        for inner in node.iter_child_nodes():
            if isinstance(inner, nodes.Output):
                inner.nodes = [made for one in inner.nodes for made in _marked(one, file)]
            elif not isinstance(inner, _UNMARKED):
                self._mark(inner, file)


def _marked(node: nodes.Expr, file: int) -> list[nodes.Expr]:
    """Return a node of an output with the marks of its lines."""
    line = node.lineno
    if not isinstance(node, nodes.TemplateData):
        return [nodes.TemplateData(f"\x02{file}:{line}\x03", lineno=line), node]
    pieces = node.data.split("\n")
    data = "\n".join(f"\x02{file}:{line + n}\x03{piece}" for n, piece in enumerate(pieces))
    return [nodes.TemplateData(data, lineno=line)]


def _unmarked(text: str, files: list[str]) -> tuple[str, list[tuple[str, int]]]:
    """Return a text without its marks, and for each line where its first character comes from."""
    lines, origins = [], []
    for line in text.split("\n"):
        place = ("", 0)
        for match in _MARK.finditer(line):
            if int(match[1]) >= len(files):
                continue  # a template's own, which may look like a mark of ours
            place = (files[int(match[1])], int(match[2]))
            rest = line[match.end() :]
            if rest and not rest.startswith("\x02"):
                break
        lines.append(_MARK.sub("", line))
        origins.append(place)
    return "\n".join(lines), origins


def _check(text: str, origins: list[tuple[str, int]], place: str) -> None:
    if len(text) > LONGEST_PROGRAM:
        raise TemplateError(
            f"{place}: makes a program of more than {LONGEST_PROGRAM:,} characters; a Stamp holds "
            "2,048 bytes, make less of it"
        )
    for number, line in enumerate(text.split("\n"), 1):
        if not line.isascii():
            strange = next(character for character in line if not character.isascii())
            file, template_line = origins[number - 1]
            raise TemplateError(
                f"{place}: line {number} of the program has {strange!r} in it "
                f"({file}:{template_line}); a Stamp's program is plain ASCII"
            )


class _Loader(jinja2.BaseLoader):
    """Loads from the first folder that has a file, and remembers what it has loaded."""

    def __init__(self, folders: list[Path]) -> None:
        self._folders = folders
        self.digests: dict[str, str] = {}
        self.paths: dict[str, str] = {}

    def get_source(
        self, environment: jinja2.Environment, template: str
    ) -> tuple[str, str, Callable[[], bool]]:
        if not is_inside(template):
            raise TemplateError(
                f"a template wants {short(template)}, which leads out of its folder; put the file "
                "into the folder of --templates, and name it from there"
            )
        for folder in self._folders:
            path = folder / template
            if path.is_symlink() or path.exists():
                if not path.resolve().is_relative_to(folder.resolve()):
                    raise TemplateError(
                        f"{path}: is a link that leads out of the folder; put the file itself there"
                    )
                text = read_text(path, TEMPLATE).replace("\r\n", "\n").replace("\r", "\n")
                self.digests[template] = digest(text)
                self.paths[str(path)] = template
                return text, str(path), lambda: True
        raise jinja2.TemplateNotFound(template)

    def place(self, name: str) -> str:
        """Return the path that a template was loaded from, or its name."""
        return next((path for path, known in self.paths.items() if known == name), name)


def is_inside(name: str) -> bool:
    """Say whether a template's name stays within a folder.

    >>> is_inside("a/b.j2"), is_inside("../b.j2"), is_inside("/etc/passwd"), is_inside("a\\\\b")
    (True, False, False, False)
    """
    parts = name.split("/")
    return not (set(parts) & {"", "..", "."} or set("\\\0") & set(name) or len(name) > 200)


def _place_of(loader: _Loader, error: BaseException, name: str) -> str:
    """Return template and line where an error came up: the innermost that is one of ours."""
    place = loader.place(name)
    for frame in traceback.extract_tb(error.__traceback__):
        if frame.filename in loader.paths:
            place = f"{frame.filename}:{frame.lineno}"
    return place


def _sentence(error: BaseException) -> str:
    words = (str(error) or type(error).__name__).strip().rstrip(".")
    return short(words.splitlines()[0], 300)


def _tidy(text: str, origins: list[tuple[str, int]]) -> tuple[str, list[tuple[str, int]]]:
    lines: list[str] = []
    places: list[tuple[str, int]] = []
    for line, place in zip((one.rstrip() for one in text.split("\n")), origins, strict=True):
        if line or (lines and lines[-1]):
            lines.append(line)
            places.append(place)
    while lines and not lines[-1]:
        lines.pop()
        places.pop()
    return "\n".join(lines) + "\n", places
