"""What instructions take: the model's own predictions, from the tokenizer's bits.

Expected values are those of the model 18.6 us + 8.05 us a bit + 102.9 us a jump for the BS2, worked
out by hand from the bits of each instruction; operators are left out of them. What the model has
from whom is in `test_timing_published.py`.
"""

from dataclasses import fields, replace

import pytest

from cgagen.emulator.chip import Chip
from cgagen.emulator.clock import Clock
from cgagen.emulator.costs import LISTS_LATER, item_bits
from cgagen.emulator.expressions import expression_bits, token_bits
from cgagen.emulator.timing import timing_of
from cgagen.stamp.chips import CHIPS, chip
from cgagen.stamp.decode import decode
from cgagen.stamp.program import Kind, Token
from cgagen.tokenizer import Tokenizer
from tests.chip_programs import chip_of
from tests.pbasic_random import RandomProgram

HEAD = "' {$STAMP %s}\n' {$PBASIC 2.5}\n"
VARIABLES = "w VAR Word\nx VAR Word\nb VAR Byte\nn VAR Nib\nt VAR Bit\na VAR Word(2)\n"

TABLE = [
    # source, bits, jumps, operators' class by name
    ("HIGH 2", 15, 0, ""),
    ("INPUT 4", 15, 0, ""),
    ("w = 0", 26, 0, ""),
    ("w = 1000", 35, 0, ""),
    ("w = x", 29, 0, ""),
    ("b = b + 1", 46, 0, "simple_ns"),
    ("w = w + x", 47, 0, "simple_ns"),
    ("w = w * x", 47, 0, "multiply_ns"),
    ("w = w / x", 47, 0, "divide_ns"),
    ("w = SQR x", 36, 0, "root_ns"),
    ("w = SIN x", 36, 0, "sine_ns"),
    ("w = x DIG 0", 44, 0, "divide_ns"),
    ("OUTS = w", 29, 0, ""),
    ("DIRS = 0", 26, 0, ""),
    ("OUTA = 0", 28, 0, ""),
    ("t = IN3", 37, 0, ""),
    ("a(1) = 0", 26 + 8, 0, ""),
    ("a(n) = 0", 26 + 13, 0, ""),
    ("PAUSE 0", 7 + 8, 0, "pause_setup_ns"),
    ("RANDOM w", 29, 0, ""),
    ("GOTO here\nhere:", 21, 1, ""),
    ("BRANCH b, [here, here]\nhere:", 12 + 7 + 30, 1, ""),
    ("BRANCH 5, [here, here]\nhere:", 10 + 7 + 30, 0, ""),
    ("IF w = 0 THEN here\nhere:", 11 + 8 + 7 + 7 + 14, 1, "simple_ns"),
    ("IF w = 1 THEN here\nhere:", 11 + 8 + 7 + 7 + 14, 0, "simple_ns"),
]


def spent(tokenizer: Tokenizer, model: str, source: str, **changes: int) -> int:
    """Return what passes until the program is at its appended END."""
    image = tokenizer.compile(HEAD % model + VARIABLES + source + "\nSTOP\n").image
    timing = replace(timing_of(chip(model)), **changes)
    made = Chip("chip", [image], Clock(), timing=timing)
    made.run(20_000_000_000)
    assert made.ended == "STOP"
    return made.local_ns - timing.fetch_ns - 7 * timing.bit_ns  # STOP itself


@pytest.mark.parametrize(("source", "bits", "jumps", "operator"), TABLE)
def test_an_instruction_takes_its_bits_and_jumps(
    tokenizer: Tokenizer, source: str, bits: int, jumps: int, operator: str
) -> None:
    for model in ("BS2", "BS2p"):
        timing = timing_of(chip(model))
        expected = timing.fetch_ns + bits * timing.bit_ns + jumps * timing.jump_ns
        expected += getattr(timing, operator) if operator else 0
        assert spent(tokenizer, model, source) == expected


def test_a_subroutine_takes_two_jumps_to_come_back(tokenizer: Tokenizer) -> None:
    whole = spent(tokenizer, "BS2", "GOSUB here\nSTOP\nhere: RETURN")
    # GOSUB 29 bits and a jump; RETURN 7 and the 14 of its slot in the header, and two jumps
    assert whole == 18_600 + 29 * 8_050 + 102_900 + 18_600 + (7 + 14) * 8_050 + 205_800


def test_a_loop_takes_a_jump_for_each_pass_but_the_last(tokenizer: Tokenizer) -> None:
    source = "FOR w = 1 TO %d\nNEXT"
    two, three = (spent(tokenizer, "BS2", source % passes) for passes in (2, 3))
    assert three - two == 18_600 + 8_050 * (3 * 68 - 2 * 67) + 102_900  # 3 has a bit more than 2


@pytest.mark.parametrize(
    ("model", "source", "ns"),
    [
        ("BS2", "PAUSE 20", 20_000_000),
        ("BS2p", "PAUSE 20", 20_000_000),
        ("BS2", "WRITE 0, 1", 5_000_000),
        ("BS2", "NAP 0", 18_000_000 + 18_000_000),
        ("BS2", "NAP 3", 8 * 18_000_000 + 18_000_000),
        ("BS2pe", "NAP 0", 18_000_000 + 60_000),
        # S4 (SLEEP), its table: whole periods, never fewer than the seconds that are asked for
        *(
            ("BS2", f"SLEEP {seconds}", periods * 2_304_000_000)
            for seconds, periods in enumerate((1, 1, 2, 2, 3, 3, 4, 4, 4, 5), 1)
        ),
    ],
)
def test_time_of_their_own(tokenizer: Tokenizer, model: str, source: str, ns: int) -> None:
    """All but the bits: a chip whose interpreter takes next to nothing."""
    free = dict.fromkeys(("fetch_ns", "bit_ns", "jump_ns", "read_ns", "pause_setup_ns"), 0)
    assert spent(tokenizer, model, source, **free) == ns


@pytest.mark.parametrize(("model", "unit_ns"), [("BS2", 2000), ("BS2p", 800), ("BS2pe", 2000)])
def test_a_unit_of_pulsout(tokenizer: Tokenizer, model: str, unit_ns: int) -> None:
    short, long = (spent(tokenizer, model, f"PULSOUT 2, {units}") for units in (600, 999))
    assert long - short == 399 * unit_ns


def test_read_reads_the_eeprom_once_more(tokenizer: Tokenizer) -> None:
    assert (
        spent(tokenizer, "BS2", "READ 0, b") - spent(tokenizer, "BS2", "READ 0, b", read_ns=0)
        == 100_000
    )


def test_the_models_differ_by_their_instructions_per_second() -> None:
    bs2 = timing_of(chip("BS2"))
    for model, factor in (("BS2e", 1), ("BS2sx", 2.5), ("BS2p", 3), ("BS2pe", 1.5)):
        other = timing_of(chip(model))
        for name in ("fetch_ns", "bit_ns", "jump_ns", "divide_ns", "root_ns"):
            assert getattr(other, name) == pytest.approx(getattr(bs2, name) / factor, rel=1e-3)


def test_units_of_the_table_of_chips() -> None:
    for model in CHIPS:
        timing = timing_of(model)
        assert timing.pulsout_ns == model.pulsout_unit_ns
        assert timing.pulsin_ns == model.pulsin_unit_ns
        assert timing.rctime_ns == model.rctime_unit_ns
        assert all(getattr(timing, field.name) > 0 for field in fields(timing))
    # 9,600 baud: the word for it, 20 units more, is one bit
    assert (84 + 20) * timing_of(chip("BS2")).serial_unit_ns == 104_000
    assert (240 + 20) * timing_of(chip("BS2p")).serial_unit_ns == 104_000


def test_bits_of_operands_and_items_are_all_bits(tokenizer: Tokenizer) -> None:
    """What `costs` counts for an instruction and its list is what the stream has."""
    seen = set()
    for row in CHIPS:
        image = tokenizer.compile(RandomProgram(5, row).source(60)).image
        for instruction in decode(image.eeprom, row, image.flags).instructions:
            if instruction.name not in LISTS_LATER:
                continue
            parts = sum(expression_bits(operand) for operand in instruction.operands)
            parts += 7 + sum(item_bits(instruction, item) for item in instruction.items)
            assert parts == instruction.end - instruction.address, instruction.name
            seen.add(instruction.name)
    assert len(seen) > 10


@pytest.mark.parametrize("read", ["b = IN3", "b = INL", "b = INA", "w = INS", "n = 13\nw = W0(n)"])
def test_pins_are_read_when_the_fetch_is_over(tokenizer: Tokenizer, read: str) -> None:
    """A pin that rises just before counts, one that rises just after does not."""
    source = VARIABLES + "x = 1\n" * 20 + read + "\nSTOP\n"
    image = tokenizer.compile(HEAD % "BS2" + source).image
    timing = timing_of(chip("BS2"))
    whole = Chip("chip", [image], Clock())
    whole.run(1_000_000_000)
    act_ns = whole.local_ns - timing.fetch_ns - 7 * timing.bit_ns
    for off_ns, seen in ((-1, True), (1, False)):
        clock = Clock()
        made = Chip("chip", [image], clock)
        clock.at(act_ns + off_ns, lambda made=made: made.pins.wires[3].drive("hand", 1))
        made.run(1_000_000_000)
        assert bool(made.registers["B8"] or made.registers["W0"]) is seen


def test_run_takes_one_jump(tokenizer: Tokenizer) -> None:
    made = chip_of(tokenizer, "RUN 1", "STOP", model="BS2p")
    made.run(1_000_000_000)
    timing = made.machine.timing
    assert made.local_ns == 2 * timing.fetch_ns + (15 + 7) * timing.bit_ns + timing.jump_ns


@pytest.mark.parametrize(
    ("value", "bits"), [(0, 7), (1, 7), (2, 7), (3, 8), (5, 9), (6, 9), (64, 7)]
)
def test_a_constant_has_the_fewest_bits_that_will_do(value: int, bits: int) -> None:
    assert token_bits(Token(Kind.CONSTANT, value)) == bits
