"""The loader in the chip's ROM: who it is, and its packets."""

import pytest

from cgagen.emulator.host_port import HostPort
from cgagen.emulator.loader import BURN_NS, Phase
from cgagen.emulator.programs import bench_of_image
from cgagen.emulator.rom import IDENTITIES
from cgagen.errors import BenchError
from cgagen.stamp.chips import CHIPS, EEPROM_BYTES, chip
from cgagen.stamp.image import Image
from cgagen.stamp.packets import packet, packets_of
from cgagen.tokenizer import Tokenizer
from tests.loader_dialogue import ANSWERS, HELLO, MS, ask, blank, download, enter, identify, output


@pytest.fixture(scope="module")
def images(tokenizer: Tokenizer) -> dict[str, Image]:
    return {row.name: tokenizer.compile(HELLO % row.directive).image for row in CHIPS}


# --- Who it is ----------------------------------------------------------------------------------

#   model, legs, and what Parallax's and others' programmers expect, version by version
REPLIES = [
    ("BS2", 24, ["bead ce 10"]),
    ("BS2e", 24, ["65", "66", "67"]),
    ("BS2sx", 24, ["58", "59", "5a", "5b"]),
    ("BS2p", 24, ["70", "71", "72", "73", "74", "75", "76", "77"]),
    ("BS2p", 40, ["50", "51", "52", "53", "54", "55", "56", "57"]),
    ("BS2pe", 24, ["69", "6a", "6b", "6c", "6d"]),
    ("BS2pe", 40, ["49", "4a", "4b", "4c", "4d"]),
]


@pytest.mark.parametrize(("model", "legs", "replies"), REPLIES)
def test_every_model_and_version_says_who_it_is(model: str, legs: int, replies: list[str]) -> None:
    assert len(IDENTITIES[model, legs].versions) == len(replies)
    for version, reply in enumerate(replies):
        port = HostPort(blank(model), legs=legs, version=version)
        enter(port)
        assert identify(port) == bytes.fromhex(reply)


def test_a_model_that_is_not_made_is_refused() -> None:
    with pytest.raises(BenchError, match="a BS2 with 40 legs is not made"):
        HostPort(blank("BS2"), legs=40)


@pytest.mark.parametrize("model", ANSWERS)
def test_other_models_words_are_ignored(model: str) -> None:
    port = HostPort(blank(model))
    for other, word in ANSWERS.items():
        if other != model:
            enter(port)
            assert ask(port, word) == b""
    enter(port)
    ask(port, b"\xff\x80qqq")
    assert len(identify(port)) == len(ANSWERS[model])


def test_a_bs2_starts_over_after_a_wrong_byte() -> None:
    port = HostPort(blank("BS2"))
    enter(port)
    assert ask(port, b"B") == b"\xbe"
    assert ask(port, b"x") == b""
    assert ask(port, b"S") == b""
    assert ask(port, b"B") == b"\xbe"
    assert ask(port, b"B") == b"\xbe"
    assert ask(port, b"S") == b"\xad"


# --- Packets ------------------------------------------------------------------------------------


@pytest.mark.parametrize("row", CHIPS, ids=lambda row: row.name)
def test_a_program_is_loaded_and_runs_from_reset(row: object, images: dict[str, Image]) -> None:
    image = images[row.name]  # type: ignore[attr-defined]
    port = HostPort(blank(image.model.name))
    download(port, packets_of(image))
    assert port.chip.eeprom() == image.eeprom
    assert ask(port, b"\0", 0) == b""
    assert output(port) == b"hello\r"
    assert port.loader.phase is Phase.RUNNING


def test_only_written_blocks_change() -> None:
    before = bytes(range(256)) * 8
    port = HostPort(bench_of_image(Image(chip("BS2"), before)))
    block = bytes(range(100, 116))
    download(port, [packet(5, block), packet(127, block)])
    after = port.chip.eeprom()
    assert after[80:96] == after[2032:] == block
    assert after[:80] + after[96:2032] == before[:80] + before[96:2032]


@pytest.mark.parametrize("model", ["BS2e", "BS2sx", "BS2p", "BS2pe"])
def test_each_slot_can_be_chosen(model: str) -> None:
    port = HostPort(blank(model))
    for slot in range(8):
        download(port, [packet(slot, bytes([slot + 1] * 16))], slot)
    for slot in range(8):
        image = port.chip.eeprom(slot)
        assert image == bytes(16 * slot) + bytes([slot + 1] * 16) + bytes(2032 - 16 * slot)
    assert port.loader.packets == 8


def test_a_slot_that_is_not_there_ends_the_loader() -> None:
    port = HostPort(blank("BS2p"))
    enter(port)
    identify(port)
    assert ask(port, b"\x08", 0) == b""
    assert ask(port, packet(1, bytes(16))) == b""
    assert not any(any(port.chip.eeprom(slot)) for slot in range(8))


def test_a_wrong_checksum_is_refused_and_the_packet_can_be_sent_again() -> None:
    port = HostPort(blank("BS2"))
    good = packet(3, bytes(range(16)))
    download(port, [])
    for place in range(1, 18):
        bad = bytearray(good)
        bad[place] ^= 0x10
        assert ask(port, bytes(bad)) == b"\1"
        assert not any(port.chip.eeprom())
    assert ask(port, good) == b"\0"
    assert port.chip.eeprom()[48:64] == good[1:17]


def test_a_block_that_the_eeprom_does_not_take() -> None:
    port = HostPort(blank("BS2"))
    port.loader.bad_blocks = frozenset({9})
    download(port, [packet(8, b"\1" * 16)])
    assert ask(port, packet(9, b"\1" * 16)) == b"\2"
    assert port.chip.eeprom() == bytes(128) + b"\1" * 16 + bytes(2048 - 144)


def test_a_packet_takes_the_time_of_the_wire_and_of_the_eeprom() -> None:
    """19 characters of 1/960 s, 10 ms, and a bit or two."""
    port = HostPort(blank("BS2"))
    download(port, [])
    began = port.bench.clock.now_ns
    assert ask(port, packet(0, bytes(16))) == b"\0"
    took = port.bench.clock.now_ns - began
    assert 19 / 960 * 1e9 + BURN_NS - MS < took < 19 / 960 * 1e9 + BURN_NS + MS


def test_who_sends_too_early_is_not_heard() -> None:
    port = HostPort(blank("BS2"))
    download(port, [])
    port.write(packet(0, b"\1" * 16))
    port.write(b"\x81")
    port.sleep(0.2)
    assert port.chip.eeprom() == b"\1" * 16 + bytes(EEPROM_BYTES - 16)
    port.reset_input_buffer()
    assert ask(port, packet(1, b"\2" * 16)) == b"\0"


@pytest.mark.parametrize("end", [b"\0", b"\x7f", b"A"])
def test_a_byte_without_bit_7_ends_it(end: bytes, images: dict[str, Image]) -> None:
    port = HostPort(bench_of_image(images["BS2"]))
    download(port, [])
    ask(port, end, 0)
    assert output(port) == b"hello\r"
    assert port.loader.phase is Phase.RUNNING


def test_half_a_packet_waits_until_the_next_reset(images: dict[str, Image]) -> None:
    port = HostPort(bench_of_image(images["BS2"]))
    download(port, [])
    half = packet(0, b"\x55" * 16)[:9]
    assert ask(port, half) == b""
    assert output(port, 5) == b""
    download(port, [packet(0, b"\x55" * 16)])
    assert port.chip.eeprom()[:16] == b"\x55" * 16
    assert port.chip.eeprom()[16:] == images["BS2"].eeprom[16:]
