"""The loader in the chip's ROM, seen from a computer's serial port on the bench's own time."""

from collections.abc import Callable, Sequence

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cgagen.emulator.bench import Bench
from cgagen.emulator.host_port import HostPort
from cgagen.emulator.loader import BURN_NS, Atn, Phase
from cgagen.emulator.programs import bench_of_image, bench_of_sources
from cgagen.emulator.rom import IDENTITIES
from cgagen.errors import BenchError
from cgagen.stamp.chips import CHIPS, EEPROM_BYTES, chip
from cgagen.stamp.image import Image
from cgagen.stamp.packets import packet, packets_of
from cgagen.tokenizer import Tokenizer

MS = 1_000_000
ANSWERS = {"BS2": b"BS2\0", "BS2e": b"e", "BS2sx": b"X", "BS2p": b"P", "BS2pe": b"I"}
HELLO = '\' {$STAMP %s}\nDEBUG "hello", CR\nEND\n'


def blank(model: str) -> Bench:
    return bench_of_image(Image(chip(model), bytes(EEPROM_BYTES)))


@pytest.fixture(scope="module")
def images(tokenizer: Tokenizer) -> dict[str, Image]:
    return {row.name: tokenizer.compile(HELLO % row.directive).image for row in CHIPS}


def enter(port: HostPort, hold_s: float = 0.005, after_s: float = 0.04) -> None:
    """Reset with BREAK, and forget what that brought back."""
    port.break_condition = True
    port.dtr = True
    port.sleep(hold_s)
    port.dtr = False
    port.sleep(after_s)
    port.break_condition = False
    port.sleep(0.02)
    port.reset_input_buffer()


def ask(port: HostPort, data: bytes, answers: int = 1) -> bytes:
    """Send, take the echo off, return what else came."""
    port.write(data)
    found = port.read(len(data) + answers)
    assert found[: len(data)] == data, found
    return found[len(data) :]


def identify(port: HostPort) -> bytes:
    model = port.chip.machine.model.name
    return b"".join(ask(port, bytes([byte])) for byte in ANSWERS[model])


def download(port: HostPort, packets: Sequence[bytes], slot: int = 0) -> None:
    enter(port)
    identify(port)
    if port.chip.machine.model.slots > 1:
        assert ask(port, bytes([slot]), 0) == b""
    for one in packets:
        assert ask(port, one) == b"\0"


def output(port: HostPort, seconds: float = 0.5) -> bytes:
    port.sleep(seconds)
    return port.read(port.in_waiting)


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
    assert port.loader.phase is Phase.RUNNING or not port.sleep(0.01)
    assert output(port) == b"hello\r"


def test_half_a_packet_waits_until_the_next_reset(images: dict[str, Image]) -> None:
    port = HostPort(bench_of_image(images["BS2"]))
    download(port, [])
    half = packet(0, b"\x55" * 16)[:9]
    assert ask(port, half) == b""
    assert output(port, 5) == b""
    download(port, [packet(0, b"\x55" * 16)])
    assert port.chip.eeprom()[:16] == b"\x55" * 16
    assert port.chip.eeprom()[16:] == images["BS2"].eeprom[16:]


# --- Reset --------------------------------------------------------------------------------------


def test_a_reset_without_break_runs_the_program(images: dict[str, Image]) -> None:
    port = HostPort(bench_of_image(images["BS2"]))
    assert output(port) == b"hello\r"
    port.dtr = True
    port.sleep(0.005)
    port.dtr = False
    assert output(port) == b"hello\r"


def test_while_dtr_is_asserted_nothing_runs(tokenizer: Tokenizer) -> None:
    source = '\' {$STAMP BS2}\nHIGH 3\nagain:\nDEBUG "x"\nGOTO again\n'
    port = HostPort(bench_of_sources({0: tokenizer.compile(source)}))
    assert output(port, 0.1)
    assert port.chip.pins.directions == 8
    port.dtr = True
    port.sleep(0.01)
    port.reset_input_buffer()
    assert output(port, 3) == b""
    assert port.chip.pins.directions == 0
    port.dtr = False
    assert output(port, 0.1).startswith(b"xx")


def test_too_short_a_reset_is_none(images: dict[str, Image]) -> None:
    port = HostPort(bench_of_image(images["BS2"]))
    assert output(port) == b"hello\r"
    port.dtr = True
    port.sleep(0.0019)
    port.dtr = False
    assert output(port) == b""
    enter(port, hold_s=0.0019)
    assert ask(port, b"B") == b""


def test_too_short_a_break_is_none(images: dict[str, Image]) -> None:
    port = HostPort(bench_of_image(images["BS2"]))
    port.sleep(0.5)
    enter(port, after_s=0.0355)
    assert port.loader.phase is Phase.RUNNING
    enter(port, after_s=0.0365)
    assert port.loader.phase is Phase.IDENTIFY


def test_break_behind_the_reset_is_too_late(images: dict[str, Image]) -> None:
    port = HostPort(bench_of_image(images["BS2"]))
    port.dtr = True
    port.sleep(0.005)
    port.dtr = False
    port.sleep(0.001)
    port.break_condition = True
    port.sleep(0.1)
    port.break_condition = False
    assert port.loader.phase is Phase.RUNNING


def test_break_without_reset_is_garbage_for_serin(tokenizer: Tokenizer) -> None:
    source = "' {$STAMP BS2}\nx VAR BYTE\nx = 77\nSERIN 16, 16468, [x]\nDEBUG DEC x\nEND\n"
    port = HostPort(bench_of_sources({0: tokenizer.compile(source)}))
    port.sleep(0.05)
    port.send_break(0.0012)
    assert port.loader.phase is Phase.RUNNING
    assert output(port) == b"\x000"


def test_a_capacitor_makes_a_pulse_of_an_edge(images: dict[str, Image]) -> None:
    """DTR stays asserted, as Parallax's JavaScript programmer leaves it."""
    port = HostPort(bench_of_image(images["BS2"]), atn=Atn.CAPACITOR)
    assert output(port) == b"hello\r"
    port.dtr = True
    assert output(port) == b"hello\r"
    port.dtr = False
    assert output(port) == b""
    port.break_condition = True
    port.dtr = True
    port.sleep(0.06)
    port.break_condition = False
    port.sleep(0.02)
    port.reset_input_buffer()
    assert len(identify(port)) == 4


def test_ram_is_cleared_and_slot_0_runs_after_a_download(tokenizer: Tokenizer) -> None:
    first = tokenizer.compile("' {$STAMP BS2p}\nx VAR WORD\nx = 4711\nPUT 3, 9\nRUN 1\n").image
    second = tokenizer.compile("' {$STAMP BS2p}\nHIGH 2\nagain:\nPAUSE 1\nGOTO again\n").image
    shows = '\' {$STAMP BS2p}\nx VAR WORD\ny VAR BYTE\nGET 3, y\nDEBUG DEC x, " ", DEC y\nEND\n'
    port = HostPort(blank("BS2p"))
    download(port, packets_of(first))
    download(port, packets_of(second), slot=1)
    ask(port, b"\0", 0)
    port.sleep(0.1)
    assert (port.chip.slot, port.chip.registers["W0"], port.chip.pins.directions) == (1, 4711, 4)
    download(port, packets_of(tokenizer.compile(shows).image))
    assert port.chip.pins.directions == 0
    ask(port, b"\0", 0)
    assert output(port) == b"0 0"
    assert port.chip.slot == 0


def test_lines_of_the_source_hold_while_the_bytes_do(tokenizer: Tokenizer) -> None:
    compiled = tokenizer.compile(HELLO % "BS2")
    bench = bench_of_sources({0: compiled})
    port = HostPort(bench)
    download(port, packets_of(compiled.image))
    assert bench.programs["main"] == {0: compiled}
    download(port, [packet(3, b"\1" * 16)])
    assert not bench.programs.get("main")


# --- What goes wrong ----------------------------------------------------------------------------


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_garbage_never_keeps_a_download_from_working(data: st.DataObject) -> None:
    model = data.draw(st.sampled_from(sorted(ANSWERS)))
    port = HostPort(blank(model), timeout=0.1)
    steps: list[Callable[[], object]] = [
        lambda: port.write(data.draw(st.binary(max_size=40))),
        lambda: enter(port),
        lambda: identify_blindly(port, model),
        lambda: port.sleep(data.draw(st.sampled_from([0.0, 0.001, 0.02, 0.3]))),
        lambda: setattr(port, "dtr", data.draw(st.booleans())),
        lambda: setattr(port, "break_condition", data.draw(st.booleans())),
        lambda: setattr(port, "baudrate", data.draw(st.sampled_from([300, 9600, 19_200]))),
        lambda: port.read(data.draw(st.integers(0, 30))),
    ]
    for _ in range(data.draw(st.integers(1, 12))):
        data.draw(st.sampled_from(steps))()
    port.baudrate = 9600
    port.dtr = False
    port.reset_output_buffer()
    download(port, [packet(7, b"\x42" * 16)])
    assert port.chip.eeprom()[112:128] == b"\x42" * 16


def identify_blindly(port: HostPort, model: str) -> None:
    for byte in ANSWERS[model]:
        port.write(bytes([byte]))
        port.read(2)


def test_a_program_that_goes_astray_stops_until_the_next_reset(images: dict[str, Image]) -> None:
    astray = Image(chip("BS2"), b"\xff" * EEPROM_BYTES)
    port = HostPort(bench_of_image(astray))
    port.sleep(1)
    assert len(port.faults) == 1
    download(port, packets_of(images["BS2"]))
    ask(port, b"\0", 0)
    assert output(port) == b"hello\r"
    assert len(port.faults) == 1


def test_another_baud_rate_is_garbage() -> None:
    port = HostPort(blank("BS2"))
    port.baudrate = 19_200
    enter(port)
    port.write(b"B")
    port.sleep(0.1)
    assert port.read(9)[:1] == b"B"
    port.baudrate = 9600
    enter(port)
    assert len(identify(port)) == 4
    with pytest.raises(ValueError, match="no baud rate"):
        port.baudrate = 0


def test_time_goes_on_as_far_as_a_call_needs() -> None:
    """A character is 1/960 s; what has come already takes none."""
    port = HostPort(blank("BS2"))
    port.write(b"four")
    assert port.now_s() == 0
    port.flush()
    assert port.now_s() == pytest.approx(4 / 960, abs=1e-6)
    port.write(b"x")
    assert port.read(4) == b"four"
    assert port.now_s() == pytest.approx(4 / 960, abs=1e-6)
    assert port.read() == b"x"
    assert port.now_s() == pytest.approx(4.95 / 960, abs=1e-6)
    assert port.read() == b""
    assert port.now_s() == pytest.approx(4.95 / 960 + 0.2, abs=1e-6)
    port.sleep(-1)
    assert port.now_s() == pytest.approx(4.95 / 960 + 0.2, abs=1e-6)


def test_a_closed_port_lets_go_of_everything(images: dict[str, Image]) -> None:
    port = HostPort(bench_of_image(images["BS2"]))
    port.dtr = True
    port.break_condition = True
    port.sleep(0.1)
    port.close()
    port.run(port.bench.clock.now_ns + 500 * MS)
    assert port.uart.take().endswith(b"hello\r")
    with pytest.raises(BenchError, match="closed"):
        port.write(b"x")


def test_a_chip_has_one_port() -> None:
    bench = blank("BS2")
    HostPort(bench)
    with pytest.raises(BenchError, match="there is one of that name"):
        HostPort(bench)


def test_the_middle_of_a_download_can_be_gone_back_to(images: dict[str, Image]) -> None:
    port = HostPort(blank("BS2"))
    packets = packets_of(images["BS2"])
    download(port, packets[:1])
    port.write(packets[1][:7])
    port.sleep(0.004)
    moment = port.bench.snapshot()

    def rest() -> tuple[bytes, bytes]:
        port.sleep(0.1)
        port.write(packets[1][7:] + b"")
        port.sleep(0.1)
        for one in packets[2:]:
            port.write(one)
            port.sleep(0.1)
        port.write(b"\0")
        port.sleep(0.5)
        return port.uart.take(), port.chip.eeprom()

    first = rest()
    port.bench.restore(moment)
    assert rest() == first
    assert first[1] == images["BS2"].eeprom
    assert first[0].endswith(b"\0hello\r")
