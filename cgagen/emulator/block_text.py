"""Expressions of the stack machine as Python text, for `cgagen.emulator.blocks`.

In the text, `r` is the list of register words, `p` the chip's pins and `m` the machine.
"""

from dataclasses import dataclass

from cgagen.emulator.arithmetic import binary_operators, unary_operators
from cgagen.emulator.registers import ELEMENTS, FIRST_VARIABLE, INS, OUTS
from cgagen.emulator.unknowns import Unknowns
from cgagen.stamp.program import Expression, Kind, Token

WORD = 0xFFFF
TRUE = 0xFFFF

_COMPARISONS = {0x1A: ">=", 0x1B: "<=", 0x1C: "==", 0x1D: "!=", 0x1E: ">", 0x1F: "<"}
_NOT, _NEGATE = 0x02, 0x03
_AND, _OR, _XOR, _LEAST, _MOST = range(0x0A, 0x0F)
_ADD, _SUBTRACT, _MIDDLE, _MULTIPLY, _HIGH, _REMAINDER, _DIVIDE = range(0x0F, 0x16)
_LEFT, _RIGHT = 0x17, 0x18
_LOGIC = {_AND: "&", _OR: "|", _XOR: "^"}


@dataclass(frozen=True, slots=True)
class Text:
    """The text of one value.

    Attributes:
        code: a Python expression in brackets, or a name, or a number.
        top: no value is greater.
        raw: the same without the last cut to 16 bits; "" where there is none.
        flag: the code is true or false: a comparison that leaves 65,535 or 0.
        constant: the value where it is known.
        bits: for one bit of a register, the text that is 0 where the bit is 0.
    """

    code: str
    top: int = WORD
    raw: str = ""
    flag: bool = False
    constant: int | None = None
    bits: str = ""

    @property
    def word(self) -> str:
        """The value as a number."""
        return f"({TRUE} if {self.code} else 0)" if self.flag else self.code

    @property
    def loose(self) -> str:
        """The value as a number of which only the low 16 bits are right."""
        return self.raw or self.word

    @property
    def truth(self) -> str:
        """Something that Python takes for true where the value is not 0."""
        return self.bits or self.code


def number(value: int) -> Text:
    """Return the text of a constant."""
    return Text(str(value), value, constant=value)


class Writer:
    """Writes the statements of one function.

    Args:
        unknowns: what operators do where no document says it.

    Attributes:
        names: what the text needs besides `r` and `m`, for its globals.
    """

    def __init__(self, unknowns: Unknowns) -> None:
        self.lines: list[str] = []
        self.names: dict[str, object] = {}
        self.depth = 1
        self.leave = ""
        self._unary = unary_operators(unknowns)
        self._binary = binary_operators(unknowns)
        self._flags = unknowns.true_word == TRUE
        self._count = 0

    def line(self, text: str) -> None:
        """Write a statement."""
        self.lines.append("    " * self.depth + text)

    def name(self, prefix: str) -> str:
        """Return a name that is not in use."""
        self._count += 1
        return f"{prefix}{self._count}"

    def value(self, expression: Expression) -> Text:
        """Return an expression's value; statements that it needs first are written."""
        return self._pushed(expression, [])[-1]

    def store(self, expression: Expression, value: Text) -> None:
        """Write the store of a value that a name or number holds."""
        token = expression[-1]
        mask = (1 << token.size_bits) - 1
        if token.indexed:
            index = self._pushed(expression[:-1], [])[-1]
            if index.constant is None:
                self._store_indexed(token, index, value, mask)
                return
            token = token._replace(value=token.value + index.constant)
        place = token.value * token.size_bits
        shift, index_of_word = place & 15, place >> 4 & 15
        if index_of_word == INS:
            self.line("pass")
            return
        target = f"r[{index_of_word}]"
        if index_of_word == OUTS:
            target = "p.latch"
            self.line(f"if p.directions & {mask << shift}: {self.leave}")
        elif index_of_word < FIRST_VARIABLE:
            self.line(self.leave)
        self.line(f"{target} = {_inserted(target, value, mask, shift)}")

    def _store_indexed(self, token: Token, index: Text, value: Text, mask: int) -> None:
        name = self._element(token, index)
        if token.size_bits == 16:
            self.line(f"r[{name}] = {_cut(value, mask)}")
            return
        word, shift = _place(name, token.size_bits)
        self.line(f"{name}, s = {word}, {shift}")
        self.line(f"r[{name}] = r[{name}] & ({mask} << s ^ {WORD}) | ({_cut(value, mask)}) << s")

    def _pushed(self, expression: Expression, stack: list[Text]) -> list[Text]:
        for token in expression:
            if token.kind is Kind.CONSTANT:
                stack.append(number(token.value))
            elif token.kind is Kind.READ:
                stack.append(self._read(token, stack.pop() if token.indexed else number(0)))
            elif token.value < 0x08:
                stack.append(self._unary_text(token.value, stack.pop()))
            else:
                right = stack.pop()
                stack.append(self._binary_text(token.value, stack.pop(), right))
        return stack

    def _read(self, token: Token, index: Text) -> Text:
        size, mask = token.size_bits, (1 << token.size_bits) - 1
        if index.constant is None:
            name = self._element(token, index)
            if size == 16:
                return self.kept(f"r[{name}]", mask)
            word, shift = _place(name, size)
            return self.kept(f"r[{word}] >> ({shift}) & {mask}", mask)
        place = (token.value + index.constant) * size
        word_index, shift_bits = place >> 4 & 15, place & 15
        if word_index == INS:
            self.line(self.leave)
        word = ("0", "p.latch", "p.directions")[word_index] if word_index < 3 else ""
        return _part(word or f"r[{word_index}]", shift_bits, size)

    def kept(self, code: str, top: int) -> Text:
        """Write a value into a name now, for names in its code are used again; returns that."""
        name = self.name("v")
        self.line(f"{name} = {code}")
        return Text(name, top)

    def _element(self, token: Token, index: Text) -> str:
        """Write the element's number into a name; leave where it is one of the pins."""
        elements = ELEMENTS[token.size_bits]
        first = FIRST_VARIABLE * 16 // token.size_bits
        name = self.name("i")
        if token.value >= first and token.value + index.top < elements:
            self.line(f"{name} = {token.value} + {index.word}")
            return name
        self.line(f"{name} = {token.value} + {index.loose} & {elements - 1}")
        self.line(f"if {name} < {first}: {self.leave}")
        return name

    def _unary_text(self, code: int, x: Text) -> Text:
        function = self._unary[code]
        if x.constant is not None:
            return number(function(x.constant))
        if code == _NOT:
            return Text(f"(not {x.code})", flag=True) if x.flag else Text(f"({x.word} ^ {WORD})")
        if code == _NEGATE:
            return Text(f"(-{x.loose} & {WORD})", raw=f"(-{x.loose})")
        name = f"u{code}"
        self.names[name] = function
        return Text(f"{name}({x.word})")

    def _binary_text(self, code: int, x: Text, y: Text) -> Text:
        if x.constant is not None and y.constant is not None:
            return number(self._binary[code](x.constant, y.constant))
        if code in _COMPARISONS and self._flags:
            return _comparison(code, x, y)
        if code in _LOGIC:
            return _logic(code, x, y)
        simple = _simple(code, x, y)
        if simple is not None:
            return simple
        name = f"b{code}"
        self.names[name] = self._binary[code]
        return Text(f"{name}({x.word}, {y.word})")


def _cut(value: Text, mask: int) -> str:
    return value.word if value.top <= mask else f"{value.loose} & {mask}"


def _inserted(target: str, value: Text, mask: int, shift: int) -> str:
    """Return a word's text with some of its bits replaced."""
    if mask == WORD:
        return value.word if value.top <= WORD and not value.raw else f"{value.loose} & {WORD}"
    others = mask << shift ^ WORD
    if value.constant is not None:
        bits = (value.constant & mask) << shift
        if bits == mask << shift:
            return f"{target} | {bits}"
        return f"{target} & {others} | {bits}" if bits else f"{target} & {others}"
    cut = _cut(value, mask)
    moved = f"({cut}) << {shift}" if shift else f"({cut})"
    return f"{target} & {others} | {moved}"


def _part(word: str, shift: int, size: int) -> Text:
    """Return some bits of a word."""
    mask = (1 << size) - 1
    if size == 16:
        return Text(word)
    bits = f"({word} & {mask << shift})"
    if shift == 0:
        return Text(bits, mask, bits=bits)
    if shift + size == 16:
        return Text(f"({word} >> {shift})", mask, bits=bits)
    return Text(f"({word} >> {shift} & {mask})", mask, bits=bits)


def _place(name: str, size: int) -> tuple[str, str]:
    """Return the word of an element and its place in there, from its number."""
    per_word = 16 // size
    low, width = per_word.bit_length() - 1, size.bit_length() - 1
    shift = f"({name} & {per_word - 1}) << {width}" if width else f"{name} & {per_word - 1}"
    return f"{name} >> {low}", shift


def _comparison(code: int, x: Text, y: Text) -> Text:
    if x.top == 1 and x.bits and y.constant in (0, 1) and code in (0x1C, 0x1D):
        wanted = (y.constant == 1) == (code == 0x1C)
        return Text(x.bits if wanted else f"(not {x.bits})", flag=True)
    return Text(f"({x.word} {_COMPARISONS[code]} {y.word})", flag=True)


def _logic(code: int, x: Text, y: Text) -> Text:
    if x.flag and y.flag:
        if code == _XOR:
            return Text(f"((not {x.code}) != (not {y.code}))", flag=True)
        return Text(f"({x.code} {'and' if code == _AND else 'or'} {y.code})", flag=True)
    sign = _LOGIC[code]
    if code == _AND:
        return Text(f"({x.word} & {y.word})", min(x.top, y.top))
    top = (1 << max(x.top, y.top).bit_length()) - 1
    return Text(f"({x.word} {sign} {y.word})", top)


def _simple(code: int, x: Text, y: Text) -> Text | None:
    """Return the text of an operator that Python has, too."""
    a, b = x.word, y.word
    by = y.constant
    if code == _ADD:
        raw = f"({x.loose} + {y.loose})"
        fits = x.top + y.top <= WORD and not x.raw and not y.raw
        return Text(raw, x.top + y.top) if fits else Text(f"({raw} & {WORD})", raw=raw)
    if code == _SUBTRACT:
        raw = f"({x.loose} - {y.loose})"
        return Text(f"({raw} & {WORD})", raw=raw)
    if code == _MULTIPLY:
        fits = x.top * y.top <= WORD
        return Text(f"({a} * {b})", x.top * y.top) if fits else Text(f"({a} * {b} & {WORD})")
    if code == _MIDDLE:
        return Text(f"({a} * {b} >> 8 & {WORD})")
    if code == _HIGH:
        return Text(f"({a} * {b} >> 16)")
    if code in (_DIVIDE, _REMAINDER) and by:
        if code == _DIVIDE:
            return Text(f"({a} // {by})", x.top // by)
        return Text(f"({a} % {by})", min(x.top, by - 1))
    if code == _LEFT and by is not None and by < 16:
        fits = x.top << by <= WORD
        return Text(f"({a} << {by})", x.top << by) if fits else Text(f"({a} << {by} & {WORD})")
    if code == _RIGHT and by is not None and by < 16:
        return Text(f"({a} >> {by})", x.top >> by)
    if code in (_LEAST, _MOST):
        sign = ">" if code == _LEAST else "<"
        top = max(x.top, y.top) if code == _LEAST else min(x.top, y.top)
        return Text(f"({a} if {a} {sign} {b} else {b})", top)
    return None
