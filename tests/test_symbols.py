"""The names of a program: asked from the tokenizer, and found again in a chip that has run."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cgagen.emulator.chip import Chip
from cgagen.emulator.clock import Clock
from cgagen.emulator.programs import bench_of_image, bench_of_sources
from cgagen.errors import BenchError, SourceError, SymbolError
from cgagen.stamp.chips import CHIPS
from cgagen.stamp.compiled import Compiled
from cgagen.stamp.conditional import live_text
from cgagen.stamp.decode import decode
from cgagen.stamp.layout import Place, layout_of
from cgagen.stamp.symbols import symbols_of
from cgagen.tokenizer import Tokenizer
from cgagen.tokenizer.files import read_source
from tests.pbasic_random import RandomProgram

HERE = Path(__file__).parent
SECOND_NS = 1_000_000_000
HEAD = "' {$STAMP BS2}\n' {$PBASIC 2.5}\n"

Asked = tuple[int, int]


def asked(tokenizer: Tokenizer, source: str, name: str) -> Asked:
    """Return bits and number of a variable as the tokenizer has them: what READ stores into."""
    image = tokenizer.compile(f"{source}\nREAD 0, {name}\n").image
    reads = [
        one
        for one in decode(image.eeprom, image.model, image.flags).instructions
        if one.name == "READ"
    ]
    assert reads[-1].write is not None
    token = reads[-1].write[-1]
    return token.size_bits, token.value


def agree(tokenizer: Tokenizer, body: str, *names: str, model: str = "BS2") -> None:
    source = f"' {{$STAMP {model}}}\n' {{$PBASIC 2.5}}\n{body}\n"
    symbols = symbols_of(tokenizer.compile(source + "END\n"))
    for name in names:
        size_bits, element, _ = symbols.place(name)
        assert (size_bits, element) == asked(tokenizer, source, name), name


DECLARATIONS = [
    ("a VAR Bit\nb VAR Nib\nc VAR Byte\nd VAR Word\ne VAR Bit\nf VAR Word", "abcdef"),
    ("a VAR Bit(3)\nb VAR Nib(5)\nc VAR Byte(2)\nd VAR Word(4)\ne VAR Nib\nf VAR Bit", "abcdef"),
    ("x VAR Byte\na VAR Word\nb VAR a.LOWBYTE\nc VAR a.HIGHBYTE.BIT3\nd VAR a.BYTE1.NIB1", "abcd"),
    ("a VAR Word\nb VAR a.BYTE1.NIB1.HIGHBIT\nc VAR a.HIGHNIB\nd VAR a.BIT15\ne VAR d", "abcde"),
    ("a VAR Byte(3)\nb VAR a\nc VAR a.BIT7\nd VAR a.HIGHNIB", "abcd"),
    ("a VAR W3\nb VAR B3.BIT5\nc VAR OUTL.BIT2\nd VAR IN5\ne VAR DIRH\nf VAR INA", "abcdef"),
    ("n CON m * 2 + 1\nm CON 3\na VAR Byte(n)\nb VAR Byte", "ab"),
    ("n CON \"A\" - $3F : m CON %11 : a VAR Nib(m | n ^ 1) : b VAR Nib", "ab"),
    ("t DATA 1, 2\nu DATA 3\na VAR Byte(u)\nb VAR Byte", "ab"),
    ("a VAR Byte : b VAR Word ' c VAR Word\nHIGH 3 : c VAR Bit", "abc"),
    ("label: a VAR Byte\nDEBUG \"x VAR Word\"\nb VAR\tByte (2)\nc VAR byte", "abc"),
]  # fmt: skip


@pytest.mark.parametrize(("body", "names"), DECLARATIONS)
def test_variables_are_where_the_tokenizer_puts_them(
    tokenizer: Tokenizer, body: str, names: str
) -> None:
    agree(tokenizer, body, *names)


@pytest.mark.parametrize(
    "name",
    [
        "w.LOWBYTE", "w.HIGHBYTE", "w.BYTE0", "w.NIB2", "w.LOWNIB", "w.HIGHNIB", "w.LOWBIT",
        "w.HIGHBIT", "w.BIT9", "w.BYTE1.NIB1.BIT2", "b.NIB1", "b.HIGHBIT", "n.BIT2", "ro(0)",
        "ro(2)", "w(1)", "n(3)", "W4.BIT3", "B7", "OUTS", "DIRC", "INL.NIB1", "OUT15", "IN0", "INB",
    ],
)  # fmt: skip
def test_parts_and_elements(tokenizer: Tokenizer, name: str) -> None:
    body = "n VAR Nib\nb VAR Byte\nro VAR Byte(3)\nw VAR Word"
    found = symbols_of(tokenizer.compile(f"{HEAD}{body}\nEND\n")).place(name)
    token = asked(tokenizer, HEAD + body, name.partition("(")[0])
    index = int(name.partition("(")[2].rstrip(")") or 0)
    assert (found.size_bits, found.element) == (token[0], token[1] + index)


CONDITIONS = [
    "1", "0", "2 AND 1", "NOT 1", "NOT 0", "4 AND 1=0", "NOT 1 = 0", "2 = 2 + 3", "3 XOR 1 = 2",
    "1 OR 0 = 0 AND 0", "1 = 1 = 1", "2 + 3 * 4 = 20", "(2*3)+(4*5)=26", "-1 = 65535", "5 - 6 > 3",
    "$10 = 16", "%11 = 3", "\"A\" = 65", "7 / 2 = 3", "1 << 3 = 8", "1 | 0", "1 ^ 1", "a", "b", "c",
    "nothing", "nothing = 0", "a = 7 AND b > 100", "NOT (a = 7)", "NOT NOT a = 7", "1 >= 2",
    "2 => 1", "1 =< 1", "3 >< 3", "3 <> 4", "$STAMP = BS2", "$STAMP = BS2SX", "$STAMP >= BS2E",
    "($STAMP = BS2) OR ($STAMP = BS2PE)", "$PBASIC = 250", "$stamp = bs2p", "CR = 13",
]  # fmt: skip


@pytest.mark.parametrize("model", ["BS2", "BS2pe"])
def test_conditions_mean_what_they_mean_to_the_tokenizer(tokenizer: Tokenizer, model: str) -> None:
    for condition in CONDITIONS:
        body = (
            "#DEFINE a = 3 + 4\n#DEFINE b\n#DEFINE c = a - 7\n"
            f"#IF {condition} #THEN\nz VAR Word\n#ELSE\nz VAR Byte\n#ENDIF\ny VAR Bit"
        )
        agree(tokenizer, body, "z", "y", model=model)


@pytest.mark.parametrize(
    "body",
    [
        "#IF 0 #THEN\n#IF 1 #THEN\nz VAR Byte\n#ELSE\nz VAR Word\n#ENDIF\n#ELSE\nz VAR Nib\n#ENDIF",
        "#IF 1 #THEN\n#IF 0 #THEN\nz VAR Byte\n#ELSE\nz VAR Word\n#ENDIF\n#ELSE\nz VAR Nib\n#ENDIF",
        "#IF 0 #THEN z VAR Word : x VAR Byte #ELSE z VAR Byte : x VAR Word #ENDIF : w VAR Word",
        "#if 0 #then\nz VAR Word\n#else\nz VAR Byte\n#endif",
        "z VAR Byte ' #IF 0 #THEN\nDEBUG \"#IF 0 #THEN\"",
        "#DEFINE a : #DEFINE b = 2 ' x\n#IF b=2 #THEN ' y\nz VAR Word\n#ELSE\nz VAR Nib\n#ENDIF",
        "#IF 0 #THEN\n#DEFINE a\n#ERROR \"x\"\n#ENDIF\n#IF a #THEN\nz VAR Nib\n#ENDIF\nz VAR Bit",
        "#SELECT $STAMP\n#CASE BS2, BS2E\nz VAR Word\n#CASE #ELSE\nz VAR Byte\n#ENDSELECT",
        "#SELECT 3\n#CASE 1\nz VAR Word\n#CASE 1, 3\nz VAR Nib\n#CASE #ELSE\nz VAR Bit\n#ENDSELECT",
        "#SELECT 3\n#CASE < 2\nz VAR Word\n#CASE 3 TO 4\nz VAR Nib\n#CASE 3\nz VAR Bit\n#ENDSELECT",
        "#SELECT 3 + 1\n#CASE 2+2 : z VAR Word\n#CASE #ELSE\nz VAR Byte\n#ENDSELECT",
        "#SELECT 9\n#CASE 1\nz VAR Word\n#CASE #ELSE\nz VAR Byte\n#ENDSELECT : HIGH 3",
    ],
)  # fmt: skip
def test_branches_that_are_not_taken_define_nothing(tokenizer: Tokenizer, body: str) -> None:
    agree(tokenizer, body, "z")


def test_places_in_the_text_stay() -> None:
    source = "#IF 1 #THEN ' why\r\nHIGH 3\r\n#ELSE\r\nLOW 3 ' no\r\n#ENDIF\r\n"
    live = live_text(source)
    assert len(live) == len(source)
    assert live.index("HIGH") == source.index("HIGH")
    assert live.split() == ["HIGH", "3"]


# -- A program tells where its variables are ---------------------------------------------------

SIZES = {"Word": 16, "Byte": 8, "Nib": 4, "Bit": 1}
declarations = st.lists(
    st.tuples(st.sampled_from([*SIZES]), st.one_of(st.none(), st.integers(1, 4))),
    min_size=1,
    max_size=10,
)


@settings(max_examples=60, deadline=None)
@given(declarations=declarations, seed=st.integers(0, 0xFFFF))
def test_what_a_program_stores_is_read_back_by_name(
    tokenizer: Tokenizer, declarations: list[tuple[str, int | None]], seed: int
) -> None:
    """Random declarations; the program stores a number of its own into each element."""
    lines, stores, expected = [], [], {}
    room = 26 * 8
    for number, (size, length) in enumerate(declarations):
        room -= SIZES[size] * (length or 1)
        if room < 0:
            break
        name = f"v{number}"
        lines.append(f"{name} VAR {size}" + (f"({length})" if length else ""))
        for index in range(length or 1):
            value = (seed * 31 + number * 7919 + index * 104729) & (1 << SIZES[size]) - 1
            text = f"{name}({index})" if length else name
            stores.append(f"{text} = {value}")
            expected[text] = value
    chip = ran(tokenizer, "\n".join([*lines, *stores, "END"]))
    assert {name: chip.ram[name] for name in expected} == expected
    assert {*chip.ram} == {line.split()[0] for line in lines}
    assert len(chip.ram) == len(lines)
    for line in lines:
        name = line.split()[0]
        elements = [expected[key] for key in expected if key.partition("(")[0] == name]
        assert [*chip.ram.array(name)] == elements


def ran(tokenizer: Tokenizer, body: str, model: str = "BS2") -> Chip:
    source = f"' {{$STAMP {model}}}\n' {{$PBASIC 2.5}}\n{body}\n"
    chip = Chip("chip", [tokenizer.compile(source, "it.bs2")], Clock())
    chip.run(SECOND_NS)
    return chip


def test_pins_are_looked_at_without_a_trace(tokenizer: Tokenizer) -> None:
    floated: list[int] = []
    source = HEAD + "led PIN 3\nkey PIN 5\nold CON 7\nw VAR Word\nHIGH led\nLOW 4\nOUTPUT 6\nSTOP\n"
    chip = Chip("chip", [tokenizer.compile(source)], Clock(), floated=floated.append)
    chip.run(SECOND_NS)
    assert [chip.level(name) for name in ("led", "P4", "key", 6, "old")] == [1, 0, None, 0, None]
    assert (chip.ram["LED"], chip.ram["key"], chip.ram["OUT3"], chip.ram["DIRA"]) == (1, 0, 1, 8)
    assert (chip.ram["INS"], chip.ram["INL.BIT3"], chip.ram["DIRS"]) == (8, 1, 0b1011000)
    assert floated == []
    assert chip.pin_number("old") == 7


def test_a_pin_name_is_the_pin_that_the_tokenizer_means(tokenizer: Tokenizer) -> None:
    """It reads the bit of INS, and writes that of OUTS."""
    source = HEAD + "p PIN 3\nq PIN n + 2\nn CON 5\na VAR Word\n"
    symbols = symbols_of(tokenizer.compile(source + "END\n"))
    for name, pin in (("p", 3), ("q", 7)):
        assert asked(tokenizer, source, name) == (1, 16 + pin)
        assert (symbols.pin(name), symbols.place(name)) == (pin, Place(1, pin, 1))


def test_a_variable_can_be_set(tokenizer: Tokenizer) -> None:
    chip = ran(tokenizer, "w VAR Word\nr VAR Nib(3)\nPAUSE 5000\nw = w + 1\nEND")
    chip.ram["w"] = 65_536 + 300
    chip.ram["r(1)"], chip.ram["w.HIGHBYTE"] = 18, 2
    assert (chip.ram["w"], chip.ram.array("r")) == (2 * 256 + 44, (0, 2, 0))
    chip.run(10 * SECOND_NS)
    assert chip.ram["w"] == 2 * 256 + 45


def test_variables_can_be_had_all_at_once(tokenizer: Tokenizer) -> None:
    """An array is its first element, as in PBASIC; whatever can be asked for is there."""
    ram = ran(tokenizer, "p PIN 2\nw VAR Word\nr VAR Nib(3)\nw = 700\nr(0) = 5\nEND").ram
    assert dict(ram) == {"w": 700, "r": 5}
    assert [name in ram for name in ("W", "r(2)", "p", "B3", "nope", "w.NIB4", 3)] == [
        *(4 * [True]),
        *(3 * [False]),
    ]


def test_a_number_that_the_chip_does_not_have(tokenizer: Tokenizer) -> None:
    chip = ran(tokenizer, "END", "BS2p")
    for pin in (-1, 17, 99):
        with pytest.raises(ValueError, match=f"no pin {pin}; give 0 to 15, or 16 for SIN"):
            chip.level(pin)
    for slot in (-1, 8):
        with pytest.raises(ValueError, match=f"a BS2p has no slot {slot}; give 0 to 7"):
            chip.eeprom(slot)
    with pytest.raises(TypeError, match=r"1500000000\.0 is no whole number of nanoseconds"):
        chip.run(1.5e9)  # type: ignore[arg-type]
    assert (chip.level(16), len(chip.eeprom(7))) == (0, 2048)


def test_data_is_read_as_it_is_now(tokenizer: Tokenizer) -> None:
    chip = ran(
        tokenizer,
        "Free DATA (3)\n"
        "Row DATA 5, Word 300\n DATA 9\nText DATA \"a:b\", 0\nWRITE Row + 1, 77\nEND",
    )  # fmt: skip
    assert chip.data("row") == bytes([5, 77, 1, 9])
    assert chip.data("TEXT") == b"a:b\0"
    assert chip.data("free") == bytes(3)


def test_a_label_behind_everything_is_the_end(tokenizer: Tokenizer) -> None:
    compiled = tokenizer.compile(HEAD + "w VAR Word\nw = 1\nGOTO last\nw = 2\nlast:\n")
    chip = Chip("chip", [compiled], Clock())
    seen: list[int] = []
    chip.on_label("last", lambda chip: seen.append(chip.ram["w"]))
    chip.run(SECOND_NS)
    assert (seen, chip.ended) == ([1], "END")


def test_names_are_those_of_the_slot_that_runs(tokenizer: Tokenizer) -> None:
    head = "' {$STAMP BS2p}\n' {$PBASIC 2.5}\n"
    first = tokenizer.compile(head + "a VAR Word\nt DATA 1\na = 300\nPAUSE 100\nRUN 1\n", "a.bsp")
    other = tokenizer.compile(head + "b VAR Byte(2)\nt DATA 2, 3\nSTOP\n", "b.bsp")
    bench = bench_of_sources({0: first, 1: other})
    chip = bench.chip("main")
    bench.run(50_000_000)
    assert (bench.variable("main.a"), chip.variable("b", slot=1)) == (300, 44)
    bench.run(SECOND_NS)
    assert chip.slot == 1
    assert (chip.ram.array("b"), chip.variable("a", slot=0)) == ((44, 1), 300)
    assert (chip.data("t"), chip.data("t", slot=0)) == (b"\2\3", b"\1")


@pytest.mark.parametrize(
    ("what", "sentence"),
    [
        ("variable", r"it.bs2: no variable lapps; did you mean laps or "),
        ("pin", r"it.bs2: no pin leed; did you mean led"),
        ("data", r"it.bs2: no DATA label rwo; did you mean row\?"),
        ("label", r"it.bs2: no label agian; did you mean again\?"),
        ("far", r"it.bs2: no variable zzzz; there are .*laps.*"),
        ("part", r"it.bs2: no variable flag.BIT0"),
        ("line", r"no statement begins on line 1 of it.bs2; .* the nearest are 8 and 9"),
    ],
)
def test_what_is_not_there(tokenizer: Tokenizer, what: str, sentence: str) -> None:
    chip = ran(
        tokenizer,
        "led PIN 1\nlaps VAR Byte\nlapses VAR Byte\nflag VAR Bit\nrow DATA 1\nagain: laps = 1\nEND",
    )
    looks: dict[str, Callable[[], object]] = {
        "variable": lambda: chip.ram["lapps"],
        "pin": lambda: chip.level("leed"),
        "data": lambda: chip.data("rwo"),
        "label": lambda: chip.on_label("agian", lambda chip: None),
        "far": lambda: chip.variable("zzzz"),
        "part": lambda: chip.ram["flag.BIT0"],
        "line": lambda: chip.on_line(1, lambda chip: None),
    }
    with pytest.raises((SymbolError, BenchError), match=sentence):
        looks[what]()


def test_a_bare_image_has_no_names(tokenizer: Tokenizer) -> None:
    image = tokenizer.compile(HEAD + "w VAR Word\nEND\n").image
    bench = bench_of_image(image)
    with pytest.raises(SymbolError, match="main: the source in slot 0 is not known"):
        bench.variable("main.w")
    assert bench.chip("main").level(3) is None
    assert bench.chip("main").level("P3") is None


def test_nothing_is_claimed_that_the_tokenizer_does_not_confirm(tokenizer: Tokenizer) -> None:
    compiled = tokenizer.compile(HEAD + "w VAR Word\nEND\n", "it.bs2")
    changed: Compiled = replace(compiled, source=compiled.source.replace("Word", "Byte"))
    with pytest.raises(SymbolError, match="its names cannot be told from its source"):
        symbols_of(changed)


def test_every_source_that_we_have_is_understood(tokenizer: Tokenizer) -> None:
    """What is read of it is what the tokenizer counts, and its DATA is told apart."""
    vectors = json.loads((HERE / "vectors" / "tokens.json").read_text())
    sources = {one["id"]: one["source"] for one in vectors}
    for folder in (HERE / "programs", HERE / "decode", HERE.parent / "firmware" / "predator"):
        sources |= {path.name: read_source(path) for path in sorted(folder.glob("*.bs*"))}
    sources |= {f"random {n}": RandomProgram(n, CHIPS[n % 5]).source() for n in range(20)}
    understood = 0
    for name, source in sources.items():
        try:
            compiled = tokenizer.compile(source, name)
        except SourceError:  # "expression is too complex" now and then
            continue
        symbols = symbols_of(compiled)
        assert symbols.data is not None, name
        assert sum(block.bytes for block in symbols.data.values()) == compiled.data_bytes, name
        understood += 1
    assert understood > 200


def test_layout_of_a_source() -> None:
    assert layout_of(HEAD + "b VAR Byte(3)\nx VAR b.HIGHBIT\nw VAR Word\n") == {
        "w": Place(16, 3, 1),
        "b": Place(8, 8, 3),
        "x": Place(1, 71, 1),
    }
