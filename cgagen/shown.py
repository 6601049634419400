"""Text of others as it may reach a terminal, and values as a sentence quotes them.

A name, a trace or what a Stamp sends may hold anything: sequences that move the cursor, colour
what follows or rename the window, marks that turn the direction of writing. None of it is for the
terminal of who reads it.
"""

import re
import unicodedata

LONGEST = 80
"""Characters of a quoted value. Choice: a line of a terminal."""

LONGEST_WORD = 320
"""Characters of a word of a message: no key, no number and hardly a path has more. Choice."""

LONGEST_MESSAGE = 4_000
"""Characters of a whole sentence of ours; the longest honest ones have some 800. Choice."""

_ELSEWHERE = re.compile(r"[^\n\t\x20-\x7e]")


def printable(text: str) -> str:
    r"""Return a text whose every character takes a place and does nothing; lines and tabs stay.

    What is no character that can be seen is written as Python writes it. A CR before a line's
    end is part of that end.

    >>> printable("\x1b[31mred\x07 caf\u00e9\u202e")
    '\\x1b[31mred\\x07 café\\u202e'
    """
    text = text.replace("\r\n", "\n")
    return _ELSEWHERE.sub(lambda match: _visible(match[0]), text)


def _visible(one: str) -> str:
    if one.isprintable() or unicodedata.category(one) == "Zs":
        return one
    return ascii(one)[1:-1]


def shown(value: object, most: int = LONGEST) -> str:
    """Return a value as Python writes it, on one line and its middle left out where it is long.

    >>> shown("a" * 5_000, 20)
    "'aaaaaaa... 5,002 characters ...aaaaaaa'"
    """
    try:
        text = repr(value)
    except (RecursionError, ValueError):  # nested too deeply, or a number of too many digits
        return f"a {type(value).__name__} that is too large to show"
    return short(text.replace("\n", r"\n").replace("\t", r"\t"), most)


def short(text: str, most: int = LONGEST) -> str:
    """Return a text that can be printed, its middle left out where it has too many characters.

    >>> short("main.bsp")
    'main.bsp'
    """
    if len(text) > most:
        kept = max(4, (most - 4) // 2)
        text = f"{text[:kept]}... {len(text):,} characters ...{text[-kept:]}"
    return printable(text)


def sentence(text: str, most: int = LONGEST_MESSAGE) -> str:
    """Return a whole message, printable, with words and all of it cut where they are too long.

    >>> sentence("no verb " + "n" * 70_000)[:40], len(sentence("no verb " + "n" * 70_000))
    ('no verb nnnnnnnnnnnnnnnnnnnnnnnnnnnnnnnn', 189)
    """
    calm = _LONG_WORD.sub(lambda match: short(match[0], LONGEST_WORD // 2), text)
    return short(calm, most)


_LONG_WORD = re.compile(rf"\S{{{LONGEST_WORD + 1},}}")
