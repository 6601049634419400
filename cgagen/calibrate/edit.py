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
        table: such as `movement.FORWARD`.
        key: one that the table has, on a line of its own.
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
    first = _line_of(lines, file, table, key)
    last = _last_line(lines, first)
    lines[first : last + 1] = [f"{f'{key} = {value}':<{COMMENT_COLUMN - 1}} # {mark}"]
    return "\n".join(lines) + "\n"


def _line_of(lines: list[str], file: str, table: str, key: str) -> int:
    here = ""
    for number, line in enumerate(lines):
        header = re.match(r"\s*\[\s*([^\[\]]+?)\s*\]\s*(#.*)?$", line)
        if header or re.match(r"\s*\[\[", line):
            here = header[1] if header else ""
        elif here == table and re.match(rf"\s*{re.escape(key)}\s*=", line):
            return number
    raise MeasurementError(
        f"{file}: [{table}] {key}: not on a line of its own under its table, so it cannot be "
        "changed; write the table as the files that ship do"
    )


def _last_line(lines: list[str], first: int) -> int:
    """Return the line in which a value ends: where all its brackets are closed."""
    depth = 0
    for number in range(first, len(lines)):
        bare = re.sub(r'"[^"]*"|\'[^\']*\'', "", lines[number]).partition("#")[0]
        depth += bare.count("[") - bare.count("]")
        if depth <= 0:
            return number
    return len(lines) - 1
