"""Ports of emulated chips on sockets and ptys: what a client can do with them."""

import time

import pytest
import serial

from cgagen.emulator.bench import Bench
from cgagen.emulator.loader import Atn, Phase
from cgagen.emulator.programs import bench_of_image, bench_of_sources
from cgagen.serve import serve
from cgagen.stamp.image import Image
from cgagen.tokenizer import Tokenizer
from tests.serve_clients import HELLO, LIMIT_S, TALKS, client_of, connect, erased, heard, until

KINDS = ["rfc2217:0", "tcp:0", "pty"]


@pytest.fixture(scope="module")
def hello(tokenizer: Tokenizer) -> Image:
    return tokenizer.compile(HELLO).image


@pytest.mark.parametrize("place", KINDS)
def test_a_program_is_loaded_and_talks(place: str, hello: Image) -> None:
    bench = erased()
    with serve(bench, place) as server:
        with client_of(server) as client:
            client.download(hello)
            assert client.ask(b"\0", 6) == b"hello\r"
        until(lambda: not server.endpoints[0].present)
        with client_of(server) as client:
            client.line("DTR", True)
            client.line("DTR", False)
            assert client.port.read(6) == b"hello\r"
    assert server.failure is None
    assert bench.chip("main").eeprom() == hello.eeprom


def test_both_chips_of_a_bench_are_served_at_once(tokenizer: Tokenizer) -> None:
    from cgagen.emulator.chip import Chip

    bench = Bench()
    for name in ("main", "legs"):
        source = f'\' {{$STAMP BS2}}\nDEBUG "{name}"\nEND\n'
        bench.add_chip(Chip(name, [tokenizer.compile(source).image], bench.clock))
    with serve(bench, {"legs": "tcp:0", "main": "rfc2217:0"}) as server:
        port = serial.serial_for_url(server.endpoints[1].url, timeout=LIMIT_S, do_not_open=True)
        port.dtr = False
        with connect(server.endpoints[0].url) as legs, port:
            assert heard(legs, 4) == b"legs"
            port.dtr = True
            port.dtr = False
            assert port.read(4) == b"main"
    assert server.failure is None


def test_pyserial_sets_speed_lines_and_purges(hello: Image) -> None:
    server = serve(bench_of_image(hello), "rfc2217:0", atn=Atn.DIRECT)
    with server, client_of(server) as client:
        port = server.endpoints[0].port.port
        client.port.baudrate = 19_200
        assert port.baudrate == 19_200
        client.port.baudrate = 9600
        client.port.dtr = True
        assert port.loader.phase is Phase.HELD
        client.port.rts = True
        client.port.dtr = False
        assert client.port.read(6) == b"hello\r"
        assert port.loader.phase is Phase.RUNNING
        client.port.send_break(0.01)
        assert not port.break_condition
        client.port.timeout = 0.01
        client.port.reset_output_buffer()
        client.port.reset_input_buffer()
        assert not client.port.cts
        assert client.port.read(100) == b""
    assert server.failure is None


def test_dtr_that_stays_asserted_holds_the_chip_until_the_client_goes(hello: Image) -> None:
    with serve(bench_of_image(hello), "rfc2217:0", atn=Atn.DIRECT) as server:
        loader = server.endpoints[0].port.port.loader
        with serial.serial_for_url(server.url, timeout=0.05) as port:
            port.reset_input_buffer()
            assert port.read(6) == b""
            assert loader.phase is Phase.HELD
        until(lambda: not server.endpoints[0].present)
        assert loader.phase is Phase.RUNNING


def test_time_begins_with_a_host_and_stands_still_without(tokenizer: Tokenizer) -> None:
    bench = bench_of_sources({0: tokenizer.compile(TALKS)})
    with serve(bench, "tcp:0") as server:
        time.sleep(0.03)
        assert bench.clock.now_ns == 0
        with connect(server.url) as host:
            assert host.recv(9)
        until(lambda: not server.endpoints[0].present)
        stopped_ns = bench.clock.now_ns
        time.sleep(0.03)
        assert bench.clock.now_ns == stopped_ns > 0


def test_real_time_is_not_overtaken(tokenizer: Tokenizer) -> None:
    bench = bench_of_sources({0: tokenizer.compile(TALKS)})
    with serve(bench, "tcp:0", realtime=True) as server:
        began_s = time.monotonic()
        with connect(server.url) as host:
            assert len(heard(host, 60)) == 60
        until(lambda: not server.endpoints[0].present)
        assert bench.clock.now_ns / 1e9 < time.monotonic() - began_s + 0.01


def test_a_run_ends_at_the_limit_of_its_time(tokenizer: Tokenizer) -> None:
    bench = bench_of_sources({0: tokenizer.compile(TALKS)})
    server = serve(bench, "tcp:0")
    with connect(server.url):
        server.run(limit_ns=50_000_000)
    server.close()
    assert bench.clock.now_ns == 50_000_000
