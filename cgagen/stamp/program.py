"""A decoded program: what the stream of bits says, as values that never change."""

from dataclasses import dataclass, field
from enum import IntEnum
from functools import cached_property
from typing import NamedTuple

from cgagen.stamp.chips import Chip
from cgagen.stamp.opcodes import Opcode

LABEL_BIT = 0x4000
"""Set in a constant that is an address: the label operands of SERIN and SEROUT. Ref: S3."""


class Kind(IntEnum):
    """What a token of an expression does on the stack of words."""

    OPERATOR = 0
    CONSTANT = 1
    READ = 2
    WRITE = 3


class Token(NamedTuple):
    """One token of an expression.

    Attributes:
        kind: what it does.
        value: the operator's code, the constant, or the element number of a variable: elements
            of one size count from bit 0 of INS, so that byte 6 and word 3 are B0 and W0.
        size_bits: of the variable, 1, 4, 8 or 16; 0 for anything else.
        indexed: the variable's index is popped first and added to the element number.
    """

    kind: Kind
    value: int
    size_bits: int = 0
    indexed: bool = False


Expression = tuple[Token, ...]
"""Postfix. One that reads leaves one word; a write expression ends in its only WRITE, which is
given the value to store from below whatever computes the index."""


class Item(NamedTuple):
    """One item of a list.

    Attributes:
        values: expressions in the order in which they are pushed; none for a plain input.
        write: where an input item goes; None where it goes nowhere.
    """

    values: tuple[Expression, ...]
    write: Expression | None = None


@dataclass(frozen=True, slots=True)
class Instruction:
    """One instruction with everything that belongs to it.

    Attributes:
        address: stream bit of its first token.
        end: the stream bit behind it; end - address bits are fetched.
        opcode: its row.
        operands: expressions in the order in which they are pushed. The value of LET is one.
        items: the list of the instruction. NEXT has one item: counter and step.
        write: where the value that the instruction makes is stored; None for most.
        targets: stream addresses that it can go on at: of its tail, or label operands.
        number: which GOSUB it is, from 1; 0 for anything else.
        comparison: operator code of LOOKDOWN; 0 for anything else.
    """

    address: int
    end: int
    opcode: Opcode
    operands: tuple[Expression, ...] = ()
    items: tuple[Item, ...] = ()
    write: Expression | None = None
    targets: tuple[int, ...] = ()
    number: int = 0
    comparison: int = 0

    @property
    def name(self) -> str:
        """Name of its row, "GOSUB" or "LET"."""
        return self.opcode.name

    @property
    def form(self) -> tuple[str, ...]:
        """Names of its operands, as many as there are."""
        return self.opcode.form_of(len(self.operands)) or ()

    def operand(self, name: str) -> Expression | None:
        """Return an operand by its name in the table of opcodes; None where it was left out."""
        form = self.form
        return self.operands[form.index(name)] if name in form else None


@dataclass(frozen=True)
class Program:
    """A whole program.

    Attributes:
        model: the chip that it was made for.
        start_bit: stream bit of the first instruction.
        gosub_slots: return address of GOSUB 1, 2, ...
        instructions: in the order of the stream, none left out; the last is the END that the
            tokenizer appends.
    """

    model: Chip
    start_bit: int
    gosub_slots: tuple[int, ...]
    instructions: tuple[Instruction, ...] = field(repr=False)

    @property
    def end_bit(self) -> int:
        """The stream bit behind the last instruction."""
        return self.instructions[-1].end

    @property
    def program_bytes(self) -> int:
        """EEPROM bytes from 2047 down that it takes, header included."""
        return -(-self.end_bit // 8)

    def at(self, address: int) -> Instruction | None:
        """Return the instruction that starts at a stream bit; None where none does."""
        return self._by_address.get(address)

    @cached_property
    def _by_address(self) -> dict[int, Instruction]:
        return {instruction.address: instruction for instruction in self.instructions}


def label_address(value: int) -> int | None:
    """Return the stream address that a label operand stands for; None for a plain number.

    >>> label_address(0x4000 | 5 << 11 | 15), label_address(1000)
    (125, None)
    """
    if not LABEL_BIT <= value < 2 * LABEL_BIT:
        return None
    return (value & 0x7FF) * 8 + (value >> 11 & 7)


def constant_of(expression: Expression) -> int | None:
    """Return the number that an expression is; None where it is not one constant alone."""
    if len(expression) == 1 and expression[0].kind is Kind.CONSTANT:
        return expression[0].value
    return None
