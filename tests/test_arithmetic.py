"""The operators against a second model, written bit by bit from the documents."""

from dataclasses import replace
from math import atan2, cos, isqrt, radians, sin

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cgagen.emulator.arithmetic import (
    binary_operators,
    next_random,
    signed_byte,
    unary_operators,
)
from cgagen.emulator.unknowns import CHOICES, Rounding, Wide
from cgagen.stamp.opcodes import OPERATORS

WORDS = st.integers(0, 0xFFFF)
SMALL = st.integers(0, 20)
EITHER = st.one_of(WORDS, SMALL)

UNARY = unary_operators()
BINARY = binary_operators()
CODES = {row.symbol if row.operands == 2 else f"{row.symbol} x": row.code for row in OPERATORS}


def bits_of(word: int) -> list[int]:
    return [word // 2**n % 2 for n in range(16)]


def word_of(bits: list[int]) -> int:
    return sum(bit * 2**n for n, bit in enumerate(bits[:16]))


def bitwise(x: int, y: int, table: dict[tuple[int, int], int]) -> int:
    return word_of([table[pair] for pair in zip(bits_of(x), bits_of(y), strict=True)])


def added(x: int, y: int, carry: int = 0) -> int:
    total = []
    for a, b in zip(bits_of(x), bits_of(y), strict=True):
        total.append((a + b + carry) % 2)
        carry = (a + b + carry) // 2
    return word_of(total)


def inverted(x: int) -> int:
    return word_of([1 - bit for bit in bits_of(x)])


def product_bits(x: int, y: int) -> list[int]:
    total = sum(x * 2**n for n, bit in enumerate(bits_of(y)) if bit)
    return [total // 2**n % 2 for n in range(32)]


def divided(x: int, y: int) -> tuple[int, int]:
    quotient, rest = 0, 0
    for bit in reversed(bits_of(x)):  # long division
        rest = rest * 2 + bit
        quotient *= 2
        if rest >= y:
            rest -= y
            quotient += 1
    return quotient, rest


def truth(holds: bool) -> int:
    return 65535 if holds else 0


def shifted(x: int, count: int, left: bool) -> int:
    bits = bits_of(x)
    for _ in range(min(count, 16)):
        bits = [0, *bits[:15]] if left else [*bits[1:], 0]
    return word_of(bits)


def digit(x: int, place: int) -> int:
    text = str(x)[::-1]
    return int(text[place]) if place < len(text) else 0


MODEL = {
    "SQR x": lambda x: max(n for n in range(256) if n * n <= x),
    "ABS x": lambda x: x if x < 32768 else 65536 - x,
    "~ x": inverted,
    "- x": lambda x: added(inverted(x), 1),
    "DCD x": lambda x: 2 ** (x % 16),
    "NCD x": lambda x: max((n + 1 for n, bit in enumerate(bits_of(x)) if bit), default=0),
    "COS x": lambda x: round(127 * cos(radians(x % 256 * 360 / 256))) % 65536,
    "SIN x": lambda x: round(127 * sin(radians(x % 256 * 360 / 256))) % 65536,
}
TWO = {
    "&": lambda x, y: bitwise(x, y, {(0, 0): 0, (0, 1): 0, (1, 0): 0, (1, 1): 1}),
    "|": lambda x, y: bitwise(x, y, {(0, 0): 0, (0, 1): 1, (1, 0): 1, (1, 1): 1}),
    "^": lambda x, y: bitwise(x, y, {(0, 0): 0, (0, 1): 1, (1, 0): 1, (1, 1): 0}),
    "MIN": lambda x, y: x if x > y else y,
    "MAX": lambda x, y: y if x > y else x,
    "+": added,
    "-": lambda x, y: added(x, inverted(y), 1),
    "*/": lambda x, y: word_of(product_bits(x, y)[8:24]),
    "*": lambda x, y: word_of(product_bits(x, y)[:16]),
    "**": lambda x, y: word_of(product_bits(x, y)[16:]),
    "//": lambda x, y: divided(x, y)[1] if y else x,
    "/": lambda x, y: divided(x, y)[0] if y else 65535,
    "DIG": digit,
    "<<": lambda x, y: shifted(x, y, left=True),
    ">>": lambda x, y: shifted(x, y, left=False),
    ">=": lambda x, y: truth(not x < y),
    "<=": lambda x, y: truth(not y < x),
    "=": lambda x, y: truth(bits_of(x) == bits_of(y)),
    "<>": lambda x, y: truth(bits_of(x) != bits_of(y)),
    ">": lambda x, y: truth(x - y > 0),
    "<": lambda x, y: truth(y - x > 0),
}


@pytest.mark.parametrize("symbol", MODEL)
@settings(deadline=None)
@given(x=EITHER)
def test_an_operator_of_one_word(symbol: str, x: int) -> None:
    assert UNARY[CODES[symbol]](x) == MODEL[symbol](x)


@pytest.mark.parametrize("symbol", TWO)
@settings(deadline=None)
@given(x=EITHER, y=EITHER)
def test_an_operator_of_two_words(symbol: str, x: int, y: int) -> None:
    assert BINARY[CODES[symbol]](x, y) == TWO[symbol](x, y)


@settings(deadline=None)
@given(x=WORDS, y=st.integers(0, 16))
def test_rev_turns_the_low_bits_round_and_clears_the_rest(x: int, y: int) -> None:
    text = f"{x:016b}"[16 - y :]
    assert BINARY[0x19](x, y) == int(text[::-1] or "0", 2)


@settings(deadline=None)
@given(x=WORDS, y=st.integers(17, 65535))
def test_rev_of_more_than_16_bits_goes_on_with_zeros(x: int, y: int) -> None:
    turned = int(f"{x:016b}"[::-1], 2)
    assert BINARY[0x19](x, y) == (turned << min(y - 16, 16)) % 65536


@settings(deadline=None)
@given(x=EITHER, y=EITHER)
def test_hyp_and_atn_take_signed_bytes(x: int, y: int) -> None:
    a, b = signed_byte(x), signed_byte(y)
    assert BINARY[0x08](x, y) == isqrt(a * a + b * b)
    turn = BINARY[0x09](x, y)
    assert 0 <= turn < 256
    assert abs((turn * 360 / 256 - atan2(b, a) * 180 / 3.141592653589793 + 180) % 360 - 180) < 0.71


@pytest.mark.parametrize(
    ("x", "y", "turn"),
    [(1, 0, 0), (1, 1, 32), (0, 1, 64), (-1 & 0xFFFF, 0, 128), (0, -1 & 0xFFFF, 192), (0, 0, 0)],
)
def test_atn_counts_from_the_x_axis_against_the_clock(x: int, y: int, turn: int) -> None:
    assert BINARY[0x09](x, y) == turn


@pytest.mark.parametrize("operator", [0x06, 0x07])
def test_sine_and_cosine_stay_within_127(operator: int) -> None:
    values = {UNARY[operator](x) for x in range(256)}
    assert 127 in values
    assert (-127 & 0xFFFF) in values
    assert all(value <= 127 or value >= 65536 - 127 for value in values)


def test_what_the_manual_prints() -> None:
    """Ref: S2 p. 103 to 120, examples in the text."""
    assert BINARY[CODES["*/"]](100, 0x0180) == 150
    assert BINARY[CODES["**"]](65535, 65535) == 65534
    assert BINARY[CODES["DIG"]](9742, 2) == 7
    assert BINARY[CODES["//"]](1000, 300) == 100
    assert UNARY[CODES["DCD x"]](12) == 0b0001_0000_0000_0000
    assert UNARY[CODES["NCD x"]](0b1101) == 4
    assert UNARY[CODES["SQR x"]](100) == 10


def test_all_words_have_a_successor_of_their_own_under_random() -> None:
    seen, word = set(), 0
    while word not in seen:
        seen.add(word)
        word = next_random(word)
    assert len(seen) == 65535
    assert word == 0


def test_every_choice_can_be_turned() -> None:
    other = replace(
        CHOICES,
        quotient_by_zero=7,
        remainder_by_zero=8,
        wide_shift=Wide.WRAPS,
        wide_digit=Wide.WRAPS,
        wide_reverse=Wide.WRAPS,
        wide_decode=Wide.GOES_ON,
        root=Rounding.NEAREST,
        sine=Rounding.DOWN,
        angle=Rounding.DOWN,
        true_word=1,
        random_inverts=False,
    )
    one, two = unary_operators(other), binary_operators(other)
    assert two[CODES["/"]](5, 0) == 7
    assert two[CODES["//"]](5, 0) == 8
    assert two[CODES["<<"]](5, 17) == 10
    assert two[CODES[">>"]](5, 17) == 2
    assert two[CODES["DIG"]](321, 6) == 2
    assert two[CODES["REV"]](0b110, 19) == 0b011
    assert [one[CODES["DCD x"]](bit) for bit in (0, 3, 15, 16)] == [1, 8, 1 << 15, 0]
    assert [two[CODES[">>"]](0x8421, by) for by in (0, 15, 16, 20)] == [0x8421, 1, 0x8421, 0x842]
    assert one[CODES["SQR x"]](8) == 3
    assert two[CODES["HYP"]](2, 2) == 3
    assert one[CODES["SIN x"]](1) == 3  # 3.116..; and 3 is the nearest, too
    assert one[CODES["SIN x"]](2) == 6  # 6.23
    assert one[CODES["COS x"]](10) == 123  # 123.19
    assert one[CODES["SIN x"]](5) == 15  # 15.54: the nearest is 16
    assert UNARY[CODES["SIN x"]](5) == 16
    assert two[CODES["ATN"]](3, 2) == 23  # 23.97
    assert BINARY[CODES["ATN"]](3, 2) == 24
    assert two[CODES["="]](4, 4) == 1
    assert next_random(0, other) == 0


def test_the_table_has_every_operator() -> None:
    assert {*UNARY, *BINARY} == {row.code for row in OPERATORS}
