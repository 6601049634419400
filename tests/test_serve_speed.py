"""The speed that a host sets, as a telnet option: what a program's own SERIN and SEROUT need."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
import serial

from cgagen.emulator.programs import bench_of_image
from cgagen.link.port import open_port
from cgagen.monitor.rates import slower_rate
from cgagen.serve import Server, serve
from cgagen.stamp.serial_mode import SerialMode
from cgagen.tokenizer import Tokenizer
from tests.serve_clients import LIMIT_S

ECHO = """\
' {{$STAMP BS2}}
x VAR Byte
again:
SERIN 16, {word}, [x]
SEROUT 16, {word}, ["<", x, ">"]
GOTO again
"""


def served(tokenizer: Tokenizer, word: int) -> Server:
    return serve(bench_of_image(tokenizer.compile(ECHO.format(word=word)).image), "rfc2217:0")


@pytest.mark.parametrize(
    ("word", "mode"),
    [
        (3313, SerialMode(300)),
        (396, SerialMode(2400)),
        (396 + 0x2000, SerialMode(2400, True)),
        (32, SerialMode(19_200)),
        (84 + 0x2000, SerialMode(9600, True)),
    ],
)
def test_a_host_speaks_in_the_mode_that_it_sets(
    tokenizer: Tokenizer, word: int, mode: SerialMode
) -> None:
    told: list[tuple[SerialMode, SerialMode]] = []
    with served(tokenizer, word) as server:
        paced = server.endpoints[0].port
        paced.on_other_rate = lambda sent, heard: told.append((sent, heard))
        port = open_port(server.url, *mode)
        try:
            port.timeout = LIMIT_S
            for sign in (b"A", b"z"):
                port.write(sign)
                assert port.read(4) == sign + b"<" + sign + b">"
            assert paced.mode == mode
        finally:
            port.close()
    assert (server.failure, told) == (None, [])


def test_bytes_in_one_write_are_as_far_apart_as_at_any_rate(tokenizer: Tokenizer) -> None:
    """A character takes its time at the host's rate, and a gap follows it as at 9,600 baud."""
    source = "' {$STAMP BS2}\nSERIN 16, 396, [B0]\nSERIN 16, 396, [B1]\nSEROUT 16, 396, [B1, B0]\n"
    with serve(bench_of_image(tokenizer.compile(source).image), "rfc2217:0") as server:
        port = open_port(server.url, 2400)
        try:
            port.timeout = LIMIT_S
            port.write(b"ab")
            assert port.read(4) == b"abba"
        finally:
            port.close()


def test_a_host_at_another_rate_is_told_which_would_fit(tokenizer: Tokenizer) -> None:
    told: list[tuple[SerialMode, SerialMode]] = []
    source = '\' {$STAMP BS2}\nagain: SEROUT 16, 396, ["Hello, world", 13]\nGOTO again\n'
    with serve(bench_of_image(tokenizer.compile(source).image), "rfc2217:0") as server:
        server.endpoints[0].port.on_other_rate = lambda *modes: told.append(modes)
        port = open_port(server.url)
        try:
            port.timeout = LIMIT_S
            assert slower_rate(port.read(400), 9600) == 2400
            port.baudrate = 2400
            port.reset_input_buffer()
            assert b"Hello, world\rHello" in port.read(60)
        finally:
            port.close()
    assert told == [(SerialMode(2400), SerialMode(9600))]


@pytest.mark.parametrize(("name", "value"), [("parity", serial.PARITY_ODD), ("stopbits", 2)])
def test_what_no_stamp_has_is_not_taken(tokenizer: Tokenizer, name: str, value: object) -> None:
    with served(tokenizer, 84) as server:
        port = server.endpoints[0].port
        with pytest.raises(ValueError, match="8N1 or 7E1"):
            setattr(port, name, value)
        assert port.mode == SerialMode()


def test_both_verbs_have_the_option(tmp_path: Path) -> None:
    """`emulate --port --baud` for hosts without a speed, and `monitor --baud`, each alone."""
    source = tmp_path / "slow.bs2"
    source.write_text('\' {$STAMP BS2}\nagain: SEROUT 16, 396, ["Hello, world", 13]\nGOTO again\n')
    command = [sys.executable, "-m", "cgagen"]
    for place, serving, listening, wanted in (
        ("tcp:0", ["--baud", "2400"], [], b"Hello, world\r"),
        ("rfc2217:0", [], ["--baud", "2400"], b"Hello, world\r"),
        ("rfc2217:0", [], [], b""),
    ):
        server = subprocess.Popen(
            [*command, "emulate", source, "--port", place, "--realtime", *serving],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        assert server.stdout is not None
        url = re.split(rb"\s+", server.stdout.readline())[1].decode()
        monitor = [*command, "monitor", "--port", url, "--for", "2s", "--input", "", *listening]
        ran = subprocess.run(
            monitor,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            check=False,
            timeout=LIMIT_S,
        )
        server.terminate()
        _, err = server.communicate(timeout=LIMIT_S)
        assert ran.returncode == 0
        if wanted:
            assert wanted in ran.stdout
            assert b"would fit" not in ran.stderr
        else:
            assert b"(--baud: 2400 would fit)" in ran.stderr
            assert b"main sends at 2400, and who is on its port listens at 9600" in err
