"""The loader in the chip's ROM: what a reset, with and without BREAK, does."""

import pytest

from cgagen.emulator.host_port import HostPort
from cgagen.emulator.loader import Atn, Phase
from cgagen.emulator.programs import bench_of_image, bench_of_sources
from cgagen.stamp.chips import CHIPS
from cgagen.stamp.image import Image
from cgagen.stamp.packets import packet, packets_of
from cgagen.tokenizer import Tokenizer
from tests.loader_dialogue import HELLO, ask, blank, download, enter, identify, output


@pytest.fixture(scope="module")
def images(tokenizer: Tokenizer) -> dict[str, Image]:
    return {row.name: tokenizer.compile(HELLO % row.directive).image for row in CHIPS}


def test_a_reset_without_break_runs_the_program(images: dict[str, Image]) -> None:
    port = HostPort(bench_of_image(images["BS2"]))
    assert output(port) == b"hello\r"
    port.dtr = True
    port.sleep(0.005)
    port.dtr = False
    assert output(port) == b"hello\r"


def test_while_dtr_is_asserted_nothing_runs(tokenizer: Tokenizer) -> None:
    source = '\' {$STAMP BS2}\nHIGH 3\nagain:\nDEBUG "x"\nGOTO again\n'
    port = HostPort(bench_of_sources({0: tokenizer.compile(source)}), atn=Atn.DIRECT)
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
    port = HostPort(bench_of_image(images["BS2"]), atn=Atn.DIRECT)
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
    port = HostPort(bench_of_image(images["BS2"]))
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
