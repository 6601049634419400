"""Facts of the chip: rows, images, packets, streams."""

import dataclasses

import pytest

from cgagen.errors import ImageError
from cgagen.stamp.chips import CHIPS, chip, chip_of_target
from cgagen.stamp.compiled import SourceMap, Statement, VariableCounts
from cgagen.stamp.image import SENT, Image, Use
from cgagen.stamp.packets import blocks_of, packet, packets_of
from cgagen.stamp.pins import wrong_pin
from cgagen.stamp.stream import address_at, stream_of

BS2 = chip("BS2")


def image_with(used: dict[int, tuple[Use, int]]) -> Image:
    eeprom, flags = bytearray(2048), bytearray(2048)
    for address, (use, value) in used.items():
        eeprom[address], flags[address] = value, use | SENT
    return Image(BS2, bytes(eeprom), bytes(flags))


def test_every_model_is_found_by_name_and_target() -> None:
    assert [row.name for row in CHIPS] == ["BS2", "BS2e", "BS2sx", "BS2p", "BS2pe"]
    for row in CHIPS:
        assert chip(row.name) is chip(row.directive) is chip(row.name.lower()) is row
        assert chip_of_target(row.target) is row


def test_units_differ_where_the_documents_say_so() -> None:
    assert (chip("BS2p").pulsin_unit_ns, chip("BS2p").rctime_unit_ns) == (750, 750)
    # S4 and S5: 49.151 ms at most; S2 and S4: 123.6 ms, "2 us" rounded
    assert 65_535 * chip("BS2p").pulsin_unit_ns == pytest.approx(49_151_000, rel=1e-4)
    assert 65_535 * chip("BS2pe").pulsin_unit_ns == pytest.approx(123_600_000, rel=4e-3)
    assert chip("BS2sx").debug_baud_word == 2_500_000 // 9600 - 20
    assert chip("BS2pe").debug_baud_word == 1_000_000 // 9600 - 20
    assert (BS2.slots, chip("BS2e").slots) == (1, 8)


@pytest.mark.parametrize("name", ["BS1", "BS2px", "", "BS22"])
def test_unknown_models_are_refused_with_the_known_ones(name: str) -> None:
    with pytest.raises(ImageError, match="BS2, BS2e, BS2sx, BS2p, BS2pe"):
        chip(name)
    with pytest.raises(ImageError):
        chip_of_target(7)


@pytest.mark.parametrize(
    ("eeprom", "flags", "slot", "words"),
    [
        (2047, None, 0, "2047"),
        (2049, None, 0, "2049"),
        (2048, 16, 0, "flags"),
        (2048, None, 1, "no program slot 1"),
        (2048, None, -1, "no program slot -1"),
    ],
)
def test_an_image_of_another_shape_is_refused(
    eeprom: int, flags: int | None, slot: int, words: str
) -> None:
    with pytest.raises(ImageError, match=words):
        Image(BS2, bytes(eeprom), None if flags is None else bytes(flags), slot)


def test_a_flag_without_meaning_is_refused() -> None:
    with pytest.raises(ImageError, match="flag"):
        Image(BS2, bytes(2048), bytes([4]) + bytes(2047))


def test_a_bare_image_has_no_packets() -> None:
    bare = Image(BS2, bytes(2048))
    assert len(bare.digest) == 64
    with pytest.raises(ImageError, match="compile"):
        packets_of(bare)


def test_the_digest_is_of_the_bytes_alone() -> None:
    with_flags = image_with({5: (Use.DATA, 9)})
    assert with_flags.digest == Image(BS2, with_flags.eeprom).digest
    assert with_flags.digest != dataclasses.replace(with_flags, eeprom=bytes(2048)).digest


def test_only_blocks_with_defined_bytes_are_sent() -> None:
    image = image_with(
        {3: (Use.DATA, 0), 40: (Use.RESERVED, 0), 2047: (Use.PROGRAM, 0xC0), 2032: (Use.DATA, 1)}
    )
    packets = packets_of(image)
    assert [data[0] for data in packets] == [0x80, 0xFF]
    assert all(len(data) == 18 and sum(data) % 256 == 0 for data in packets)
    assert blocks_of(packets) == {0: bytes(16), 127: b"\x01" + bytes(14) + b"\xc0"}


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda p: [p[:-1]], "17 bytes"),
        (lambda p: [p[:5] + bytes([p[5] ^ 1]) + p[6:]], "checksum"),
        (lambda p: [p, p], "repeats block 3"),
        (lambda p: [bytes([p[0] - 0x80]) + p[1:-1] + bytes([p[-1] ^ 0x80])], "80h"),
    ],
)
def test_a_spoiled_packet_is_refused(spoil, words) -> None:  # type: ignore[no-untyped-def]
    good = packet(3, bytes(range(16)))
    assert blocks_of([good]) == {3: bytes(range(16))}
    with pytest.raises(ImageError, match=words):
        blocks_of(spoil(good))


def test_a_block_outside_the_eeprom_is_a_bug_of_the_caller() -> None:
    for block, data in ((128, bytes(16)), (-1, bytes(16)), (0, bytes(15))):
        with pytest.raises(ValueError, match="not a block"):
            packet(block, data)


def test_the_stream_runs_down_from_the_last_byte() -> None:
    eeprom = bytes(2045) + bytes([0b00000001, 0b10000000, 0b11000000])
    stream = stream_of(eeprom)
    assert len(stream) == 16384
    assert stream[:24] == "110000001000000000000001"


@pytest.mark.parametrize("address", [0, 14, 28, 8191, 16383])
def test_addresses_are_stored_bit_first(address: int) -> None:
    assert address_at(f"{address % 8:03b}{address // 8:011b}", 0) == address


def test_a_pin_is_judged_by_opcode_and_model() -> None:
    push_16 = "1" + "100100" + "0"  # width 4, no more bits
    lcd = 2 * push_16 + "0" + f"{0x2E:06b}"  # LCDCMD on a BS2p, nothing on a BS2
    assert wrong_pin(lcd, 0, chip("BS2p")) == (16, 15)
    with pytest.raises(ImageError, match="no instruction of code 2Eh"):
        wrong_pin(lcd, 0, BS2)
    assert wrong_pin(push_16 + "0" + f"{0x05:06b}", 0, BS2) == (16, 15)  # HIGH
    item = "1000001" + "0" + "0"
    assert wrong_pin(2 * push_16 + "0" + f"{0x20:06b}" + item, 0, BS2) is None  # SEROUT
    flow = 3 * push_16 + "0" + f"{0x21:06b}" + item
    assert wrong_pin(flow, 0, BS2) == (16, 15)


def test_of_statements_with_one_address_the_last_owns_it() -> None:
    rows = (Statement(0, 1, 1, 14), Statement(9, 2, 1, 14), Statement(20, 3, 1, 40))
    source_map = SourceMap(rows)
    assert source_map.at_bit(13) is None
    assert source_map.at_bit(14) == source_map.at_bit(39) == rows[1]
    assert source_map.at_bit(16383) == rows[2]
    assert SourceMap(()).at_bit(14) is None


def test_variables_are_counted_in_bits() -> None:
    assert VariableCounts(bits=1, nibbles=1, bytes=1, words=1).total_bits == 29
