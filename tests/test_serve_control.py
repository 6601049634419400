"""Ports of emulated chips: DTR and BREAK as lines of text, in step with the bytes."""

import pytest

from cgagen.emulator.loader import Atn, Phase
from cgagen.emulator.programs import bench_of_image
from cgagen.serve import serve
from cgagen.stamp.image import Image
from cgagen.stamp.packets import packet
from cgagen.tokenizer import Tokenizer
from tests.serve_clients import HELLO, client_of, connect, erased, heard, until


@pytest.fixture(scope="module")
def hello(tokenizer: Tokenizer) -> Image:
    return tokenizer.compile(HELLO).image


def test_lines_of_text_come_back_when_they_have_taken_effect() -> None:
    with serve(erased(), "tcp:0", atn=Atn.DIRECT) as server:
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
        _, _, (_, line_is_ready), _ = server.endpoints[0].wanted().values()
        line_is_ready()
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
    with connect(server.url):
        while not server.endpoints[0].present:
            server.turn()
        port.write(b"x" * 200)
        assert port.out_waiting
    while server.endpoints[0].present:
        server.turn()
    assert not port.out_waiting
    server.close()
