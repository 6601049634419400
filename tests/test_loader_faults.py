"""The loader in the chip's ROM: garbage, other speeds, closed ports, and going back in time."""

from collections.abc import Callable

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cgagen.emulator.host_port import HostPort
from cgagen.emulator.loader import Atn
from cgagen.emulator.programs import bench_of_image
from cgagen.errors import BenchError
from cgagen.stamp.chips import CHIPS, EEPROM_BYTES, chip
from cgagen.stamp.image import Image
from cgagen.stamp.packets import packet, packets_of
from cgagen.tokenizer import Tokenizer
from tests.loader_dialogue import ANSWERS, HELLO, MS, ask, blank, download, enter, identify, output


@pytest.fixture(scope="module")
def images(tokenizer: Tokenizer) -> dict[str, Image]:
    return {row.name: tokenizer.compile(HELLO % row.directive).image for row in CHIPS}


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
    port = HostPort(bench_of_image(images["BS2"]), atn=Atn.DIRECT)
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
