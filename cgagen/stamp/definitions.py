"""Definitions of a source: VAR, CON, PIN and DATA, in its order."""

import re
from collections.abc import Iterator
from typing import NamedTuple

from cgagen.stamp.constants import CONTROL, NotUnderstoodError, value_at, words_of

_STATEMENT = re.compile(r"(?:\"[^\"\r\n]*\"?|[^\"\r\n:])+|\r\n|[\r\n:]")
_DEFINITION = re.compile(
    r"[ \t]*(?:([A-Za-z_]\w*)[ \t]+)?(VAR|CON|PIN|DATA)\b[ \t]*([\s\S]*?)[ \t]*", re.IGNORECASE
)


class Definition(NamedTuple):
    """One definition.

    Attributes:
        name: as it is written; "" for a DATA without one.
        kind: VAR, CON, PIN or DATA.
        rest: what stands behind that word.
        line: from 1.
    """

    name: str
    kind: str
    rest: str
    line: int


def definitions_of(code: str) -> Iterator[Definition]:
    r"""Return the definitions of a text without comments (`cgagen.stamp.conditional`).

    >>> [one.name for one in definitions_of("a VAR Byte: b CON 3\nHIGH b\nt DATA 1,\n 2\n")]
    ['a', 'b', 't']
    """
    line, began, waiting = 1, 1, ""
    for found in _STATEMENT.finditer(code):
        text = found[0]
        if text in ("\n", "\r", "\r\n"):
            line += 1
            # A list goes on behind a comma at the end of its line.
            if waiting and not waiting.rstrip().endswith(","):
                yield from _definition(waiting, began)
                waiting = ""
        elif text == ":":
            yield from _definition(waiting, began)
            waiting = ""
        else:
            began = began if waiting.strip() else line
            waiting += text
    if waiting:
        yield from _definition(waiting, began)


def constants_of(definitions: list[Definition]) -> dict[str, int]:
    """Return the values of CON and PIN by name in capitals, as far as they are understood.

    A constant may name one that is defined below. DATA labels are not in it.
    """
    known = dict(CONTROL)
    open_ones = {one.name.upper(): one.rest for one in definitions if one.kind in ("CON", "PIN")}
    while open_ones:
        found = {}
        for name, rest in open_ones.items():
            try:
                words = words_of(rest)
                value, end = value_at(words, 0, known)
            except NotUnderstoodError:
                continue
            if end == len(words):
                found[name] = value
        if not found:
            break
        known |= found
        open_ones = {name: rest for name, rest in open_ones.items() if name not in found}
    return known


def _definition(text: str, line: int) -> Iterator[Definition]:
    found = _DEFINITION.fullmatch(text)
    if found is not None and (found[1] or found[2].upper() == "DATA"):
        yield Definition(found[1] or "", found[2].upper(), found[3], line)
