"""Lines of PBASIC in columns: declarations, DATA rows, and the words in their comments."""

from collections.abc import Iterable

_NAME = 16
_WORD = 8
_VALUE = 24


def declare(name: str, word: str, value: object, comment: str = "") -> str:
    """Return `name CON value ' comment` in columns.

    >>> declare("Baud", "CON", 84, "9600 8N1")
    "Baud            CON     84                      ' 9600 8N1"
    """
    line = f"{name:<{_NAME}}{word:<{_WORD}}{value!s:<{_VALUE}}"
    return f"{line}' {comment}" if comment else line.rstrip()


def con(name: str, value: object, comment: str = "") -> str:
    """Return the declaration of a constant."""
    return declare(name, "CON", value, comment)


def data(label: str, values: Iterable[object], width: int, comment: str = "") -> str:
    """Return one row of DATA, each value with its comma in a column.

    >>> data("Genes", (1, 7), 4, "no_object")
    "Genes           DATA    1,  7   ' no_object"
    """
    items = [str(value) for value in values]
    cells = [f"{item + ',':<{width}}" for item in items[:-1]] + [f"{items[-1]:<{width}}"]
    line = f"{label:<{_NAME}}{'DATA':<{_WORD}}{''.join(cells)}"
    return f"{line}' {comment}" if comment else line.rstrip()


def camel(name: str) -> str:
    """Return `front_left` as `FrontLeft`."""
    return "".join(part.capitalize() for part in name.split("_"))
