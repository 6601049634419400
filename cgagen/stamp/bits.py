"""Reading the stream bit by bit, and saying where it went wrong."""

from functools import lru_cache

from cgagen.errors import ImageError
from cgagen.stamp.chips import EEPROM_BYTES
from cgagen.stamp.program import Kind, Token
from cgagen.stamp.stream import address_at

STREAM_BITS = 8 * EEPROM_BYTES

ADDRESS_BITS = 14

ELEMENT_BITS = {1: 8, 4: 6, 8: 5, 16: 4}
"""Bits of the element number by those of the variable. Ref: S3."""

_SIZES = (*ELEMENT_BITS,)
"""Bits of a variable by the last two of its code. Ref: S3."""

_OPERATORS = tuple(Token(Kind.OPERATOR, code) for code in range(0x20))


class BitReader:
    """A place in the stream.

    Args:
        stream: see `cgagen.stamp.stream.stream_of`.
        position: the bit that is read next.
    """

    __slots__ = ("position", "stream")

    def __init__(self, stream: str, position: int) -> None:
        self.stream = stream
        self.position = position

    def take(self, bits: int) -> int:
        """Return the number in the next bits, the most significant first.

        Raises:
            ImageError: the stream ends.
        """
        end = self.position + bits
        if end > len(self.stream):
            raise refused(self.position, "the EEPROM ends inside an instruction")
        number = int(self.stream[self.position : end], 2)
        self.position = end
        return number

    def flag(self) -> bool:
        """Return whether the next bit is 1.

        Raises:
            ImageError: the stream ends.
        """
        here = self.position
        if here >= len(self.stream):
            return self.take(1) == 1  # which refuses
        self.position = here + 1
        return self.stream[here] == "1"

    def address(self) -> int:
        """Return the address in the next 14 bits.

        Raises:
            ImageError: the stream ends.
        """
        here = self.position
        self.take(ADDRESS_BITS)
        return address_at(self.stream, here)

    def token(self) -> Token:
        """Return the next token of an expression.

        Raises:
            ImageError: the stream ends.
        """
        code = self.take(6)
        if code < len(_OPERATORS):
            return _OPERATORS[code]
        if code < 0x30:
            return _constant(self._number(code & 15))
        return _variable(code, self.take(ELEMENT_BITS[_SIZES[code & 3]]))

    def _number(self, width: int) -> int:
        more = self.flag()
        if width == 0:
            return 0 if more else 1
        return 1 << width | (self.take(width) if more else 0)


@lru_cache(1 << 12)
def _constant(value: int) -> Token:
    return Token(Kind.CONSTANT, value)


@lru_cache(1 << 12)
def _variable(code: int, element: int) -> Token:
    kind = Kind.WRITE if code & 8 else Kind.READ
    return Token(kind, element, _SIZES[code & 3], bool(code & 4))


def place(bit: int) -> str:
    """Return where a stream bit is, in words.

    >>> place(14)
    'stream bit 14 (byte 2046, bit 1)'
    """
    return f"stream bit {bit} (byte {EEPROM_BYTES - 1 - bit // 8}, bit {7 - bit % 8})"


def refused(bit: int, what: str) -> ImageError:
    """Return the error of bytes that are no program, with their place.

    Args:
        bit: stream bit.
        what: what is wrong there, without a full stop.
    """
    return ImageError(
        f"{place(bit)}: {what}; give an image that the tokenizer made, and the model it is for"
    )
