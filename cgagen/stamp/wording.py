"""Variables and expressions in PBASIC's words, so that the tokenizer makes the same tokens.

PBASIC works strictly from left to right, so the left operand of an operator needs no
parentheses and the right one does where it is an operation itself. Ref: S2 p. 103.
"""

from cgagen.stamp.opcodes import OPERATORS, Operator
from cgagen.stamp.program import Expression, Kind

IO_BYTES = 6
"""Bytes of INS, OUTS and DIRS in front of B0. Ref: S2 p. 82, 83."""

_IO = ("IN", "OUT", "DIR")
_OPERATORS = {row.code: row for row in OPERATORS}
_FIRST_COMPARISON = 0x1A


def variable(element: int, size_bits: int) -> str:
    """Return the fixed name of a variable.

    Args:
        element: its number, counted in its size from bit 0 of INS.
        size_bits: 1, 4, 8 or 16.

    >>> variable(6, 8), variable(12, 4), variable(77, 1), variable(17, 1), variable(1, 16)
    ('B0', 'B0.NIB0', 'B3.BIT5', 'OUT1', 'OUTS')
    """
    byte, rest = divmod(element * size_bits, 8)
    if byte < IO_BYTES:
        name = _IO[byte // 2]
        ending = {16: "S", 8: "LH"[byte % 2], 4: "ABCD"[element % 4], 1: str(element % 16)}
        return name + ending[size_bits]
    if size_bits == 16:
        return f"W{element - IO_BYTES // 2}"
    part = {8: "", 4: f".NIB{rest // 4}", 1: f".BIT{rest}"}
    return f"B{byte - IO_BYTES}{part[size_bits]}"


def expression_text(expression: Expression) -> str:
    """Return an expression that reads, as an assignment has it.

    >>> from cgagen.stamp.program import Token
    >>> b0, one = Token(Kind.READ, 6, 8), Token(Kind.CONSTANT, 1)
    >>> expression_text((b0, b0, one, Token(Kind.OPERATOR, 0x0F), Token(Kind.OPERATOR, 0x12)))
    'B0 * (B0 + 1)'
    """
    return _text(expression)[0]


def operand_text(expression: Expression) -> str:
    """Return the same in parentheses where it is more than a number or a variable."""
    text, simple, _ = _text(expression)
    return text if simple else f"({text})"


def write_text(expression: Expression) -> str:
    """Return the variable that a write expression stores to, with its index."""
    *index, token = expression
    name = variable(token.value, token.size_bits)
    return f"{name}({expression_text(tuple(index))})" if token.indexed else name


def operator_text(code: int) -> str:
    """Return an operator's symbol."""
    return _OPERATORS[code].symbol


def read_by(write: Expression) -> Expression:
    """Return the expression that reads what a write expression stores."""
    *index, token = write
    return (*index, token._replace(kind=Kind.READ))


def pin_of(read: Expression, write: Expression) -> int | None:
    """Return the pin whose PIN symbol names what is read and written; None where none does.

    One statement that reads and writes a PIN symbol reads IN and writes OUT. Ref: S3.
    """
    if len(read) != 1 or len(write) != 1 or read[0].size_bits != 1 or write[0].size_bits != 1:
        return None
    pin = read[0].value
    is_pin = read[0].kind is Kind.READ and pin < 16 and write[0].value == pin + 16
    return pin if is_pin and not (read[0].indexed or write[0].indexed) else None


def _text(expression: Expression) -> tuple[str, bool, bool]:
    """Return the words; whether they stand alone; whether they compare, so are a condition."""
    stack: list[tuple[str, bool, bool]] = []
    for token in expression:
        if token.kind is Kind.CONSTANT:
            stack.append((str(token.value), True, False))
        elif token.kind is Kind.READ:
            name = variable(token.value, token.size_bits)
            stack.append((f"{name}({stack.pop()[0]})" if token.indexed else name, True, False))
        else:
            row = _OPERATORS[token.value]
            stack.append(_unary(row, stack.pop()) if row.operands == 1 else _binary(row, stack))
    return stack[-1]


def _unary(row: Operator, operand: tuple[str, bool, bool]) -> tuple[str, bool, bool]:
    text, simple, compares = operand
    word = row.logical if compares and row.logical else row.symbol
    return f"{word} {text if simple else f'({text})'}", False, compares


def _binary(row: Operator, stack: list[tuple[str, bool, bool]]) -> tuple[str, bool, bool]:
    right, simple, right_compares = stack.pop()
    left, left_simple, left_compares = stack.pop()
    compares = left_compares or right_compares
    word = row.logical if compares and row.logical else row.symbol
    is_condition = compares or row.code >= _FIRST_COMPARISON
    if is_condition and not left_simple:
        left = f"({left})"  # in conditions, comparisons and AND bind each in its own way
    return f"{left} {word} {right if simple else f'({right})'}", False, is_condition
