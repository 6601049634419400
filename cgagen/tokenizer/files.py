"""Sources read and images written: the files around the tokenizer."""

from contextlib import suppress
from pathlib import Path

from cgagen.errors import ImageError, SourceError
from cgagen.files import write_bytes, write_text
from cgagen.inputs import SOURCE, read_bytes
from cgagen.outputs import Kind, begins
from cgagen.shown import short
from cgagen.stamp.chips import CHIPS, EEPROM_BYTES
from cgagen.stamp.compiled import Compiled
from cgagen.stamp.decode import decode
from cgagen.stamp.image import Image

_FEW_BYTES = 8
"""Of so few, zeros say nothing about how a text is written. Ref: choice."""

MAP_TITLE = "line,column,bit"
"""First line of a source map."""


def read_source(path: Path) -> str:
    """Return the text of a PBASIC file, line ends as they are.

    Files of Parallax's editor are Windows-1252; files of today's editors are UTF-8.

    Raises:
        SourceError: it cannot be read, or is UTF-16.
    """
    content = read_bytes(path, SOURCE)
    if _is_utf16(content):
        raise SourceError(
            f"{short(str(path), 300)}: is text of 16 bits a character (UTF-16); save it as ASCII "
            "or UTF-8"
        )
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("cp1252", "replace")


def _is_utf16(content: bytes) -> bool:
    """Whether a text has the mark of UTF-16, or nearly every other of its bytes is 0."""
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        return True
    zeros = sorted(content[first::2].count(0) for first in (0, 1))
    return len(content) >= _FEW_BYTES and zeros[0] == 0 and zeros[1] > len(content) // 4


def write_image(path: Path, image: Image) -> None:
    """Write the EEPROM bytes of an image.

    Raises:
        StorageError: it cannot be written.
    """
    write_bytes(path, image.eeprom)


def write_map(path: Path, compiled: Compiled) -> None:
    """Write a source map: a statement a line, in the order of the source.

    Raises:
        StorageError: it cannot be written.
    """
    rows = [f"{s.line},{s.column},{s.bit}" for s in compiled.source_map.statements]
    write_text(path, "\n".join([MAP_TITLE, *rows]) + "\n")


def _is_image(head: bytes) -> bool:
    """Whether bytes are a program of one of the five models, to the end of its last routine."""
    if len(head) != EEPROM_BYTES:
        return False
    for model in CHIPS:
        with suppress(ImageError):
            decode(head, model)
            return True
    return False


IMAGE = Kind("an image", _is_image)
SOURCE_MAP = begins("a source map", MAP_TITLE + "\n")
