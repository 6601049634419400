"""Constant expressions of PBASIC: words of a text, and their 16-bit values.

Operators apply from left to right, all of one rank; only directives rank them (`#IF`). What is
not understood is left to the tokenizer: it raises `NotUnderstoodError`, and the caller claims
nothing.
"""

import re
from collections.abc import Callable, Mapping

_TOKEN = re.compile(
    r"\s*(?:(?P<text>\"[^\"]*\")|(?P<hex>\$[0-9A-Fa-f]+)|(?P<editor>\$[A-Za-z]+)|(?P<bin>%[01]+)"
    r"|(?P<dec>\d+)|(?P<name>[A-Za-z_]\w*)|(?P<mark>//|<<|>>|<=|>=|=<|=>|<>|><|[-+*/&|^@(),<>=]))"
)
OPERATORS: dict[str, Callable[[int, int], int]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a // b,
    "//": lambda a, b: a % b,
    "<<": lambda a, b: a << b,
    ">>": lambda a, b: a >> b,
    "&": lambda a, b: a & b,
    "|": lambda a, b: a | b,
    "^": lambda a, b: a ^ b,
}
"""Operators of constants, applied from left to right. Ref: S2 p. 103."""

CONTROL = {
    "CLS": 0, "HOME": 1, "CRSRXY": 2, "CRSRLF": 3, "CRSRRT": 4, "CRSRUP": 5, "CRSRDN": 6,
    "BELL": 7, "BKSP": 8, "TAB": 9, "LF": 10, "CLREOL": 11, "CLRDN": 12, "CR": 13, "CRSRX": 14,
    "CRSRY": 15,
}  # fmt: skip
"""Names of the DEBUG terminal's control codes. Ref: S2 p. 167, S4 (DEBUG), S3."""

Symbols = Mapping[str, int]
"""Values by name, in capitals."""


class NotUnderstoodError(Exception):
    """Something that this reader leaves to the tokenizer."""


def words_of(text: str) -> list[str]:
    """Return the words of an expression.

    Raises:
        NotUnderstoodError: it has a character that belongs to none.

    >>> words_of('n+$1F, "a b"')
    ['n', '+', '$1F', ',', '"a b"']
    """
    words, place = [], 0
    text = text.rstrip()
    while place < len(text):
        match = _TOKEN.match(text, place)
        if match is None:
            raise NotUnderstoodError(text[place:])
        words.append(match[0].strip())
        place = match.end()
    return words


def value_at(words: list[str], place: int, symbols: Symbols | None) -> tuple[int, int]:
    """Return the 16-bit value of a constant expression, and the place behind it.

    Args:
        words: see `words_of`.
        place: where it begins.
        symbols: without them the value does not matter, and any name may stand there.

    Raises:
        NotUnderstoodError: it is none, or names what is not known.

    >>> value_at(words_of("n + 2 * 3"), 0, {"N": 5})
    (21, 5)
    """
    value, place = operand_at(words, place, symbols)
    while place < len(words) and words[place] in OPERATORS:
        other, after = operand_at(words, place + 1, symbols)
        value = applied(words[place], value, other)
        place = after
    return value, place


def applied(sign: str, left: int, right: int) -> int:
    """Return what an operator makes of two constants, 16 bits.

    Raises:
        NotUnderstoodError: a division by 0, a shift by more than a word has.
    """
    if (sign in ("/", "//") and not right) or (sign in ("<<", ">>") and right > 15):
        raise NotUnderstoodError(f"{left} {sign} {right}")
    return OPERATORS[sign](left, right) & 0xFFFF


def operand_at(words: list[str], place: int, symbols: Symbols | None) -> tuple[int, int]:
    """Return the value of a number, a character or a name, and the place behind it.

    Raises:
        NotUnderstoodError: there is none.
    """
    word = words[place] if place < len(words) else ""
    if word == "-":
        value, place = operand_at(words, place + 1, symbols)
        return -value & 0xFFFF, place
    if word.startswith("$"):
        if word[1:].isalpha() and not set(word[1:].upper()) <= set("ABCDEF"):
            raise NotUnderstoodError(word)
        return int(word[1:], 16), place + 1
    if word.startswith("%"):
        return int(word[1:], 2), place + 1
    if word.isdigit():
        return int(word), place + 1
    if word.startswith('"') and len(word) == 3:
        return ord(word[1]), place + 1
    if symbols is None and (word[:1].isalpha() or word[:1] == "_"):
        return 1, place + 1
    if symbols is not None and word.upper() in symbols:
        return symbols[word.upper()], place + 1
    raise NotUnderstoodError(word)
