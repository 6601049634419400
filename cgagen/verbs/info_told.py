"""How `cgagen info` reads a file, and what it says of one."""

import csv
from pathlib import Path
from typing import Any, NamedTuple

from cgagen.errors import StrangerError
from cgagen.inputs import decoded, read_bytes
from cgagen.notations import parse_json
from cgagen.verbs.info_sorts import ANY


class Told(NamedTuple):
    """What is said of a file: lines, and data without `kind`."""

    lines: list[str]
    data: dict[str, Any]


def text_of(path: Path) -> str:
    """Return the text of a file of ours.

    Raises:
        StrangerError: it is none, or too large.
    """
    return decoded(read_bytes(path, ANY), path, ANY)


def object_in(path: Path) -> dict[str, Any]:
    """Return the object that a JSON file holds."""
    data = parse_json(text_of(path))
    if not isinstance(data, dict):
        raise TypeError("no object")
    return data


def rows_of(path: Path, width: int | None) -> list[list[str]]:
    """Return the rows of a table below its head; one at least."""
    rows = [row for row in csv.reader(text_of(path).splitlines()) if row and row[0][:1] != "#"][1:]
    for row in rows:
        if width is not None and len(row) != width:
            raise ValueError(f"a row has {len(row)} values, and not {width}")
    if not rows:
        raise StrangerError(f"{path}: is a table without rows")
    return rows
