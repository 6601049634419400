"""The operators of the stack machine on 16-bit words, every one a pure function.

Ref: S2 p. 103 to 120 for what they do; `cgagen.emulator.unknowns` for what no document says.
"""

from collections.abc import Callable
from functools import cache
from math import atan2, cos, isqrt, pi, sin, sqrt

from cgagen.emulator.unknowns import CHOICES, Rounding, Unknowns, Wide

WORD = 0xFFFF

Unary = Callable[[int], int]
Binary = Callable[[int, int], int]


def unary_operators(unknowns: Unknowns = CHOICES) -> dict[int, Unary]:
    """Return the operators of one operand by code; treat the table as constant.

    >>> negate = unary_operators()[0x03]
    >>> negate(1)
    65535
    """
    return _unary(unknowns)


def binary_operators(unknowns: Unknowns = CHOICES) -> dict[int, Binary]:
    """Return the operators of two operands by code; the second was pushed last.

    >>> middle = binary_operators()[0x11]
    >>> middle(1000, 0x0180)
    1500
    """
    return _binary(unknowns)


@cache
def _unary(unknowns: Unknowns) -> dict[int, Unary]:
    return {
        0x00: _root(unknowns.root),
        0x01: absolute,
        0x02: invert,
        0x03: negate,
        0x04: _decode(unknowns.wide_decode),
        0x05: encode,
        0x06: _circle(cos, unknowns.sine),
        0x07: _circle(sin, unknowns.sine),
    }


@cache
def _binary(unknowns: Unknowns) -> dict[int, Binary]:
    true = unknowns.true_word
    return {
        0x08: _hypotenuse(unknowns.root),
        0x09: _angle(unknowns.angle),
        0x0A: lambda x, y: x & y,
        0x0B: lambda x, y: x | y,
        0x0C: lambda x, y: x ^ y,
        0x0D: max,  # MIN is the least that the result may be
        0x0E: min,
        0x0F: lambda x, y: x + y & WORD,
        0x10: lambda x, y: x - y & WORD,
        0x11: lambda x, y: x * y >> 8 & WORD,
        0x12: lambda x, y: x * y & WORD,
        0x13: lambda x, y: x * y >> 16,
        0x14: _remainder(unknowns.remainder_by_zero),
        0x15: _quotient(unknowns.quotient_by_zero),
        0x16: _digit(unknowns.wide_digit),
        0x17: _left(unknowns.wide_shift),
        0x18: _right(unknowns.wide_shift),
        0x19: _reverse(unknowns.wide_reverse),
        0x1A: lambda x, y: true if x >= y else 0,
        0x1B: lambda x, y: true if x <= y else 0,
        0x1C: lambda x, y: true if x == y else 0,
        0x1D: lambda x, y: true if x != y else 0,
        0x1E: lambda x, y: true if x > y else 0,
        0x1F: lambda x, y: true if x < y else 0,
    }


def absolute(x: int) -> int:
    """ABS: the size of a two's complement number. 32,768 stays what it is."""
    return -x & WORD if x & 0x8000 else x


def invert(x: int) -> int:
    """Return ~ and NOT."""
    return x ^ WORD


def negate(x: int) -> int:
    """Return the two's complement."""
    return -x & WORD


def encode(x: int) -> int:
    """NCD: the place of the highest 1, counted from 1; 0 for 0."""
    return x.bit_length()


def signed_byte(x: int) -> int:
    """Return the low byte as a number from -128 to 127."""
    return (x & 0xFF ^ 0x80) - 0x80


def next_random(seed: int, unknowns: Unknowns = CHOICES) -> int:
    """Return what RANDOM makes of a word.

    A shift register of 16 bits, moved left by one. Which taps the chips have is not published.

    >>> next_random(0), next_random(1)
    (1, 3)
    """
    parity = (seed & unknowns.random_taps).bit_count() & 1
    return (seed << 1 | parity ^ unknowns.random_inverts) & WORD


def _whole(value: float, rounding: Rounding) -> int:
    return round(value) if rounding is Rounding.NEAREST else int(value)


def _root(rounding: Rounding) -> Unary:
    return isqrt if rounding is Rounding.DOWN else lambda x: round(sqrt(x))


def _decode(wide: Wide) -> Unary:
    if wide is Wide.WRAPS:
        return lambda x: 1 << (x & 15)
    return lambda x: 1 << x if x < 16 else 0


def _circle(function: Callable[[float], float], rounding: Rounding) -> Unary:
    """127 times sine or cosine of 256ths of a turn, as a two's complement word."""
    table = [_whole(127 * function(x * pi / 128), rounding) & WORD for x in range(256)]
    return lambda x: table[x & 0xFF]


def _hypotenuse(rounding: Rounding) -> Binary:
    root = _root(rounding)
    return lambda x, y: root(signed_byte(x) ** 2 + signed_byte(y) ** 2)


def _angle(rounding: Rounding) -> Binary:
    """The direction of the point (x, y) in 256ths of a turn, against the clock from the x axis."""

    def angle(x: int, y: int) -> int:
        turn = atan2(signed_byte(y), signed_byte(x)) * 128 / pi
        return _whole(turn % 256, rounding) & 0xFF

    return angle


def _remainder(by_zero: int | None) -> Binary:
    def remainder(x: int, y: int) -> int:
        if y:
            return x % y
        return x if by_zero is None else by_zero

    return remainder


def _quotient(by_zero: int) -> Binary:
    return lambda x, y: x // y if y else by_zero


def _digit(wide: Wide) -> Binary:
    if wide is Wide.WRAPS:
        return lambda x, y: x // 10 ** (y % 5) % 10
    return lambda x, y: x // 10**y % 10 if y < 5 else 0


def _left(wide: Wide) -> Binary:
    if wide is Wide.WRAPS:
        return lambda x, y: x << (y & 15) & WORD
    return lambda x, y: x << y & WORD if y < 16 else 0


def _right(wide: Wide) -> Binary:
    if wide is Wide.WRAPS:
        return lambda x, y: x >> (y & 15)
    return lambda x, y: x >> y


def _reverse(wide: Wide) -> Binary:
    def reverse(x: int, y: int) -> int:
        bits = y & 15 if wide is Wide.WRAPS and y > 16 else min(y, 32)
        result = 0
        for _ in range(bits):
            result = (result << 1 | x & 1) & WORD
            x >>= 1
        return result

    return reverse
