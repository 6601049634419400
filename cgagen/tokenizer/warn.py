"""What the tokenizer takes without a word, and the one who wrote it should know."""

import re

from cgagen.stamp.compiled import Compiled, SourceWarning
from cgagen.stamp.constants import NotUnderstoodError
from cgagen.stamp.layout import layout_of, place_in
from cgagen.stamp.scan import blanked, lines_of, pieces_of
from cgagen.stamp.wording import variable
from cgagen.tokenizer.text import Lines, parts_of

_STRING = re.compile(r"\b((?:WAIT)?STR)\s+(?:\?\s*)?(\w+)\s*(?![\w\s(=])", re.IGNORECASE)

_NAMED = {"\f": "a form feed", "\x1a": "Ctrl-Z"}

_LATER = re.compile(r"\{[ \t]*\$(?:STAMP|PBASIC|PORT)\b", re.IGNORECASE)


def warnings_of(
    compiled: Compiled, source: str, strays: tuple[int, ...]
) -> tuple[SourceWarning, ...]:
    """Return the warnings of a source, in its order.

    Args:
        compiled: what came of it.
        source: as it was given.
        strays: places of control characters in its code (`Sent.strays`).
    """
    found = [*_stray(source, strays), *_unseen_directives(source), *_word_strings(compiled)]
    return tuple(sorted(found))


def _stray(source: str, strays: tuple[int, ...]) -> list[SourceWarning]:
    """Return a warning for the first of each kind of control characters.

    The tokenizer ends a line at each, which makes no difference there. Ref: S3, by compiling.
    """
    lines, first = Lines(source), {source[offset]: offset for offset in reversed(strays)}
    return [
        SourceWarning(
            *lines.place(offset),
            f"{_NAMED.get(char, f'the control character {ord(char)}')} is taken for a blank; "
            "leave it out",
        )
        for char, offset in first.items()
    ]


def _unseen_directives(source: str) -> list[SourceWarning]:
    """Return a warning for each directive that stands behind another one in its comment.

    The tokenizer reads none but the first. Ref: S3, by compiling.
    """
    warnings: list[SourceWarning] = []
    if source.count("$") < 2:  # one $STAMP is in any source
        return warnings
    for number, line in enumerate(lines_of(source), 1):
        code, said, rest = parts_of(line) if line.count("$") > 1 else ("", "", "")
        later = _LATER.search(rest) if said else None
        if later is not None:
            words = "the tokenizer does not see a directive behind another; give it its own line"
            warnings.append(SourceWarning(number, len(code + said) + later.start() + 1, words))
    return warnings


def _word_strings(compiled: Compiled) -> list[SourceWarning]:
    """Return a warning for each string that is named by a word variable.

    The tokenizer refuses nibbles and bits there, but takes the number of a word for that of a
    byte: of a word in W0, for one in OUTH. Ref: S3, by compiling.
    """
    if "STR" not in compiled.source.upper():  # most sources, and looking closer takes time
        return []
    code = blanked(compiled.source)
    if _STRING.search(code) is None:
        return []
    try:
        places = layout_of(compiled.source)
    except NotUnderstoodError:
        return []
    lines = Lines(compiled.source)
    found = []
    for piece in pieces_of(compiled, code, ()):
        for string in _STRING.finditer(piece.text):
            place = place_in(places, string[2])
            if place is None or place.size_bits != 16:
                continue
            found.append(
                SourceWarning(
                    *lines.place(piece.statement.offset + string.start(2)),
                    f"{string[1].upper()} {string[2]} names a word, which the tokenizer takes for "
                    f"the byte {variable(place.element, 8)}; declare bytes",
                )
            )
    return found
