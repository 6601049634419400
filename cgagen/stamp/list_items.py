"""What the items of input and output lists say: numbers as text, strings, waiting, skipping.

Ref: S3 for every word; S2 p. 162 to 168 for what the formatters are.
"""

from collections.abc import Sequence
from itertools import product

from cgagen.stamp.bits import refused
from cgagen.stamp.program import Item, constant_of
from cgagen.stamp.wording import expression_text, operand_text, variable, write_text

STRING_TO_ZERO = 0x200
"""Added to the register's byte number: a string that goes up to a zero byte on output, and up to a
character, given first, on input; without it, of as many bytes as the next value says."""
REPEAT_OR_SKIP = 0x400
WAIT_STRING = 0x800
WAIT_STRING_LENGTH = 0xA00
WAIT = 0xC44
SCRATCH_STRING = 0x1000
REGISTERS = 0x20
LONGEST_STRING = 32
"""What is pushed as length where none is given. Ref: S3."""

_NUMBER = 0x100
_FIXED = 0x200
_SIGNED = 0x400
_INDICATOR = 0x800
_ANY = 0x1000
_RADIXES = (("DEC", 10, 5), ("HEX", 16, 4), ("BIN", 2, 16))
"""Word, radix, most digits."""


def _formatters() -> dict[int, str]:
    """Return the PBASIC word of every formatter word."""
    words = {0x1106: "NUM", 0x1506: "SNUM"}
    for (name, radix, most), sign, indicator in product(_RADIXES, (0, _SIGNED), (0, _INDICATOR)):
        if indicator and name == "DEC":
            continue
        prefix = ("I" if indicator else "") + ("S" if sign else "")
        for digits in range(most + 1):
            fixed = _FIXED if digits else 0
            word = (16 - radix) & 15 | ((16 - (digits or most)) & 15) << 4
            words[_NUMBER | word | fixed | sign | indicator] = f"{prefix}{name}{digits or ''}"
    return words


FORMATTERS = _formatters()
"""Formatter word: 4 bits 16 - radix, 4 bits 16 - digits, then flags. Ref: S3."""


def output_text(items: Sequence[Item], bit: int, quoted: bool) -> str:
    """Return a list of output items.

    Args:
        items: of SEROUT, LCDOUT, OWOUT or I2COUT.
        bit: where the instruction is, for messages.
        quoted: runs of printable characters are shown as text.

    Raises:
        ImageError: an item that PBASIC has no word for.
    """
    words: list[str] = []
    run = ""
    for item in items:
        char = constant_of(item.values[0]) if quoted and len(item.values) == 1 else None
        if char is not None and 32 <= char < 127 and char != ord('"'):
            run += chr(char)
            continue
        words += _quoted(run)
        run = ""
        words.append("CR" if char == 13 else _output(item, bit))
    return ", ".join(words + _quoted(run))


def input_text(items: Sequence[Item], bit: int) -> str:
    """Return a list of input items.

    Raises:
        ImageError: an item that PBASIC has no word for.
    """
    return ", ".join(_input(item, bit) for item in items)


def _quoted(run: str) -> list[str]:
    return [f'"{run}"'] if run else []


def _output(item: Item, bit: int) -> str:
    values = item.values
    if len(values) == 1:
        return expression_text(values[0])
    first = constant_of(values[0])
    last = operand_text(values[-1])
    if len(values) == 3 and constant_of(values[1]) == REPEAT_OR_SKIP:
        return f"REP {operand_text(values[0])}\\{last}"
    if len(values) == 2 and first is not None:
        if first in FORMATTERS and not first & _ANY:
            return f"{FORMATTERS[first]} {last}"
        if first < REGISTERS:
            return f"STR {_string(first)}\\{last}"
        if 0 <= first - STRING_TO_ZERO < REGISTERS and last == str(LONGEST_STRING):
            return f"STR {_string(first - STRING_TO_ZERO)}"
    raise refused(bit, "an output item has no word in PBASIC")


def _input(item: Item, bit: int) -> str:
    values = item.values
    if item.write is not None:
        if not values:
            return write_text(item.write)
        word = constant_of(values[0])
        if word in FORMATTERS and constant_of(values[1]) == 0:
            return f"{FORMATTERS[word]} {write_text(item.write)}"
    code = constant_of(values[-2]) if len(values) > 1 else None
    text = None if code is None else _input_without_variable(item, code)
    if text is None:
        raise refused(bit, "an input item has no word in PBASIC")
    return text


def _input_without_variable(item: Item, code: int) -> str | None:
    """Return the words of an item by its code, the value before the last; None: it has none."""
    *before, _, count = item.values
    last = operand_text(count)
    if code == WAIT and constant_of(count) == len(before):
        return f"WAIT ({', '.join(expression_text(value) for value in reversed(before))})"
    if len(before) == 1 and 0 <= code - STRING_TO_ZERO < REGISTERS:
        return f"STR {_string(code - STRING_TO_ZERO)}\\{last}\\{operand_text(before[0])}"
    if before:
        return None
    if code < REGISTERS:
        return f"STR {_string(code)}\\{last}"
    if code == REPEAT_OR_SKIP:
        return f"SKIP {last}"
    if code == SCRATCH_STRING:
        return f"SPSTR {last}"
    if 0 <= code - WAIT_STRING < REGISTERS and last == str(LONGEST_STRING):
        return f"WAITSTR {_string(code - WAIT_STRING)}"
    if 0 <= code - WAIT_STRING_LENGTH < REGISTERS:
        return f"WAITSTR {_string(code - WAIT_STRING_LENGTH)}\\{last}"
    return None


def _string(register: int) -> str:
    """Return the byte variable that a string starts at; bytes of INS are named, too."""
    return variable(register, 8)
