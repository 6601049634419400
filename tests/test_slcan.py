"""The emulated rig's serial adapter."""

import os
import time

import pytest

from hil.messages import Op
from hil.rig import HEARTBEAT_S, SlcanPort
from hil.rig_protocol import Rig
from hil.slcan import SlcanAdapter
from tests.rig_cases import command, greeted


@pytest.fixture
def rig() -> Rig:
    return greeted()


def adapter(rig: Rig, *, opened: bool = True) -> SlcanAdapter:
    one = SlcanAdapter(rig)
    if opened:
        assert list(one.feed(b"S6\rO\r")) == [b"\r", b"\r"]
    return one


@pytest.mark.parametrize(
    ("line", "closed", "open_"),
    [
        ("", b"\r", b"\r"),
        ("S6", b"\r", b"\a"),
        ("S9", b"\a", b"\a"),
        ("s031C", b"\r", b"\a"),
        ("O", b"\r", b"\a"),
        ("L", b"\r", b"\a"),
        ("C", b"\a", b"\r"),
        ("V", b"V1013\r", b"V1013\r"),
        ("N", b"NCGAG\r", b"NCGAG\r"),
        ("F", b"\a", b"F00\r"),
        ("Z0", b"\r", b"\a"),
        ("Z2", b"\a", b"\a"),
        ("M00000000", b"\r", b"\a"),
        ("M0000", b"\a", b"\a"),
        ("t1230", b"\a", b"\r"),
        ("t8000", b"\a", b"\a"),
        ("t1239", b"\a", b"\a"),
        ("t12321", b"\a", b"\a"),
        ("t123111GG", b"\a", b"\a"),
        ("T000001230", b"\a", b"\r"),
        ("T200000000", b"\a", b"\a"),
        ("r1230", b"\a", b"\r"),
        ("R000001230", b"\a", b"\r"),
        ("x", b"\a", b"\a"),
        ("t" + "1" * 40, b"\a", b"\a"),
    ],
)
def test_the_adapter_obeys(rig: Rig, line: str, closed: bytes, open_: bytes) -> None:
    data = line.encode() + b"\r"
    assert b"".join(adapter(rig, opened=False).feed(data)) == closed
    assert b"".join(adapter(rig).feed(data)) == open_


def test_the_adapter_carries_frames_both_ways(rig: Rig) -> None:
    one = adapter(rig)
    hello = one.line_of(command(Op.HELLO, 1, 0xABCD))
    assert hello == b"t0808040100CDAB000000\r"
    lines = list(one.feed(hello))
    assert lines[0] == b"\r"
    assert lines[1].startswith(b"t0828CDAB0000")
    assert one.heartbeat().startswith(b"t0818")
    list(one.feed(b"C\r"))
    assert one.heartbeat() == b""


def test_the_adapter_takes_lines_in_pieces_and_survives_noise(rig: Rig) -> None:
    one = adapter(rig)
    hello = one.line_of(command(Op.HELLO, 1, 0xABCD))
    pieces = [answer for byte in hello for answer in one.feed(bytes([byte]))]
    assert len(pieces) == 4
    assert list(one.feed(bytes(range(14, 256)) * 40)) == []
    assert list(one.feed(b"\r")) == [b"\a"]
    assert len(list(one.feed(hello))) == 4


def test_the_adapter_stamps_and_only_listens_on_request(rig: Rig) -> None:
    one = SlcanAdapter(rig)
    assert b"".join(one.feed(b"Z1\rL\r")) == b"\r\r"
    assert list(one.feed(one.line_of(command(Op.HELLO))[:-5] + b"\r")) == [b"\a"]
    stamp = one.heartbeat()
    assert len(stamp) == len("t0818") + 16 + 4 + 1
    assert int(stamp[-5:-1], 16) == rig.time_ms % 60_000


@pytest.mark.parametrize("question", [b"", b"V\r"])
def test_the_rig_behind_it_gives_signs_of_life_whatever_is_asked(rig: Rig, question: bytes) -> None:
    heard = b""
    with SlcanPort(rig) as port:
        wire = os.open(port.url.removeprefix("can:slcan:"), os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        try:
            os.write(wire, b"S6\rO\r")
            until_s = time.monotonic() + 6 * HEARTBEAT_S
            while time.monotonic() < until_s:
                os.write(wire, question)
                time.sleep(HEARTBEAT_S / 8)
                try:
                    heard += os.read(wire, 4096)
                except BlockingIOError:
                    continue
        finally:
            os.close(wire)
    assert heard.count(b"t0818") >= 3
    assert (b"V1013\r" in heard) == bool(question)
