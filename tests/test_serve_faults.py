"""Ports of emulated chips: clients that go, babble or do not read, and faults of the server."""

import random
import socket
import struct
import threading
import time
from contextlib import suppress

import pytest

from cgagen.emulator.bench import Bench
from cgagen.emulator.programs import bench_of_image, bench_of_sources
from cgagen.serve import serve
from cgagen.stamp.chips import EEPROM_BYTES, chip
from cgagen.stamp.image import Image
from cgagen.stamp.packets import packet, packets_of
from cgagen.tokenizer import Tokenizer
from tests.serve_clients import HELLO, LIMIT_S, TALKS, client_of, connect, erased, until


@pytest.fixture(scope="module")
def hello(tokenizer: Tokenizer) -> Image:
    return tokenizer.compile(HELLO).image


@pytest.mark.parametrize("place", ["rfc2217:0", "tcp:0"])
def test_who_comes_second_is_let_go(place: str, hello: Image) -> None:
    with serve(bench_of_image(hello), place) as server, client_of(server) as client:
        with connect(server.url) as second:
            assert second.recv(9) == b""
        if server.control is not None:
            with connect(server.control) as second:
                assert second.recv(9) == b""
        client.download(hello)
    assert server.failure is None


def test_who_leaves_and_comes_back_at_once_is_let_in(hello: Image) -> None:
    with serve(bench_of_image(hello), "tcp:0") as server:
        assert server.control is not None
        for _ in range(40):
            with connect(server.control) as hand, connect(server.url) as data:
                hand.sendall(b"DTR 1\nDTR 0\n")
                assert hand.recv(1) == b"D"
                assert data.recv(1)
    assert server.failure is None


@pytest.mark.parametrize("abrupt", [False, True])
def test_a_host_that_goes_away_at_any_byte(abrupt: bool, hello: Image) -> None:
    """After whatever it has left behind, the next one can load a program."""
    script = b"".join([b"BS2\0", *packets_of(hello), b"\0"])
    bench = erased()
    with serve(bench, "tcp:0") as server:
        for length in range(len(script) + 1):
            with connect(str(server.control)) as hand, connect(server.url) as data:
                for line in (b"BREAK 1\n", b"DTR 1\n", b"DTR 0\n", b"BREAK 0\n"):
                    hand.sendall(line)
                    assert hand.recv(64) == line
                data.sendall(script[:length])
                if abrupt:  # a reset of the connection instead of its end
                    data.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            if length % 7 == 0:
                with client_of(server) as client:
                    client.download(hello)
                    assert client.ask(b"\0", 6) == b"hello\r"
    assert server.failure is None
    assert bench.chip("main").eeprom() == hello.eeprom


@pytest.mark.parametrize("place", ["rfc2217:0", "tcp:0"])
def test_garbage_on_every_socket(place: str, hello: Image) -> None:
    chance = random.Random(5)
    telnet = b"\xff\xfa\x2c"
    bench = erased()
    with serve(bench, place) as server:
        addresses = [address for address in (server.url, server.control) if address]
        pieces = [chance.randbytes(chance.randrange(1, 300)) for _ in range(20)]
        pieces += [telnet + chance.randbytes(chance.randrange(6)) + b"\xff\xf0" for _ in range(40)]
        pieces += [
            b"\xff\xf0",
            telnet + b"\x01" * 2000,
            b"\xff",
            telnet,
            b"\xff\xfd\x2c\xff\xfb\x01",
        ]
        pieces += [telnet + bytes([1, code]) + b"\xff\xf0" for code in range(15)]
        for piece in pieces:
            for address in addresses:
                with connect(address) as host, suppress(ConnectionError):
                    host.sendall(piece)
        with client_of(server) as client:
            client.download(hello)
            assert client.ask(b"\0", 6) == b"hello\r"
    assert server.failure is None


def test_a_telnet_option_without_an_end_is_cut_off() -> None:
    with serve(erased(), "rfc2217:0") as server, connect(server.url) as host:
        host.sendall(b"\xff\xfa\x2c" + b"\x01" * 1_000)
        with suppress(ConnectionError):
            while host.recv(1_000):
                pass
    assert server.failure is None


def stands(bench: Bench) -> bool:
    before_ns = bench.clock.now_ns
    time.sleep(0.05)
    return bench.clock.now_ns == before_ns


def test_a_host_that_does_not_read_stops_the_chips_time(tokenizer: Tokenizer) -> None:
    bench = bench_of_sources({0: tokenizer.compile(TALKS)})
    with serve(bench, "tcp:0") as server, connect(server.url) as host:
        endpoint = server.endpoints[0]
        endpoint.outgoing = lambda data: data * 10_000
        until(lambda: endpoint.full)
        until(lambda: stands(bench))
        stood_ns = bench.clock.now_ns
        while bench.clock.now_ns == stood_ns:
            assert host.recv(1 << 20)
    assert server.failure is None


def test_a_program_that_goes_astray_is_not_the_end(hello: Image) -> None:
    bench = bench_of_image(Image(chip("BS2"), b"\xff" * EEPROM_BYTES))
    with serve(bench, "tcp:0") as server, client_of(server) as client:
        faults = server.endpoints[0].port.port.faults
        until(lambda: faults)
        client.download(hello)
        assert client.ask(b"\0", 6) == b"hello\r"
    assert server.failure is None
    assert len(faults) == 1


def test_a_bug_of_ours_lets_the_host_go_and_is_told(hello: Image) -> None:
    with serve(bench_of_image(hello), "tcp:0") as server:
        both = threading.Event()

        def broken(_data: bytes) -> bytes:
            if both.is_set():
                raise ZeroDivisionError("nobody thought of it")
            return b""

        server.endpoints[0].outgoing = broken
        with connect(server.url) as host, connect(str(server.control)) as hand:
            both.set()
            host.sendall(b"?")  # comes back by the wiring, whole or spoiled by what the chip says
            with suppress(ConnectionError):
                assert host.recv(9) == b""
            with suppress(ConnectionError):
                assert hand.recv(9) == b""
        with pytest.raises(ConnectionRefusedError):
            connect(server.url)
    assert isinstance(server.failure, ZeroDivisionError)


def test_half_a_packet_and_a_host_that_waits(hello: Image) -> None:
    with serve(erased(), "tcp:0") as server, client_of(server) as client:
        client.download(hello)
        client.port.timeout = 0.2
        client.port.write(packet(0, bytes(16))[:7])
        assert len(client.port.read(19)) == 7
        client.port.timeout = LIMIT_S
        client.download(hello)
