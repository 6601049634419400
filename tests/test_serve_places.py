"""Ports of emulated chips: where they are, and `cgagen emulate --port`."""

import json
import os
import re
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from cgagen.cli import main
from cgagen.emulator.host_port import HostPort
from cgagen.errors import BenchError, RigError
from cgagen.flash import identify_port
from cgagen.serve import Address, serve
from cgagen.serve.endpoint import TcpEndpoint
from cgagen.serve.telnet import Rfc2217Endpoint
from tests.serve_clients import HELLO, LIMIT_S, connect, erased, heard


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


@contextmanager
def emulate(*words: str) -> Iterator[subprocess.Popen[str]]:
    process = subprocess.Popen(
        [sys.executable, "-m", "cgagen", "emulate", *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
        stdin=subprocess.DEVNULL,
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
        line = process.stdout.readline()
        assert line == f"  as a --port of cgagen: '{found[1]}?control={found[2]}'\n"
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
        assert row["port"] == f"{row['url']}?control={row['control']}"
        # What is printed can be typed: a reset by DTR, and the loader's BREAK, arrive there.
        assert identify_port(row["port"]).name == "BS2p24"


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
