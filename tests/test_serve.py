"""Ports of emulated chips on sockets and ptys, with pyserial and plain sockets as clients."""

import json
import os
import random
import re
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest
import serial

from cgagen.cli import main
from cgagen.emulator.bench import Bench
from cgagen.emulator.host_port import HostPort
from cgagen.emulator.loader import Phase
from cgagen.emulator.programs import bench_of_image, bench_of_sources
from cgagen.errors import BenchError, RigError
from cgagen.serve import Address, Server, serve
from cgagen.serve.endpoint import TcpEndpoint
from cgagen.serve.telnet import Rfc2217Endpoint
from cgagen.stamp.chips import EEPROM_BYTES, chip
from cgagen.stamp.image import Image
from cgagen.stamp.packets import packet, packets_of
from cgagen.tokenizer import Tokenizer

LIMIT_S = 60
"""How long a client waits for what must come; nothing is judged by how soon it comes."""

HELLO = '\' {$STAMP BS2}\nDEBUG "hello", CR\nEND\n'
TALKS = '\' {$STAMP BS2}\nagain:\nDEBUG "0123456789abcdefghijklmnopqrstuvwxyz"\nGOTO again\n'
KINDS = ["rfc2217:0", "tcp:0", "pty"]


def erased(model: str = "BS2") -> Bench:
    return bench_of_image(Image(chip(model), bytes(EEPROM_BYTES)))


@pytest.fixture(scope="module")
def hello(tokenizer: Tokenizer) -> Image:
    return tokenizer.compile(HELLO).image


class Client:
    """A computer with a port: pyserial's, and the socket with DTR and BREAK where it has none."""

    def __init__(self, server: Server) -> None:
        self.hand: socket.socket | None = None
        if server.control is not None:
            self.hand = connect(server.control)
        self.port = serial.serial_for_url(server.url, do_not_open=True)
        self.port.baudrate, self.port.timeout = 9600, LIMIT_S
        with suppress(OSError, ValueError):
            self.port.dtr = self.port.rts = False
        self.port.open()

    def line(self, name: str, on: bool) -> None:
        if self.hand is None:
            setattr(self.port, "dtr" if name == "DTR" else "break_condition", on)
            return
        said = f"{name} {int(on)}\n".encode()
        self.hand.sendall(said)
        assert self.hand.recv(64) == said

    def enter(self) -> None:
        for name, on in (("BREAK", True), ("DTR", True), ("DTR", False), ("BREAK", False)):
            self.line(name, on)
        time.sleep(0.01)
        self.port.reset_input_buffer()

    def ask(self, data: bytes, answers: int = 1) -> bytes:
        self.port.write(data)
        found: bytes = self.port.read(len(data) + answers)
        assert found[: len(data)] == data
        return found[len(data) :]

    def download(self, image: Image) -> None:
        self.enter()
        assert b"".join(self.ask(bytes([byte])) for byte in b"BS2\0") == b"\xbe\xad\xce\x10"
        for one in packets_of(image):
            assert self.ask(one) == b"\0"

    def close(self) -> None:
        self.port.close()
        if self.hand is not None:
            self.hand.close()


def connect(address: str) -> socket.socket:
    host, _, number = address.rpartition("/")[2].rpartition(":")
    return socket.create_connection((host, int(number)), LIMIT_S)


def heard(host: socket.socket, count: int) -> bytes:
    found = b""
    while len(found) < count and (piece := host.recv(count - len(found))):
        found += piece
    return found


@contextmanager
def client_of(server: Server) -> Iterator[Client]:
    client = Client(server)
    try:
        yield client
    finally:
        client.close()


def until(true: Callable[[], object]) -> None:
    """Wait for something that another thread brings about."""
    end = time.monotonic() + LIMIT_S
    while not true():
        assert time.monotonic() < end, "it never came"
        time.sleep(0.005)


# --- What works ---------------------------------------------------------------------------------


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
    with serve(bench_of_image(hello), "rfc2217:0") as server, client_of(server) as client:
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
    with serve(bench_of_image(hello), "rfc2217:0") as server:
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


# --- DTR and BREAK as text ----------------------------------------------------------------------


def test_lines_of_text_come_back_when_they_have_taken_effect() -> None:
    with serve(erased(), "tcp:0") as server:
        assert server.control is not None
        port = server.endpoints[0].port.port
        with connect(server.control) as hand, hand.makefile("rwb") as text:

            def say(line: bytes) -> bytes:
                text.write(line)
                text.flush()
                return text.readline()

            assert say(b"break 1\r\n") == b"BREAK 1\n"
            assert port.break_condition
            assert say(b"DTR 1\n") == b"DTR 1\n"
            assert port.loader.phase is Phase.HELD
            assert say(b"DTR 0\n") == b"DTR 0\n"
            assert say(b"BREAK 0\n") == b"BREAK 0\n"
            assert port.loader.phase is Phase.IDENTIFY
            for wrong in (b"DTR\n", b"DTR 2\n", b"\n", b"\xff\xfe\n", b"x" * 500 + b"\n"):
                assert say(wrong).startswith(b"ERROR say DTR 0")
            while text.readable() and say(b"DTR 1\n") != b"DTR 1\n":
                pass
        until(lambda: not port.dtr)
    assert server.failure is None


def test_bytes_that_were_sent_before_a_line_come_before_it(hello: Image) -> None:
    """The end of a download and the reset behind it, without waiting for anything."""
    with serve(erased(), "tcp:0") as server, client_of(server) as client:
        client.download(hello)
        port = server.endpoints[0].port.port
        assert client.hand is not None
        client.port.write(packet(3, b"\x33" * 16))
        client.hand.sendall(b"DTR 1\nDTR 0\n")
        answers = b""
        while answers.count(b"\n") < 2:
            answers += client.hand.recv(64)
        assert port.chip.eeprom()[48:64] == bytes(16)  # the reset came while it burned
        assert port.read(0) == b""
        assert client.port.read(18) == packet(3, b"\x33" * 16)


def test_even_if_the_line_is_looked_at_first() -> None:
    server = serve(erased(), "tcp:0")
    with connect(server.url) as data, connect(str(server.control)) as hand:
        while len(server.endpoints[0].wanted()) < 4:  # two that listen, two hosts
            server.turn()
        data.sendall(b"B")
        hand.sendall(b"DTR 1\n")
        server.endpoints[0]._hand_ready()  # type: ignore[attr-defined]
        assert data.recv(9) == b"B"
        assert hand.recv(9) == b"DTR 1\n"
    server.close()


def test_the_echo_of_a_break_comes_before_its_answer() -> None:
    """So a host that throws its input away behind the answer throws it away too."""
    server = serve(erased(), "rfc2217:0")
    with connect(server.url) as host:
        while not server.endpoints[0].present:
            server.turn()
        assert host.recv(1_000).startswith(b"\xff")  # what the server can do
        host.sendall(b"\xff\xfa\x2c\x05\x05\xff\xf0")
        while not server.endpoints[0].port.break_condition:
            server.turn()
        answer = b"\xff\xfa\x2c\x69\x05\xff\xf0"
        assert heard(host, 1 + len(answer)) == b"\0" + answer
    server.close()


def test_what_a_host_left_unsent_is_not_sent(hello: Image) -> None:
    server = serve(bench_of_image(hello), "tcp:0")
    port = server.endpoints[0].port.port
    port.baudrate = 300
    with connect(server.url) as data:
        data.sendall(b"x" * 200)
        while not port.out_waiting:
            server.turn()
    while server.endpoints[0].present:
        server.turn()
    assert not port.out_waiting
    server.close()


# --- What goes wrong ----------------------------------------------------------------------------


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


def test_a_host_that_does_not_read_stops_the_chips_time(tokenizer: Tokenizer) -> None:
    bench = bench_of_sources({0: tokenizer.compile(TALKS)})
    with serve(bench, "tcp:0") as server, connect(server.url) as host:
        endpoint = server.endpoints[0]
        endpoint.outgoing = lambda data: data * 10_000
        until(lambda: endpoint.full)
        stood_ns = bench.clock.now_ns
        time.sleep(0.05)
        assert bench.clock.now_ns == stood_ns
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


# --- Where --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "word", ["", "x", "tcp:70000", "pty:3", "udp:0", "tcp:a:b:3", "rfc2217:-1"]
)
def test_a_place_that_is_none(word: str) -> None:
    with pytest.raises(RigError, match=r"say rfc2217:0, tcp:0 or pty"):
        Address.parse(word)


def test_a_place_that_is_taken_or_not_here() -> None:
    with socket.create_server(("127.0.0.1", 0)) as other:
        with pytest.raises(RigError, match="cannot be listened on"):
            serve(erased(), f"tcp:{other.getsockname()[1]}")
    with pytest.raises(RigError, match="cannot be listened on"):
        serve(erased(), "rfc2217:192.0.2.1:0")


def test_only_this_machine_can_reach_it() -> None:
    server = serve(erased(), "tcp:0")
    assert server.url.startswith("socket://127.0.0.1:")
    assert str(server.control).startswith("127.0.0.1:")
    server.close()


def test_a_chip_with_a_port_already() -> None:
    bench = erased()
    HostPort(bench)
    with pytest.raises(BenchError, match="one of that name"):
        serve(bench)
    with pytest.raises(BenchError, match="no such chip"):
        serve(erased(), {"main": "tcp:0", "legs": "tcp:0"})


def test_kinds_and_classes() -> None:
    for word, kind in (("tcp:0", TcpEndpoint), ("rfc2217", Rfc2217Endpoint)):
        server = serve(erased(), word)
        assert isinstance(server.endpoints[0], kind)
        server.close()


# --- cgagen emulate --port ----------------------------------------------------------------------


@contextmanager
def emulate(*words: str) -> Iterator[subprocess.Popen[str]]:
    process = subprocess.Popen(
        [sys.executable, "-m", "cgagen", "emulate", *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
    )
    with process:
        try:
            yield process
        finally:
            process.kill()


def test_the_verb_prints_where_and_serves(tmp_path: Path) -> None:
    source = tmp_path / "hello.bs2"
    source.write_text(HELLO)
    with emulate(str(source), "--port", "tcp:0") as process:
        assert process.stdout is not None
        assert process.stderr is not None
        line = process.stdout.readline()
        found = re.fullmatch(r"main: (socket://\S+)  DTR and BREAK: (127\.0\.0\.1:\d+)\n", line)
        assert found, line
        with connect(found[1]) as host:
            assert heard(host, 6) == b"hello\r"
        process.send_signal(signal.SIGINT)
        assert "Ctrl-C" in process.stderr.read()
        assert process.wait(LIMIT_S) == 0


def test_the_verb_in_json_with_an_erased_chip() -> None:
    with emulate("--model", "BS2p", "--port", "pty", "--json") as process:
        assert process.stdout is not None
        told = json.loads(process.stdout.readline())
        (row,) = told["ports"]
        assert (told["file"], row["chip"]) == (None, "main")
        assert row["url"].startswith("/dev/")
        assert row["control"].startswith("127.0.0.1:")


@pytest.mark.parametrize(
    ("words", "code", "sentence"),
    [
        (["--port", "tcp:0"], 2, "the --model of an erased chip"),
        ([], 2, "Missing argument 'FILE'"),
        (["--model", "BS2", "--port", "nowhere"], 7, "is no place for a port"),
        (["--model", "BS3", "--port", "tcp:0"], 3, "no model 'BS3'"),
        (["--model", "BS2", "--port", "legs=tcp:0"], 3, "no such chip"),
        (["--model", "BS2", "--port", "tcp:0", "--port", "pty"], 2, "has one port"),
        (["--model", "BS2", "--port", "tcp:0", "--input", "x"], 2, "exclude each other"),
        (["--model", "BS2", "--port", "tcp:0", "--expect-end"], 2, "exclude each other"),
        (["--model", "BS2", "--port", "tcp:0", "--durations", "a"], 2, "exclude each other"),
    ],
)
def test_wrong_words(
    words: list[str], code: int, sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["emulate", *words]) == code
    assert sentence in capsys.readouterr().err
