"""Numbers put into the text of a TOML file, with all its comments left where they are."""

import re

from cgagen.errors import MeasurementError

COMMENT_COLUMN = 27
"""Where comments stand in the robot files."""


def with_value(text: str, file: str, table: str, key: str, value: str, mark: str) -> str:
    r"""Return a TOML text with another value for one key, and another comment behind it.

    Args:
        text: the whole file.
        file: what messages call it.
        table: such as `movement.FORWARD`, or `light.sensor.left` for the [[light.sensor]] whose
            `name` is "left".
        key: one that the table has, on a line of its own; a named table is given one that it lacks.
        value: as TOML has it.
        mark: the comment.

    Raises:
        MeasurementError: the table or the key is not written in lines of its own.

    >>> text = "[a]\nx = [\n 1, # one\n]\ny = 2\n"
    >>> print(with_value(text, "f", "a", "x", "3", "why"), end="")
    [a]
    x = 3                      # why
    y = 2
    """
    lines = text.splitlines()
    if _find(lines, table, key) is None and _find(lines, table, "name") is not None:
        named = _line_of(lines, file, table, "name")
        lines.insert(named + 1, f"{key} = 0")
    first = _line_of(lines, file, table, key)
    last = _last_line(lines, first)
    lines[first : last + 1] = [f"{f'{key} = {value}':<{COMMENT_COLUMN - 1}} # {mark}"]
    return "\n".join(lines) + "\n"


def _line_of(lines: list[str], file: str, table: str, key: str) -> int:
    found = _find(lines, table, key)
    if found is not None:
        return found
    raise MeasurementError(
        f"{file}: [{table}] {key}: not on a line of its own under its table, so it cannot be "
        "changed; write the table as the files that ship do"
    )


def _find(lines: list[str], table: str, key: str) -> int | None:
    """Return the line of a key; tables of an array are called by their array and their name."""
    here, array = "", 0
    for number, line in enumerate(lines):
        header = re.match(r"\s*\[(\[?)\s*([^\[\]]+?)\s*\]\]?\s*(#.*)?$", line)
        if header:
            here, array = header[2], number if header[1] else 0
            if array:
                here += "." + _name_behind(lines, number)
        elif here == table and re.match(rf"\s*{re.escape(key)}\s*=", line):
            return number
    return None


def _name_behind(lines: list[str], header: int) -> str:
    """Return the `name` of the table of an array that begins at a line; "" for none."""
    for line in lines[header + 1 :]:
        if re.match(r"\s*\[", line) and "=" not in line:
            return ""
        name = re.match(r"""\s*name\s*=\s*["']([^"']*)["']""", line)
        if name:
            return name[1]
    return ""


def _last_line(lines: list[str], first: int) -> int:
    """Return the line in which a value ends: where all its brackets are closed."""
    depth = 0
    for number in range(first, len(lines)):
        bare = re.sub(r'"[^"]*"|\'[^\']*\'', "", lines[number]).partition("#")[0]
        depth += bare.count("[") - bare.count("]")
        if depth <= 0:
            return number
    return len(lines) - 1
