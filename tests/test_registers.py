"""The register file: four sizes, one set of bits; three words are pins."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cgagen.emulator.pins import Pins
from cgagen.emulator.registers import ELEMENTS, Registers, element_of
from cgagen.emulator.wires import Wire

ACCESS = st.sampled_from([*ELEMENTS]).flatmap(
    lambda size: st.tuples(st.just(size), st.integers(0, ELEMENTS[size] - 1), st.integers(0, 65535))
)


@settings(deadline=None)
@given(accesses=st.lists(ACCESS, max_size=30))
def test_all_sizes_are_views_of_the_same_bits(
    accesses: list[tuple[int, int, int]],
) -> None:
    registers, model = Registers(Pins("chip")), 0
    for size, element, value in accesses:
        if element * size < 48:
            continue
        registers.write(size, element, value)
        mask = (2**size - 1) << element * size
        model = model & ~mask | (value % 2**size) << element * size
    for size, count in ELEMENTS.items():
        for element in range(48 // size, count):
            assert registers.read(size, element) == model >> element * size & 2**size - 1


@pytest.mark.parametrize("size", ELEMENTS)
def test_numbers_past_the_end_wrap_to_the_pins(size: int) -> None:
    registers = Registers(Pins("chip"))
    outs = 16 // size
    registers.write(size, ELEMENTS[size] + outs, 1)
    assert registers.read(16, 1) == 1
    assert registers.read(size, outs + 2 * ELEMENTS[size]) == 1


def test_outs_and_dirs_are_the_pins() -> None:
    pins = Pins("chip")
    registers = Registers(pins)
    registers["OUTS"] = 0x1234
    registers["DIRS"] = 0x00FF
    assert (pins.latch, pins.directions) == (0x1234, 0x00FF)
    registers["OUTB"] = 0xF
    registers["DIR15"] = 1
    assert (pins.latch, pins.directions) == (0x12F4, 0x80FF)
    assert [registers[name] for name in ("OUTL", "OUTH", "DIRH")] == [0xF4, 0x12, 0x80]
    assert registers.words == [0] * 16


def test_ins_are_levels_of_outputs_too_and_cannot_be_written() -> None:
    pins = Pins("chip")
    registers = Registers(pins)
    pins.connect(3, Wire("up", pull=1))
    registers["INS"] = 0xFFFF
    assert registers["INS"] == 0b1000
    registers["OUTS"] = 0b0101
    registers["DIRS"] = 0b0001
    assert registers["INS"] == 0b1001
    assert [registers[name] for name in ("IN0", "IN2", "IN3", "INA", "INL")] == [1, 0, 1, 9, 9]


def test_a_pin_that_floats_reads_0_and_is_told_once() -> None:
    told: list[int] = []
    registers = Registers(Pins("chip", told.append))
    assert [registers["IN7"], registers["IN7"], registers["IN2"]] == [0, 0, 0]
    assert told == [7, 2]


def test_of_a_nibble_or_byte_every_pin_that_floats_is_told() -> None:
    told: list[int] = []
    pins = Pins("chip", told.append)
    registers = Registers(pins)
    pins.connect(5, Wire("up", pull=1))
    pins.connect(13, Wire("down", pull=0))
    assert registers["INS"] == 0b10_0000
    assert told == []  # who reads all of them rarely cares for all
    assert (registers["INB"], told) == (0b0010, [4, 6, 7])
    assert (registers["INH"], told[3:]) == (0, [8, 9, 10, 11, 12, 14, 15])


def test_names() -> None:
    registers = Registers(Pins("chip"))
    registers["w0"] = 0x1234
    assert (registers["B0"], registers["B1"]) == (0x34, 0x12)
    registers["B25"] = 0xAB
    assert registers["W12"] == 0xAB00
    assert element_of("ind") == (4, 3)
    assert element_of("DIR0") == (1, 32)
    with pytest.raises(KeyError):
        registers["W13"]
