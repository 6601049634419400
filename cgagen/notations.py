"""TOML and JSON of the user's, read so that nothing in them takes long, or is no error of theirs.

Both readers of Python's own meet a number of 5,000 digits, or lists 5,000 deep, with errors that
are not those of a wrong file; JSON's takes NaN, and of a key that is there twice the last.
"""

import json
import math
import re
import tomllib
from collections.abc import Iterator
from typing import Any, NoReturn

from cgagen.shown import short, shown

DEEPEST = 32
"""Tables and lists within each other. Choice: our own files have at most six."""

LARGEST_INTEGER = 1 << 64
"""A run's seed may have 64 bits; nothing of ours is larger."""

_WORD = r"""(?:"[^"\n]*"|'[^'\n]*'|(?<![\w-])[\w-]+)"""
_LONG_KEY = re.compile(rf"(?:{_WORD}[ \t]*\.[ \t]*){{{DEEPEST}}}")
"""A key of so many parts: what reads TOML needs minutes for one of thousands."""


def small_number(word: str) -> int | None:
    r"""Return the number that one to eighteen ASCII digits are; None where a word is anything else.

    `int` refuses 5,000 digits with an error of its own, and takes digits of any script.

    >>> small_number("12"), small_number("-1"), small_number("9" * 5_000), small_number("\u00b2")
    (12, None, None, None)
    """
    return int(word) if re.fullmatch("[0-9]{1,18}", word) else None


def parse_toml(text: str) -> dict[str, Any]:
    """Return the content of a TOML file.

    Raises:
        ValueError: it is not TOML, nested too deeply, or has a number that is too large; the text
            of the error is a part of a sentence.
    """
    found = _LONG_KEY.search(text)
    if found:
        line = text.count("\n", 0, found.start()) + 1
        raise ValueError(f"line {line} has a key of more than {DEEPEST} parts")
    try:
        content = tomllib.loads(text)
    except RecursionError:
        raise ValueError(f"it is nested more than {DEEPEST} deep") from None
    except tomllib.TOMLDecodeError as error:
        raise ValueError(short(str(error), 200)) from None
    except ValueError as error:
        raise ValueError(_number_trouble(error)) from None
    _check_values(content)
    return content


def parse_json(text: str | bytes) -> Any:
    """Return the content of a JSON text.

    Raises:
        ValueError: it is not JSON, has a key twice, a number that is none or too large, or is
            nested too deeply; the text of the error is a part of a sentence.
    """
    try:
        content = json.loads(
            text, object_pairs_hook=_once, parse_constant=_no_number, parse_float=_finite
        )
    except RecursionError:
        raise ValueError(f"it is nested more than {DEEPEST} deep") from None
    except json.JSONDecodeError as error:
        raise ValueError(f"line {error.lineno}: {short(error.msg, 200)}") from None
    except UnicodeDecodeError as error:
        raise ValueError(f"byte {error.start} is not UTF-8 text") from None
    except ValueError as error:
        raise ValueError(_number_trouble(error)) from None
    _check_values(content)
    return content


def _number_trouble(error: ValueError) -> str:
    """Return what Python says of a number of thousands of digits in a user's words."""
    words = str(error)
    return "it has a whole number of thousands of digits" if "integer string" in words else words


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        seen: set[str] = set()
        twice = next(key for key, _ in pairs if key in seen or seen.add(key))  # type: ignore[func-returns-value]
        raise ValueError(f"the key {shown(twice)} is there twice")
    return found


def _no_number(word: str) -> NoReturn:
    raise ValueError(f"{word} is no number")


def _finite(digits: str) -> float:
    number = float(digits)
    if not math.isfinite(number):
        raise ValueError(f"{short(digits)} is too large a number")
    return number


def _check_values(content: Any) -> None:
    """Refuse what nests too deeply, numbers beyond all of ours, and text that is none."""
    level = [content]
    for _ in range(DEEPEST + 1):
        for one in level:
            _check_value(one)
        level = [inner for one in level for inner in _inside(one)]
        if not level:
            return
    raise ValueError(f"it is nested more than {DEEPEST} deep")


def _inside(value: Any) -> Iterator[Any]:
    if isinstance(value, dict):
        yield from value
        yield from value.values()
    elif isinstance(value, list):
        yield from value


def _check_value(value: Any) -> None:
    if isinstance(value, int) and not -LARGEST_INTEGER < value < LARGEST_INTEGER:
        raise ValueError("it has a whole number of more than 64 bits")
    if isinstance(value, str) and not value.isascii():
        try:
            value.encode()
        except UnicodeEncodeError:
            raise ValueError(f"{shown(value)} is no text") from None
