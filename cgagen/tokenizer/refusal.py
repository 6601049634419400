"""What the tokenizer refuses, as one sentence with file, line and column."""

import re

from cgagen.errors import SourceError
from cgagen.stamp.compiled import Compiled
from cgagen.stamp.pins import INSTRUCTIONS_WITH_PINS, PROGRAMMING_PORT, wrong_pin
from cgagen.stamp.stream import stream_of
from cgagen.tokenizer.text import Lines

WITHOUT_PLACE = frozenset({124, 128, 156, 157})
"""Errors whose place is 0 or means nothing: overlap of data and program, symbol table full,
no $STAMP, nothing to tokenize. Ref: S3, measured."""

_CODED = re.compile(r"(\d+)-(.*)", re.DOTALL)
_WORD = re.compile(r"\w*")
_LONGEST_WORD = 40


def refusal(source: str, name: str, error: str, start: int, length: int) -> SourceError:
    """Return the error that says what the tokenizer says, and where.

    Args:
        source: the text that was sent.
        name: what the source is called.
        error: the tokenizer's words, "110-Undefined symbol".
        start: its place, a character from 0.
        length: characters that it covers.
    """
    coded = _CODED.fullmatch(error)
    code = int(coded[1]) if coded else 0
    if code in WITHOUT_PLACE:
        return SourceError(f"{name}: {error}{_advice(code)}", code=code)
    line, column = Lines(source).place(start)
    word = source[start : start + length].strip()
    # The word is shown where it helps to find the place: one word, not a whole statement.
    shown = f" ({word})" if word and word.isprintable() and len(word) <= _LONGEST_WORD else ""
    return SourceError(
        f"{name}:{line}:{column}: {error}{shown}",
        code=code,
        line=line,
        column=column,
        length=length,
    )


def _advice(code: int) -> str:
    return "; start with ' {$STAMP BS2} or another model" if code == 156 else ""


def refuse_wrong_pins(compiled: Compiled) -> None:
    """Refuse a program that names a pin the chip does not have.

    Raises:
        SourceError: the first such statement.
    """
    stream = stream_of(compiled.image.eeprom)
    for statement in compiled.source_map.statements:
        found = _WORD.match(compiled.source, statement.offset)
        word = found[0].upper() if found else ""
        if word not in INSTRUCTIONS_WITH_PINS:
            continue
        wrong = wrong_pin(stream, statement.bit, compiled.image.model)
        if wrong is not None:
            port = " (16 is the programming port)" if wrong.last == PROGRAMMING_PORT else ""
            raise SourceError(
                f"{compiled.name}:{statement.line}:{statement.column}: {word} names pin "
                f"{wrong.pin}; give one of 0 to {wrong.last}{port}",
                line=statement.line,
                column=statement.column,
                length=len(word),
            )
