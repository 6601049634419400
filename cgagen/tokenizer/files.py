"""Sources read and images written: the files around the tokenizer."""

from pathlib import Path

from cgagen.errors import FolderError
from cgagen.files import write_bytes, write_text
from cgagen.inputs import SOURCE, read_bytes
from cgagen.stamp.chips import EEPROM_BYTES
from cgagen.stamp.compiled import Compiled
from cgagen.stamp.image import Image

MAP_TITLE = "line,column,bit"
"""First line of a source map; what starts with it may be overwritten by the next one."""


def read_source(path: Path) -> str:
    """Return the text of a PBASIC file, line ends as they are.

    Files of Parallax's editor are Windows-1252; files of today's editors are UTF-8.

    Raises:
        SourceError: it cannot be read, or is no text.
    """
    content = read_bytes(path, SOURCE)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("cp1252", "replace")


def write_image(path: Path, image: Image, force: bool = False) -> None:
    """Write the EEPROM bytes of an image, over an older image too.

    Raises:
        FolderError: what is there has another size, so it is no image, and `force` is off.
        StorageError: it cannot be written.
    """
    if not force and path.exists() and not (path.is_file() and _size(path) == EEPROM_BYTES):
        raise FolderError(
            f"{path}: is there and is not an image of {EEPROM_BYTES:,} bytes; "
            "choose another name, or overwrite it with --force"
        )
    write_bytes(path, image.eeprom)


def write_map(path: Path, compiled: Compiled, force: bool = False) -> None:
    """Write a source map: a statement a line, in the order of the source.

    Raises:
        FolderError: what is there is no source map, and `force` is off.
        StorageError: it cannot be written.
    """
    if not force and path.exists() and not _starts_with_title(path):
        raise FolderError(
            f"{path}: is there and is not a source map; "
            "choose another name, or overwrite it with --force"
        )
    rows = [f"{s.line},{s.column},{s.bit}" for s in compiled.source_map.statements]
    write_text(path, "\n".join([MAP_TITLE, *rows]) + "\n")


def _size(path: Path) -> int:
    return path.stat().st_size


def _starts_with_title(path: Path) -> bool:
    try:
        with path.open("rb") as file:
            return file.read(len(MAP_TITLE)) == MAP_TITLE.encode()
    except OSError:
        return False
