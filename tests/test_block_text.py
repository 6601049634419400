"""Expressions as Python text against the stack machine, on random ones at the edges of words."""

import random
from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace

import pytest

from cgagen.emulator.block_text import Text, Writer
from cgagen.emulator.expressions import Evaluator
from cgagen.emulator.pins import Pins
from cgagen.emulator.registers import ELEMENTS, FIRST_VARIABLE, Registers
from cgagen.emulator.unknowns import CHOICES
from cgagen.stamp.program import Expression, Kind, Token

LEFT = "left"
EDGES = (
    0, 1, 2, 3, 5, 7, 8, 15, 16, 17, 24, 31, 32, 63, 100, 127, 128, 255, 256, 257, 4095, 32767,
    32768, 32769, 65534, 65535,
)  # fmt: skip
COMPARISONS = range(0x1A, 0x20)
READ_FIRST = FIRST_VARIABLE * 16


def word(noise: random.Random) -> int:
    return noise.choice(EDGES) if noise.random() < 0.8 else noise.randrange(0x10000)


def access(noise: random.Random, kind: Kind, depth: int) -> Expression:
    """Return a read or write of a variable: its index, where it has one, comes before it."""
    size = noise.choice((1, 4, 8, 16))
    elements = ELEMENTS[size]
    first = READ_FIRST // size
    near_pins = noise.random() < 0.25
    element = noise.randrange(elements) if near_pins else noise.randrange(first, elements)
    if noise.random() < 0.65:
        return (Token(kind, element, size),)
    index = expression(noise, depth - 1) if noise.random() < 0.6 else small(noise)
    return (*index, Token(kind, element, size, True))


def small(noise: random.Random) -> Expression:
    """Return something that may be an index inside the file."""
    size = noise.choice((1, 4, 8))
    read = Token(Kind.READ, noise.randrange(READ_FIRST // size, ELEMENTS[size]), size)
    if noise.random() < 0.3:
        return (Token(Kind.CONSTANT, noise.choice((0, 1, 2, 3, 12, 13, 30, 200, 300))),)
    if noise.random() < 0.3:
        return (read, Token(Kind.CONSTANT, noise.choice((1, 3, 7, 15))), Token(Kind.OPERATOR, 0x0A))
    return (read,)


def expression(noise: random.Random, depth: int) -> Expression:
    pick = noise.random()
    if depth <= 0 or pick < 0.2:
        if noise.random() < 0.45:
            return (Token(Kind.CONSTANT, word(noise)),)
        return access(noise, Kind.READ, depth)
    if pick < 0.35:
        return (*expression(noise, depth - 1), Token(Kind.OPERATOR, noise.randrange(0x08)))
    operator = Token(Kind.OPERATOR, noise.randrange(0x08, 0x20))
    return (*expression(noise, depth - 1), *expression(noise, depth - 1), operator)


def condition(noise: random.Random) -> Expression:
    """Return comparisons joined by AND, OR, XOR and NOT, as IF has them."""
    parts: list[Token] = []
    for number in range(noise.randrange(1, 4)):
        one = access(noise, Kind.READ, 0) if noise.random() < 0.8 else expression(noise, 1)
        parts += one
        if noise.random() < 0.85:
            other = Token(Kind.CONSTANT, noise.choice((0, 1, 2, 255, 65535)))
            parts += (other, Token(Kind.OPERATOR, noise.choice(COMPARISONS)))
        if noise.random() < 0.3:
            parts.append(Token(Kind.OPERATOR, 0x02))
        if number:
            parts.append(Token(Kind.OPERATOR, noise.choice((0x0A, 0x0B, 0x0C))))
    return tuple(parts)


class Watched(Registers):
    """Registers that remember whether a pin was asked or told."""

    __slots__ = ("read_pins", "wrote_pins")

    def read(self, size_bits: int, element: int) -> int:
        self.read_pins |= {element * size_bits >> 4 & 15} & {0, 1, 2}
        return super().read(size_bits, element)

    def write(self, size_bits: int, element: int, value: int) -> None:
        self.wrote_pins |= {element * size_bits >> 4 & 15} & {0, 1, 2}
        super().write(size_bits, element, value)


def registers_of(noise: random.Random) -> Watched:
    registers = Watched(Pins("chip"))
    registers.read_pins, registers.wrote_pins = set(), set()
    registers.words[FIRST_VARIABLE:] = [word(noise) for _ in range(13)]
    registers.pins.set_latch(word(noise))
    registers.pins.set_directions(noise.choice((0, 0, 0x00FF, 0xFFFF)))
    return registers


def function_of(writer: Writer, result: str) -> Callable[..., object]:
    text = "\n".join([*writer.lines, f"    return {result}"])
    names = dict(writer.names)
    exec(f"def block(r, m):\n    p = m.pins\n{text}\n", names)
    return names["block"]  # type: ignore[return-value]


def writer_of() -> Writer:
    writer = Writer(CHOICES)
    writer.leave = f"return {LEFT!r}"
    return writer


def results(
    seed: int, part: Expression, write: Expression | None, truth: bool = False
) -> tuple[object, object, Watched, Watched]:
    """Evaluate an expression both ways, and store it where that is wanted."""
    writer = writer_of()
    text = writer.value(part)
    if write is not None:
        kept = text if text.constant is not None else _named(writer, text)
        writer.store(write, kept)
        text = Text("0")
    block = function_of(writer, text.truth if truth else text.word)
    mine, theirs = (registers_of(random.Random(seed)) for _ in range(2))
    machine = SimpleNamespace(pins=mine.pins)
    found = block(mine.words, machine)
    evaluator = Evaluator(theirs, CHOICES)
    wanted: object = evaluator.value(part)
    if write is not None:
        evaluator.store(write, wanted)  # type: ignore[arg-type]
        wanted = 0
    return found, wanted, mine, theirs


def _named(writer: Writer, text: Text) -> Text:
    """Return a value as instructions hand it to a store: sometimes raw, sometimes held."""
    return text if writer.lines and len(writer.lines) % 2 else writer.kept(text.word, text.top)


def state(registers: Registers) -> tuple[list[int], int, int]:
    return registers.words, registers.pins.latch, registers.pins.directions


@pytest.mark.parametrize("part", range(4))
def test_a_value_is_the_stack_machine_s(part: int) -> None:
    for seed in range(part * 900, part * 900 + 900):
        noise = random.Random(seed)
        made = expression(noise, 3)
        found, wanted, _, theirs = results(seed, made, None)
        if found == LEFT:
            assert theirs.read_pins, made
        else:
            assert found == wanted, made
            assert 0 not in theirs.read_pins, made


@pytest.mark.parametrize("part", range(4))
def test_a_condition_holds_where_the_stack_machine_leaves_no_0(part: int) -> None:
    for seed in range(part * 600, part * 600 + 600):
        made = condition(random.Random(seed))
        found, wanted, _, _ = results(seed, made, None, truth=True)
        assert found == LEFT or bool(found) == bool(wanted), made


@pytest.mark.parametrize("part", range(4))
def test_a_store_changes_what_the_stack_machine_changes(part: int) -> None:
    for seed in range(part * 900, part * 900 + 900):
        noise = random.Random(seed)
        made, write = expression(noise, 1), access(noise, Kind.WRITE, 1)
        found, _, mine, theirs = results(seed, made, write)
        if found != LEFT:
            assert state(mine) == state(theirs), (made, write)
            assert not (theirs.wrote_pins & {2}), (made, write)
            continue
        before = registers_of(random.Random(seed))
        assert state(mine) == state(before), (made, write)
        assert theirs.wrote_pins | theirs.read_pins, (made, write)


def test_hardly_anything_leaves() -> None:
    """What leaves is carried out slowly; variables alone must never do it."""
    left = 0
    for seed in range(400):
        noise = random.Random(seed)
        made = (
            Token(Kind.READ, noise.randrange(6, 32), 8),
            Token(Kind.READ, noise.randrange(48, 200), 1),
            Token(Kind.OPERATOR, noise.randrange(0x0A, 0x20)),
        )
        write = (Token(Kind.READ, 7, 4), Token(Kind.WRITE, 12, 4, True))
        if noise.random() < 0.5:
            write = (Token(Kind.READ, 50, 1), Token(Kind.WRITE, noise.randrange(3, 15), 16, True))
        left += results(seed, made, write)[0] == LEFT
    assert left == 0


# -- What is written is no more than is needed: nothing but speed depends on it ----------------


def constant(value: int) -> Token:
    return Token(Kind.CONSTANT, value)


def operator(code: int) -> Token:
    return Token(Kind.OPERATOR, code)


W0, W1 = Token(Kind.READ, 3, 16), Token(Kind.READ, 4, 16)
B0, B1, NIB, BIT = (
    Token(Kind.READ, 6, 8),
    Token(Kind.READ, 7, 8),
    Token(Kind.READ, 13, 4),
    Token(Kind.READ, 50, 1),
)
B0_TEXT, NIB_TEXT = "(r[3] & 255)", "(r[3] >> 4 & 15)"


@pytest.mark.parametrize(
    ("made", "code", "top"),
    [
        ((W0,), "r[3]", 65535),
        ((B0,), "(r[3] & 255)", 255),
        ((B1,), "(r[3] >> 8)", 255),
        ((NIB,), "(r[3] >> 4 & 15)", 15),
        ((Token(Kind.READ, 15, 4),), "(r[3] >> 12)", 15),
        ((Token(Kind.READ, 63, 1),), "(r[3] >> 15)", 1),
        ((W0, W1, operator(0x0A)), "(r[3] & r[4])", 65535),
        ((B0, NIB, operator(0x0A)), f"({B0_TEXT} & {NIB_TEXT})", 15),
        ((B0, NIB, operator(0x0B)), f"({B0_TEXT} | {NIB_TEXT})", 255),
        ((BIT, constant(4), operator(0x0C)), "((r[3] >> 2 & 1) ^ 4)", 7),
        ((W0, constant(0x8000), operator(0x0B)), "(r[3] | 32768)", 65535),
        ((B0, constant(300), operator(0x0D)), f"({B0_TEXT} if {B0_TEXT} > 300 else 300)", 300),
        ((B0, constant(300), operator(0x0E)), f"({B0_TEXT} if {B0_TEXT} < 300 else 300)", 255),
        ((W0, W1, operator(0x0F)), "((r[3] + r[4]) & 65535)", 65535),
        ((B0, constant(65280), operator(0x0F)), f"({B0_TEXT} + 65280)", 65535),
        ((B0, constant(65281), operator(0x0F)), f"(({B0_TEXT} + 65281) & 65535)", 65535),
        ((W0, constant(1), operator(0x0F), constant(2), operator(0x10)),
         "(((r[3] + 1) - 2) & 65535)", 65535),
        ((B0, constant(257), operator(0x12)), f"({B0_TEXT} * 257)", 65535),
        ((B0, constant(258), operator(0x12)), f"({B0_TEXT} * 258 & 65535)", 65535),
        ((W0, W1, operator(0x11)), "(r[3] * r[4] >> 8 & 65535)", 65535),
        ((W0, W1, operator(0x13)), "(r[3] * r[4] >> 16)", 65535),
        ((W0, constant(10), operator(0x14)), "(r[3] % 10)", 9),
        ((W0, constant(10), operator(0x15)), "(r[3] // 10)", 6553),
        ((B0, constant(8), operator(0x17)), f"({B0_TEXT} << 8)", 65280),
        ((B0, constant(9), operator(0x17)), f"({B0_TEXT} << 9 & 65535)", 65535),
        ((BIT, constant(15), operator(0x17)), "((r[3] >> 2 & 1) << 15)", 32768),
        ((Token(Kind.READ, 12, 4), constant(12), operator(0x17)), "((r[3] & 15) << 12)", 61440),
        ((W0, constant(0), operator(0x17)), "(r[3] << 0)", 65535),
        ((W0, constant(15), operator(0x18)), "(r[3] >> 15)", 1),
        ((W0, operator(0x02)), "(r[3] ^ 65535)", 65535),
        ((W0, operator(0x03)), "(-r[3] & 65535)", 65535),
        ((BIT, constant(0), operator(0x1C)), "(not (r[3] & 4))", 65535),
        ((BIT, constant(1), operator(0x1C)), "(r[3] & 4)", 65535),
        ((BIT, constant(1), operator(0x1D)), "(not (r[3] & 4))", 65535),
        ((BIT, constant(0), operator(0x1D)), "(r[3] & 4)", 65535),
        *(
            ((W0, W1, operator(code)), f"(r[3] {sign} r[4])", 65535)
            for code, sign in zip(COMPARISONS, (">=", "<=", "==", "!=", ">", "<"), strict=True)
        ),
        ((W0, W1, operator(0x1C), operator(0x02)), "(not (r[3] == r[4]))", 65535),
        ((W0, W1, operator(0x1C), BIT, constant(1), operator(0x1C), operator(0x0A)),
         "((r[3] == r[4]) and (r[3] & 4))", 65535),
        ((constant(3), constant(4), operator(0x12)), "12", 12),
    ],
)  # fmt: skip
def test_common_operators_need_no_call(made: Expression, code: str, top: int) -> None:
    writer = writer_of()
    text = writer.value(made)
    assert (text.code, text.top, writer.names, writer.lines) == (code, top, {}, [])


@pytest.mark.parametrize(
    ("made", "code"),
    [
        ((W0, constant(16), operator(0x17)), "b23(r[3], 16)"),
        ((W0, constant(16), operator(0x18)), "b24(r[3], 16)"),
        ((W0, constant(0), operator(0x15)), "b21(r[3], 0)"),
        ((W0, W1, operator(0x14)), "b20(r[3], r[4])"),
        ((W0, operator(0x00)), "u0(r[3])"),
    ],
)
def test_what_the_documents_leave_open_is_the_table_s(made: Expression, code: str) -> None:
    writer = writer_of()
    assert writer.value(made).code == code
    assert [*writer.names] == [code.partition("(")[0]]


@pytest.mark.parametrize(
    ("index", "read", "lines"),
    [
        (NIB, Token(Kind.READ, 6, 8, True),
         ["i1 = 6 + (r[3] >> 4 & 15)", "v2 = r[i1 >> 1] >> ((i1 & 1) << 3) & 255"]),
        (BIT, Token(Kind.READ, 3, 16, True), ["i1 = 3 + (r[3] >> 2 & 1)", "v2 = r[i1]"]),
        (NIB, Token(Kind.READ, 48, 1, True),
         ["i1 = 48 + (r[3] >> 4 & 15)", "v2 = r[i1 >> 4] >> (i1 & 15) & 1"]),
        (NIB, Token(Kind.READ, 17, 8, True),
         ["i1 = 17 + (r[3] >> 4 & 15) & 31", f"if i1 < 6: return {LEFT!r}",
          "v2 = r[i1 >> 1] >> ((i1 & 1) << 3) & 255"]),
    ],
)  # fmt: skip
def test_an_index_that_stays_inside_is_not_looked_at(
    index: Token, read: Token, lines: list[str]
) -> None:
    writer = writer_of()
    assert writer.value((index, read)).code == "v2"
    assert [line.strip() for line in writer.lines] == lines


@pytest.mark.parametrize(
    ("made", "write", "line"),
    [
        ((W0,), Token(Kind.WRITE, 4, 16), "r[4] = r[3]"),
        ((B0,), Token(Kind.WRITE, 8, 8), "r[4] = r[4] & 65280 | ((r[3] & 255))"),
        ((W0,), Token(Kind.WRITE, 9, 8), "r[4] = r[4] & 255 | (r[3] & 255) << 8"),
        ((constant(3),), Token(Kind.WRITE, 9, 8), "r[4] = r[4] & 255 | 768"),
        ((constant(255),), Token(Kind.WRITE, 8, 8), "r[4] = r[4] | 255"),
        ((constant(256),), Token(Kind.WRITE, 8, 8), "r[4] = r[4] & 65280"),
        ((W0, constant(1), operator(0x0F)), Token(Kind.WRITE, 4, 16), "r[4] = (r[3] + 1) & 65535"),
        ((B0, constant(1), operator(0x0F)), Token(Kind.WRITE, 4, 16), "r[4] = ((r[3] & 255) + 1)"),
        ((W0,), Token(Kind.WRITE, 0, 16), "pass"),
        ((NIB, W1), Token(Kind.WRITE, 3, 16, True), "r[i1] = r[4]"),
    ],
)
def test_a_store_cuts_where_it_must(made: Expression, write: Token, line: str) -> None:
    writer = writer_of()
    index = made[:-1] if write.indexed else ()
    value = made[-1:] if write.indexed else made
    writer.store((*index, write), writer.value(value))
    assert writer.lines[-1].strip() == line


def test_a_latch_is_written_where_no_pin_of_it_is_an_output() -> None:
    writer = writer_of()
    writer.store((Token(Kind.WRITE, 6, 4),), writer.value((W0,)))
    assert [line.strip() for line in writer.lines] == [
        f"if p.directions & 3840: return {LEFT!r}",
        "p.latch = p.latch & 61695 | (r[3] & 15) << 8",
    ]


def test_another_word_for_true_is_left_to_the_table() -> None:
    writer = Writer(replace(CHOICES, true_word=1))
    assert writer.value((W0, W1, operator(0x1C))).code == "b28(r[3], r[4])"
    assert writer.names["b28"](7, 7) == 1  # type: ignore[operator]


def test_no_value_is_greater_than_it_says() -> None:
    for seed in range(1200):
        made = expression(random.Random(seed), 2)
        top = writer_of().value(made).top
        found, *_ = results(seed, made, None)
        assert found == LEFT or 0 <= found <= top, made  # type: ignore[operator]
