"""The grammar of the stream: expressions on a stack of eight words, lists, tails of instructions.

Ref: S3.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from cgagen.stamp.bits import BitReader, refused
from cgagen.stamp.opcodes import Tail
from cgagen.stamp.program import Expression, Item, Kind, Token, constant_of

STACK_WORDS = 8
"""Words that an expression may have on the stack. Ref: S3, the tokenizer's error 144."""

NUMBER_BIT = 0x100
"""Set in a formatter word: the item is a number as text. Ref: S3."""

_COMPARISONS = range(2, 8)
_FIRST_COMPARISON = 0x18


class Stack:
    """What lies on the stack, each word as the expression that computes it."""

    __slots__ = ("values", "write")

    def __init__(self) -> None:
        self.values: list[Expression] = []
        self.write: Expression | None = None

    def push(self, token: Token, bit: int, stored: bool) -> None:
        """Execute one token with expressions in place of numbers.

        Args:
            token: what comes next.
            bit: where it is, for messages.
            stored: the value that a write stores lies below this stack, not on it.

        Raises:
            ImageError: too few words, too many, or something after a write.
        """
        if self.write is not None:
            raise refused(bit, "an expression goes on after it has stored its value")
        if token.kind is Kind.WRITE:
            self.write = (*self._pop(int(token.indexed), bit), token)
            if stored and self.values:
                raise refused(bit, "values are left on the stack where one is stored")
            return
        needed = int(token.indexed)
        if token.kind is Kind.OPERATOR:
            needed = 1 if token.value < 0x08 else 2
        self.values.append((*self._pop(needed, bit), token) if needed else (token,))
        if len(self.values) > STACK_WORDS:
            raise refused(bit, f"an expression needs more than the {STACK_WORDS} words of stack")

    def _pop(self, count: int, bit: int) -> Expression:
        if len(self.values) < count:
            raise refused(bit, "an operator lacks its operand")
        first = len(self.values) - count
        popped = tuple(token for value in self.values[first:] for token in value)
        del self.values[first:]
        return popped


@dataclass(slots=True)
class Parts:
    """What the tail of an instruction has brought so far."""

    items: list[Item] = field(default_factory=list)
    write: Expression | None = None
    targets: list[int] = field(default_factory=list)
    number: int = 0
    comparison: int = 0


def read_tail(reader: BitReader, tail: tuple[Tail, ...]) -> Parts:
    """Read everything that follows an instruction's code.

    Raises:
        ImageError: it is not what the instruction has.
    """
    parts = Parts()
    for part in tail:
        _PARTS[part](reader, parts)
    return parts


def _address(reader: BitReader, parts: Parts) -> None:
    parts.targets.append(reader.address())


def _addresses(reader: BitReader, parts: Parts) -> None:
    parts.targets.extend(reader.address() for _ in _list(reader))


def _number(reader: BitReader, parts: Parts) -> None:
    parts.number = reader.take(8)


def _next_bit(reader: BitReader, _parts: Parts) -> None:
    here = reader.position
    address = reader.address()
    if address != reader.position:
        raise refused(here, f"the address of the next bit reads {address}")


def _comparison(reader: BitReader, parts: Parts) -> None:
    here = reader.position
    field_value = reader.take(3)
    if field_value not in _COMPARISONS:
        raise refused(here, f"LOOKDOWN has no comparison {field_value}")
    parts.comparison = _FIRST_COMPARISON + field_value


def _write(reader: BitReader, parts: Parts) -> None:
    parts.write = _write_expression(reader)


def _step(reader: BitReader, parts: Parts) -> None:
    parts.items.append(_values(reader, 2, 2))


def _value_list(reader: BitReader, parts: Parts) -> None:
    parts.items.extend(_values(reader, 1, 1) for _ in _list(reader))


def _pair_list(reader: BitReader, parts: Parts) -> None:
    parts.items.extend(_values(reader, 2, 2) for _ in _list(reader))


def _output_list(reader: BitReader, parts: Parts) -> None:
    parts.items.extend(_values(reader, 1, 3) for _ in _list(reader))


def _shifted_list(reader: BitReader, parts: Parts) -> None:
    for _ in _list(reader):
        item = _values(reader, 2, 2)
        parts.items.append(Item(item.values, _write_expression(reader)))


def _input_list(reader: BitReader, parts: Parts) -> None:
    for _ in _list(reader):
        here = reader.position
        stack = Stack()
        while reader.flag():
            bit = reader.position
            stack.push(reader.token(), bit, stored=False)
        if stack.write is not None:
            raise refused(here, "an input item stores a value before there is one")
        values = tuple(stack.values)
        first = constant_of(values[0]) if len(values) == 2 else None
        written = not values or (first is not None and first & NUMBER_BIT != 0)
        parts.items.append(Item(values, _write_expression(reader) if written else None))


_PARTS: dict[Tail, Callable[[BitReader, Parts], None]] = {
    Tail.ADDRESS: _address,
    Tail.ADDRESSES: _addresses,
    Tail.NUMBER: _number,
    Tail.NEXT_BIT: _next_bit,
    Tail.WRITE: _write,
    Tail.COMPARISON: _comparison,
    Tail.STEP: _step,
    Tail.VALUES: _value_list,
    Tail.PAIRS: _pair_list,
    Tail.OUTPUT: _output_list,
    Tail.INPUT: _input_list,
    Tail.SHIFTED: _shifted_list,
}


def _list(reader: BitReader) -> Iterator[None]:
    """Stop once for every item of a list; a bit behind each says whether another comes."""
    yield None
    while reader.flag():
        yield None


def _values(reader: BitReader, fewest: int, most: int) -> Item:
    """Read an expression that leaves some values."""
    here = reader.position
    stack = _expression(reader, stored=False)
    if stack.write is not None:
        raise refused(here, "a value is stored where one is wanted")
    if not fewest <= len(stack.values) <= most:
        raise refused(here, f"a list item leaves {len(stack.values)} values")
    return Item(tuple(stack.values))


def _write_expression(reader: BitReader) -> Expression:
    """Read an expression that stores the value an instruction makes."""
    here = reader.position
    stack = _expression(reader, stored=True)
    if stack.write is None:
        raise refused(here, "a value is not stored where the instruction makes one")
    return stack.write


def _expression(reader: BitReader, stored: bool) -> Stack:
    stack = Stack()
    more = True
    while more:
        here = reader.position
        stack.push(reader.token(), here, stored)
        more = reader.flag()
    return stack
