"""Expressions of the stack machine, evaluated on a register file."""

from cgagen.emulator.arithmetic import binary_operators, unary_operators
from cgagen.emulator.registers import FIRST_VARIABLE, Registers
from cgagen.emulator.timing import Timing
from cgagen.emulator.unknowns import Unknowns
from cgagen.stamp.bits import ELEMENT_BITS
from cgagen.stamp.program import Expression, Kind, Token


class Evaluator:
    """Evaluates expressions for one chip.

    Args:
        registers: read and written.
        unknowns: what operators do where no document says it.
    """

    __slots__ = ("_binary", "_registers", "_unary")

    def __init__(self, registers: Registers, unknowns: Unknowns) -> None:
        self._registers = registers
        self._unary = unary_operators(unknowns)
        self._binary = binary_operators(unknowns)

    def value(self, expression: Expression) -> int:
        """Return the word that an expression leaves."""
        if len(expression) == 1 and expression[0].kind is Kind.CONSTANT:
            return expression[0].value
        return self._run(expression, [])

    def values(self, expressions: tuple[Expression, ...]) -> tuple[int, ...]:
        """Return the words of several, evaluated in their order."""
        return tuple(self.value(expression) for expression in expressions)

    def store(self, expression: Expression, value: int) -> None:
        """Give a value to a write expression."""
        self._run(expression, [value])

    def _run(self, expression: Expression, stack: list[int]) -> int:
        registers = self._registers
        for kind, value, size_bits, indexed in expression:
            if kind == Kind.CONSTANT:
                stack.append(value)
            elif kind == Kind.OPERATOR:
                right = stack.pop()
                if value < 0x08:
                    stack.append(self._unary[value](right))
                else:
                    stack.append(self._binary[value](stack.pop(), right))
            else:
                element = value + stack.pop() if indexed else value
                if kind == Kind.READ:
                    stack.append(registers.read(size_bits, element))
                else:
                    registers.write(size_bits, element, stack.pop())
        return stack.pop() if stack else 0


def token_bits(token: Token) -> int:
    """Return how many bits a token has in the stream, as the tokenizer writes it. Ref: S3.

    >>> token_bits(Token(Kind.CONSTANT, 1000)), token_bits(Token(Kind.READ, 3, 16))
    (16, 10)
    """
    if token.kind is Kind.OPERATOR:
        return 6
    if token.kind is Kind.CONSTANT:
        width = token.value.bit_length() - 1  # of a power of 2 it is not needed
        return 7 + (width if token.value & token.value - 1 else 0)
    return 6 + ELEMENT_BITS[token.size_bits]


def expression_bits(expression: Expression) -> int:
    """Return how many bits it has, with the bit before each token that announces it."""
    return sum(token_bits(token) + 1 for token in expression)


def operators_ns(expressions: tuple[Expression, ...], timing: Timing) -> int:
    """Return what the operators in some expressions take."""
    return sum(
        timing.operator_ns(token.value)
        for expression in expressions
        for token in expression
        if token.kind is Kind.OPERATOR
    )


def depends_on_pins(token: Token) -> bool:
    """Return whether an access may read INS, or write INS, OUTS or DIRS.

    One with an index may reach anything.
    """
    word = token.value * token.size_bits >> 4
    return token.indexed or word == 0 or (token.kind is Kind.WRITE and word < FIRST_VARIABLE)
