"""The stack machine and what is asked about its tokens, at the borders between kinds."""

import pytest

from cgagen.emulator.expressions import Evaluator, depends_on_pins, expression_bits, token_bits
from cgagen.emulator.pins import Pins
from cgagen.emulator.registers import Registers
from cgagen.emulator.unknowns import CHOICES
from cgagen.stamp.decode import decode
from cgagen.stamp.program import Kind, Token
from cgagen.tokenizer import Tokenizer
from tests.chip_programs import chip_of


@pytest.mark.parametrize(
    ("kind", "element", "size_bits", "indexed", "depends"),
    [
        (Kind.READ, 0, 16, False, True),
        (Kind.READ, 15, 1, False, True),
        (Kind.READ, 3, 4, False, True),
        (Kind.READ, 1, 8, False, True),
        (Kind.READ, 16, 1, False, False),  # the latch is the chip's own
        (Kind.READ, 2, 8, False, False),
        (Kind.READ, 1, 16, False, False),
        (Kind.READ, 2, 16, False, False),
        (Kind.READ, 3, 16, False, False),
        (Kind.READ, 31, 8, False, False),
        (Kind.READ, 255, 1, False, False),
        (Kind.READ, 3, 16, True, True),  # an index may reach anything
        (Kind.WRITE, 0, 16, False, True),
        (Kind.WRITE, 16, 1, False, True),
        (Kind.WRITE, 5, 8, False, True),
        (Kind.WRITE, 47, 1, False, True),
        (Kind.WRITE, 2, 16, False, True),
        (Kind.WRITE, 48, 1, False, False),
        (Kind.WRITE, 6, 8, False, False),
        (Kind.WRITE, 3, 16, False, False),
        (Kind.WRITE, 12, 4, False, False),
        (Kind.WRITE, 63, 4, True, True),
    ],
)
def test_what_touches_pins(
    kind: Kind, element: int, size_bits: int, indexed: bool, depends: bool
) -> None:
    assert depends_on_pins(Token(kind, element, size_bits, indexed)) is depends


@pytest.mark.parametrize(
    ("operands", "code", "result"),
    [
        ((100,), 0x00, 10),  # SQR
        ((64,), 0x07, 127),  # SIN, the last of one operand
        ((3, 4), 0x08, 5),  # HYP, the first of two
        ((7, 9), 0x10, 65534),
        ((7, 9), 0x1F, 65535),
    ],
)
def test_operators_take_one_word_or_two(operands: tuple[int, ...], code: int, result: int) -> None:
    evaluator = Evaluator(Registers(Pins("chip")), CHOICES)
    words = tuple(Token(Kind.CONSTANT, word) for word in operands)
    assert evaluator.value((*words, Token(Kind.OPERATOR, code))) == result


def test_the_index_of_a_store_is_above_its_value() -> None:
    registers = Registers(Pins("chip"))
    evaluator = Evaluator(registers, CHOICES)
    evaluator.store((Token(Kind.CONSTANT, 3), Token(Kind.WRITE, 6, 8, True)), 0x1FF)
    assert (registers["B3"], registers["B2"], registers["B4"]) == (0xFF, 0, 0)
    assert evaluator.value((Token(Kind.CONSTANT, 2), Token(Kind.READ, 7, 8, True))) == 0xFF


@pytest.mark.parametrize(
    ("words", "token"),
    [
        *(
            (str(value), Token(Kind.CONSTANT, value))
            for value in (0, 1, 2, 3, 512, 513, 1000, 65535)
        ),
        ("bits", Token(Kind.READ, 0, 1)),
        ("nibs", Token(Kind.READ, 0, 4)),
        ("bytes", Token(Kind.READ, 0, 8)),
        ("words", Token(Kind.READ, 0, 16)),
    ],
)
def test_a_token_is_as_long_as_the_tokenizer_makes_it(
    tokenizer: Tokenizer, words: str, token: Token
) -> None:
    """One more of it, and one operator, with the bit before each."""

    def stop_at(expression: str) -> int:
        source = "bits VAR Bit\nnibs VAR Nib\nbytes VAR Byte\nwords VAR Word\nx VAR Word\n"
        made = chip_of(tokenizer, f"{source}x = {expression}\nSTOP")
        return decode(made.eeprom(), made.machine.model).instructions[1].address

    longer = stop_at(f"{words} + {words}") - stop_at(words)
    operator = Token(Kind.OPERATOR, 0x10)
    assert longer == expression_bits((token, operator)) == token_bits(token) + 8
