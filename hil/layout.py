"""Where the programs that are judged keep their variables, and where their labels stand."""

import re

from cgagen.stamp.layout import Place, layout_of

__all__ = ["Place", "layout_of", "line_of_label"]


def line_of_label(source: str, label: str) -> int | None:
    """Return the line, from 1, on which a label stands; None where it is missing."""
    found = re.search(rf"^{label}:", source, re.M | re.I)
    return source.count("\n", 0, found.start()) + 1 if found else None
