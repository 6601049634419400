"""Numbers as text, both ways: DEC, HEX, BIN and their relatives.

Pure: no pins and no time. The formatter word is the tokenizer's (Ref: S3); what it means is the
manual's (Ref: S2 p. 163 to 166 for output, p. 402 to 404 and appendix C for input).
"""

from typing import NamedTuple

from cgagen.errors import ExecutionError

NUMBER = 0x100
FIXED = 0x200
SIGNED = 0x400
INDICATED = 0x800
ANY = 0x1000

WORD = 0xFFFF
_DIGITS = b"0123456789ABCDEF"
_INDICATORS = {16: ord("$"), 2: ord("%")}
_RADIX_OF = {indicator: radix for radix, indicator in _INDICATORS.items()}
_MINUS = ord("-")


class Format(NamedTuple):
    """A formatter word, taken apart.

    Attributes:
        radix: 10, 16 or 2. The word could say any number from 2 to 16.
        digits: how many there are, or are read at most; 0 where no number is fixed.
        signed: S: a sign is written, and read.
        indicated: I: `$` or `%` before the digits.
        any_radix: NUM and SNUM: the text itself says which radix.
    """

    radix: int
    digits: int
    signed: bool
    indicated: bool
    any_radix: bool


def format_of(word: int) -> Format:
    """Take a formatter word apart.

    Raises:
        ExecutionError: its radix is 1, which no formatter of PBASIC has.

    >>> format_of(0x0BC0)
    Format(radix=16, digits=4, signed=False, indicated=True, any_radix=False)
    """
    radix = 16 - (word & 15)
    if radix == 1:
        raise ExecutionError(
            f"the formatter {word:04X}h asks for a number in radix 1; compile the program anew"
        )
    digits = 16 - (word >> 4 & 15) if word & FIXED else 0
    return Format(radix, digits, bool(word & SIGNED), bool(word & INDICATED), bool(word & ANY))


def text_of(word: int, value: int) -> bytes:
    """Return a number as the chip sends it.

    A sign is a space or a minus (Ref: S2 p. 164) and stands before the indicator. A fixed number
    of digits is padded with zeros, or loses its leading ones (Ref: S2 p. 163, note 1).

    Args:
        word: the formatter.
        value: 16 bits.

    >>> text_of(0x01B6, 65471), text_of(0x0FC0, -65 & WORD), text_of(0x03C6, 56422)
    (b'65471', b'-$0041', b'6422')
    """
    form = format_of(word)
    sign = b""
    if form.signed:
        negative = value >= 0x8000
        sign, value = (b"-", -value & WORD) if negative else (b" ", value)
    digits = bytearray()
    while value or not digits:
        value, digit = divmod(value, form.radix)
        digits.append(_DIGITS[digit])
    if form.digits:
        digits = digits[: form.digits].ljust(form.digits, b"0")
    indicator = bytes([_INDICATORS[form.radix]]) if _indicates(form) else b""
    return sign + indicator + bytes(reversed(digits))


class NumberReader:
    """Makes a number of text, byte by byte.

    Whatever is no digit is skipped until the first digit; the number ends with the fixed number
    of digits or with the first byte that is none, which is taken, too. Overflow keeps the low 16
    bits. A minus and an indicator count only directly before what they belong to.

    Attributes:
        value: what was read so far, 16 bits.

    >>> reader = NumberReader(0x05B6)
    >>> [reader.take(byte) for byte in b"a-12,"], reader.value - 0x10000
    ([False, False, False, False, True], -12)
    """

    __slots__ = ("_count", "_form", "_negative", "_prefixed", "_radix", "value")

    def __init__(self, word: int) -> None:
        self._form = format_of(word)
        self._radix = self._form.radix
        self._negative = False
        self._prefixed = False
        self._count = 0
        self.value = 0

    def take(self, byte: int) -> bool:
        """Read one byte; True where the number is complete."""
        digit = self._digit(byte)
        if digit is None:
            if self._count:
                return self._finish()
            self._before(byte)
            # NUM: what follows a lone `%` may begin a decimal number.
            digit = self._digit(byte)
        if digit is None:
            return False
        self._count += 1
        self.value = (self.value * self._radix + digit) & WORD
        return self._count == self._form.digits and self._finish()

    def _digit(self, byte: int) -> int | None:
        """Return the value of a byte where it is a digit of this number; else None."""
        if _indicates(self._form) and not (self._count or self._prefixed):
            return None
        digit = _DIGITS.find(bytes([byte]).upper())
        return digit if 0 <= digit < self._radix else None

    def _before(self, byte: int) -> None:
        """Look at a byte that comes before the first digit."""
        form = self._form
        if byte == _MINUS and form.signed:
            self._negative, self._prefixed, self._radix = True, False, form.radix
            return
        radix = None
        if form.any_radix:
            radix = _RADIX_OF.get(byte)
        elif _indicates(form) and byte == _INDICATORS[form.radix]:
            radix = form.radix
        # A minus counts for the indicator that follows it, not for one after that.
        self._negative = self._negative and radix is not None and not self._prefixed
        self._prefixed = radix is not None
        self._radix = radix or form.radix

    def _finish(self) -> bool:
        if self._negative:
            self.value = -self.value & WORD
        return True


def _indicates(form: Format) -> bool:
    """Whether the text has an indicator: only hexadecimal and binary numbers have one."""
    return form.indicated and form.radix in _INDICATORS
