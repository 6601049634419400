"""Things by name, and the sentence for a name that is not there."""

import difflib
from typing import TypeVar

from cgagen.errors import BenchError

Found = TypeVar("Found")


def found(known: dict[str, Found], name: str, what: str) -> Found:
    """Return what has a name.

    Raises:
        BenchError: nothing has it; the nearest name, or those that there are.

    >>> found({"main": 1}, "main", "chip")
    1
    """
    if name not in known:
        near = difflib.get_close_matches(name, known, n=1)
        hint = f"did you mean {near[0]}?" if near else f"there are {', '.join(known) or 'none'}"
        raise BenchError(f"{name}: no such {what}; {hint}")
    return known[name]
