"""Decoding: every vector without a bit left over, and every other image an error with its place."""

import json
import random
import re
from pathlib import Path
from typing import Any

import pytest

from cgagen.errors import ImageError
from cgagen.stamp.chips import CHIPS, Chip, chip
from cgagen.stamp.decode import decode, decode_at
from cgagen.stamp.image import Image
from cgagen.stamp.listing import listing_text
from cgagen.stamp.program import Instruction, Kind, Program, constant_of
from cgagen.stamp.stream import stream_of
from cgagen.tokenizer import Tokenizer

VECTORS = json.loads((Path(__file__).parent / "vectors" / "tokens.json").read_text())
HEAD = "' {$STAMP BS2}\n' {$PBASIC 2.5}\n"
START = "11000000000001"
END = "0000000"


def image_of(vector: dict[str, Any]) -> tuple[bytes, bytes]:
    """The bytes of a vector, and what each of them is."""
    tail = bytes.fromhex(vector["program_tail_hex"])
    eeprom = bytearray(2048 - len(tail)) + tail
    flags = bytearray(2048 - len(tail)) + b"\3" * len(tail)
    for address, byte in vector["data_bytes"].items():
        eeprom[int(address)] = int(byte, 16)
        flags[int(address)] = 2
    return bytes(eeprom), bytes(flags)


def eeprom_of(*parts: str) -> bytes:
    """An EEPROM whose stream begins with these bits."""
    stream = "".join(parts).replace(" ", "").ljust(8 * 2048, "0")
    return int(stream, 2).to_bytes(2048, "big")[::-1]


def compiled(tokenizer: Tokenizer, code: str, head: str = HEAD) -> Program:
    image = tokenizer.compile(head + code + "\n").image
    return decode(image.eeprom, image.model, image.flags)


@pytest.mark.parametrize("vector", VECTORS, ids=lambda vector: str(vector["id"]))
def test_a_vector_decodes_to_its_last_bit(vector: dict[str, Any]) -> None:
    eeprom, flags = image_of(vector)
    program = decode(eeprom, chip(vector["model"]), flags)
    assert program.start_bit == vector["start_bit"]
    assert program.end_bit == vector["end_bit"]
    assert program.program_bytes == vector["program_bytes"]
    assert len(program.gosub_slots) == vector["start_bit"] // 14 - 1
    bits = [instruction.address for instruction in program.instructions]
    assert bits[0] == program.start_bit
    assert bits[1:] == [instruction.end for instruction in program.instructions[:-1]]
    listed = [re.match(r" *(\d+)  \$", line) for line in vector["listing"]]
    assert bits == [int(found[1]) for found in listed if found]
    assert {bit for _, bit in vector["xref"]} <= set(bits)


@pytest.mark.parametrize("vector", VECTORS, ids=lambda vector: str(vector["id"]))
def test_a_vector_decodes_without_flags(vector: dict[str, Any]) -> None:
    """All that is lost is an END behind an END."""
    eeprom, flags = image_of(vector)
    model = chip(vector["model"])
    known, bare = decode(eeprom, model, flags).instructions, decode(eeprom, model).instructions
    assert known[: len(bare)] == bare
    assert all(instruction.name == "END" for instruction in known[len(bare) :])


def test_one_instruction_at_its_address() -> None:
    for vector in VECTORS:
        eeprom, flags = image_of(vector)
        model = chip(vector["model"])
        for instruction in decode(eeprom, model, flags).instructions:
            assert decode_at(eeprom, instruction.address, model) == instruction


def test_operands_are_told_apart(tokenizer: Tokenizer) -> None:
    code = "LOOKUP B0 + 1, [2, W1(B3), 4], B5(B6)"
    (lookup, _) = compiled(tokenizer, code).instructions
    assert lookup.form == ("index",)
    assert [token[:2] for token in lookup.operands[0]] == [
        (Kind.READ, 6),
        (Kind.CONSTANT, 1),
        (Kind.OPERATOR, 0x0F),
    ]
    assert [len(item.values) for item in lookup.items] == [1, 1, 1]
    assert lookup.items[1].values[0] == ((Kind.READ, 9, 8, False), (Kind.READ, 4, 16, True))
    assert lookup.write == ((Kind.READ, 12, 8, False), (Kind.WRITE, 11, 8, True))


def test_an_assignment_is_its_value_and_its_write(tokenizer: Tokenizer) -> None:
    (let, _) = compiled(tokenizer, "W1(B3 + 2) = 5 * B4").instructions
    assert let.name == "LET"
    assert let.operand("value") == let.operands[0]
    assert [token.value for token in let.operands[0]] == [5, 10, 0x12]
    assert let.write is not None
    assert [token.value for token in let.write] == [9, 2, 0x0F, 4]


def numbers(instruction: Instruction) -> dict[str, int | None]:
    return {
        name: constant_of(value)
        for name, value in zip(instruction.form, instruction.operands, strict=True)
    }


def test_operands_have_the_names_that_pushing_gives_them(tokenizer: Tokenizer) -> None:
    code = (
        "again:\nBUTTON 1, 2, 3, 4, B0, 5, again\nPULSOUT 6, 7\nSHIFTOUT 8, 9, 10, [11\\12]\n"
        "PWM 1, 2, 3\nWRITE 4, 5\nDTMFOUT 6, 7, 8, [9]\nFREQOUT 1, 2, 3, 4\nXOUT 5, 6, [7\\8]"
    )
    rows = [numbers(instruction) for instruction in compiled(tokenizer, code).instructions]
    assert rows[0] == {
        "down_state": 2, "delay": 3, "rate": 4, "target_state": 5, "workspace": None, "pin": 1
    }  # fmt: skip
    assert rows[1:4] == [
        {"duration": 7, "pin": 6},
        {"mode": 10, "data_pin": 8, "clock_pin": 9},
        {"duty": 2, "duration": 3, "pin": 1},
    ]
    assert rows[4:] == [
        {"value": 5, "location": 4},
        {"off_time": 8, "on_time": 7, "pin": 6},
        {"pin": 1, "duration": 2, "frequency": 3, "second": 4},
        {"pin": 5, "zero_pin": 6},
        {},
    ]


def test_targets_of_every_kind(tokenizer: Tokenizer) -> None:
    code = (
        "here:\nGOTO here\nBRANCH B0, [here, there]\nIF B0 THEN there\nGOSUB here\n"
        "SERIN 1, 84, here, 100, there, [B0]\nSEROUT 1\\2, 84, 9, there, [B0]\n"
        "FOR B0 = 1 TO 2\nNEXT\nthere:"
    )
    program = compiled(tokenizer, code)
    here, there = program.start_bit, program.instructions[-1].address
    by_name = {instruction.name: instruction for instruction in program.instructions}
    assert by_name["GOTO"].targets == by_name["GOSUB"].targets == (here,)
    assert by_name["BRANCH"].targets == by_name["SERIN"].targets == (here, there)
    assert by_name["IF"].targets == by_name["SEROUT_FLOW"].targets == (there,)
    assert by_name["NEXT"].targets == (by_name["LET"].end,)
    assert by_name["GOSUB"].number == 1
    assert program.gosub_slots == (by_name["GOSUB"].end,)
    assert by_name["NEXT"].items[0].values == (
        ((Kind.READ, 6, 8, False),),
        ((Kind.CONSTANT, 1, 0, False),),
    )


def test_input_items_and_their_writes(tokenizer: Tokenizer) -> None:
    code = 'DEBUGIN B0, DEC W1, STR B4\\3, WAIT("abc"), SKIP 2'
    items = compiled(tokenizer, code).instructions[0].items
    assert [len(item.values) for item in items] == [0, 2, 2, 5, 2]
    assert [item.write is not None for item in items] == [True, True, False, False, False]
    assert [constant_of(value) for value in items[3].values] == [99, 98, 97, 0xC44, 3]


def test_six_characters_to_wait_for_fill_the_stack(tokenizer: Tokenizer) -> None:
    items = compiled(tokenizer, 'DEBUGIN WAIT("sixchr")').instructions[0].items
    assert len(items[0].values) == 8


REFUSED = [
    # (model, bits, stream bit, words)
    ("BS2", "", 0, "no program starts at stream bit 0"),
    ("BS2", "000 00000000010", 0, "no program starts at stream bit 16"),
    ("BS2", START + "0 111100", 14, "no instruction of code 3Ch"),
    ("BS2", START + "0 011011", 14, "no instruction of code 1Bh"),
    ("BS2p", START + "0 111111", 14, "no instruction of code 3Fh"),
    ("BS2", START + "0 000101", 14, "HIGH has 0 operands instead of 1"),
    ("BS2", START + "1 100000 0" * 2 + "0 000101", 30, "HIGH has 2 operands instead of 1"),
    ("BS2", START + "1 001111", 15, "an operator lacks its operand"),
    ("BS2", START + "1 100000 0" * 9, 79, "needs more than the 8 words"),
    ("BS2", START + "1 100000 0" + "1 111010 00110" + "0 000101", 34, "stored before HIGH"),
    ("BS2", START + "1 100000 0" + "0 011010", 22, "no variable is named before LET"),
    ("BS2", START + "1 111010 00110" + "0 011010", 26, "LET has 0 operands instead of 1"),
    (
        "BS2",
        START + "1 100000 0" * 2 + "1 111010 00110",
        31,
        "values are left on the stack where one is stored",
    ),
    ("BS2", START + "1 100000 0" + "0 000001" + START, 29, "the address of the next bit reads 14"),
    ("BS2", START + "1 100000 0" + "0 010001" + "000", 29, "LOOKDOWN has no comparison 0"),
    ("BS2", START + "1 100000 0 0 010010 100000 0 0", 29, "a value is not stored"),
]


@pytest.mark.parametrize(("model", "bits", "bit", "words"), REFUSED)
def test_what_is_no_program_is_refused_with_its_place(
    model: str, bits: str, bit: int, words: str
) -> None:
    with pytest.raises(ImageError) as caught:
        decode(eeprom_of(bits), chip(model))
    assert words in str(caught.value)
    found = re.match(r"stream bit (\d+) \(byte (\d+), bit (\d)\): ", str(caught.value))
    assert found, str(caught.value)
    assert int(found[2]) == 2047 - int(found[1]) // 8
    assert int(found[1]) == bit


def test_a_list_that_never_ends_is_refused() -> None:
    pushed = START + "1 100000 0" + "0 001111"
    with pytest.raises(ImageError, match="the EEPROM ends inside an instruction"):
        decode(ones_after(pushed), chip("BS2"))


def ones_after(bits: str) -> bytes:
    """An EEPROM that is all ones behind some bits."""
    stream = bits.replace(" ", "").ljust(8 * 2048, "1")
    return int(stream, 2).to_bytes(2048, "big")[::-1]


def test_code_behind_an_end_is_found_where_something_jumps_there(tokenizer: Tokenizer) -> None:
    image = tokenizer.compile(HEAD + "GOSUB far\nEND\nfar:\nHIGH 1\nRETURN\n").image
    names = [i.name for i in decode(image.eeprom, image.model).instructions]
    assert names == ["GOSUB", "END", "HIGH", "RETURN", "END"]


def test_data_right_behind_the_program_is_not_code(tokenizer: Tokenizer) -> None:
    """Without flags, what comes after an END that nothing jumps beyond may be anything."""
    image = tokenizer.compile(HEAD + "HIGH 1\nDATA @0, 255(2043)\n").image
    assert [i.name for i in decode(image.eeprom, image.model).instructions] == ["HIGH", "END"]
    assert decode(image.eeprom, image.model, image.flags).end_bit == 36


def test_flags_of_another_image_are_refused(tokenizer: Tokenizer) -> None:
    image = tokenizer.compile(HEAD + "HIGH 1\nHIGH 2\nHIGH 3\n").image
    for count in (0, 2, 4, 8):
        flags = bytes(2048 - count) + b"\3" * count
        with pytest.raises(ImageError):
            decode(image.eeprom, image.model, flags)


def random_image(source: random.Random, seeds: list[tuple[Chip, bytes]]) -> tuple[Chip, bytes]:
    """Noise, noise behind a good header, or a good image with some bits turned."""
    kind = source.randrange(4)
    if kind == 0:
        return source.choice(CHIPS), source.randbytes(2048)
    if kind == 1:
        gosubs = source.randrange(4)
        start = 14 * (gosubs + 1)
        header = f"{start % 8:03b}{start // 8:011b}"
        noise = stream_of(source.randbytes(2048))
        density = source.choice((noise, noise.replace("1", "0", 4000)))
        return source.choice(CHIPS), eeprom_of(header + density[14:])
    model, image = source.choice(seeds)
    changed = bytearray(image)
    for _ in range(source.randint(1, 4)):
        changed[2047 - source.randrange(40)] ^= 1 << source.randrange(8)
    return model if kind == 2 else source.choice(CHIPS), bytes(changed)


def fuzz(count: int) -> dict[str, int]:
    source = random.Random(2005)
    seeds = [(chip(vector["model"]), image_of(vector)[0]) for vector in VECTORS]
    ends = {"listed": 0, "decoded": 0, "refused": 0}
    for _ in range(count):
        model, eeprom = random_image(source, seeds)
        end = "refused"
        try:
            program = decode(eeprom, model)
            end = "decoded"
            listing_text(program, Image(model, eeprom))
            end = "listed"
        except ImageError as error:
            refused = re.match(r"stream bit \d+ \(byte \d+, bit \d\): .+;", str(error))
            if refused is None:
                raise
        ends[end] += 1
    return ends


def test_random_images_end_in_a_program_or_an_error_with_its_place() -> None:
    ends = fuzz(10_000)
    assert min(ends.values()) > 200, ends


@pytest.mark.slow
def test_a_hundred_thousand_random_images() -> None:
    assert sum(fuzz(100_000).values()) == 100_000


def test_any_address_of_a_program_decodes_or_is_refused() -> None:
    """Jumps into the middle of things: the emulator asks for any address."""
    eeprom, _ = image_of(next(v for v in VECTORS if v["id"] == "dbg_q/BS2"))
    for address in range(900):
        try:
            instruction = decode_at(eeprom, address, chip("BS2"))
        except ImageError:
            continue
        assert instruction.address == address < instruction.end
    with pytest.raises(ImageError, match="the EEPROM ends"):
        decode_at(eeprom, 16383, chip("BS2"))
