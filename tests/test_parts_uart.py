"""Serial peers: bits at a baud rate, both ways, and the echo of the programming port."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cgagen.emulator.clock import Clock
from cgagen.emulator.parts.probe import Probe
from cgagen.emulator.parts.uart import Uart
from cgagen.emulator.wires import Wire

MS = 1_000_000


def pair(clock: Clock, **settings: int) -> tuple[Uart, Uart]:
    """Two that are joined crosswise."""
    to, fro = Wire("to"), Wire("fro")
    return (
        Uart("pc", clock, to, fro, **settings),  # type: ignore[arg-type]
        Uart("peer", clock, fro, to, **settings),  # type: ignore[arg-type]
    )


@pytest.mark.parametrize("mark", [0, 1])
def test_a_byte_on_the_line(mark: int) -> None:
    """'A' = 41h, least significant bit first: start 0, 1000 0010, stop 1; 1/9600 s each."""
    clock, wire = Clock(), Wire("line")
    uart = Uart("pc", clock, wire, None, mark=mark)
    probe = Probe("probe", clock, wire)
    uart.send(b"A")
    clock.run_until(10 * MS)
    bit_ns = 1e9 / 9600
    edges = [(round(edge.time_ns / bit_ns, 3), edge.level == mark) for edge in probe.edges]
    assert edges == [(0, True), (0, False), (1, True), (2, False), (7, True), (8, False), (9, True)]


@given(st.binary(max_size=40), st.sampled_from([300, 2400, 9600, 19_200, 115_200]))
def test_all_bytes_arrive_both_ways(data: bytes, baud: int) -> None:
    clock = Clock()
    pc, peer = pair(clock, baud=baud)
    pc.send(data)
    peer.send(data[::-1])
    clock.run_until(len(data) * 10_000_000_000 // baud + 10 * MS)
    assert (peer.take(), pc.take(), peer.received) == (data, data[::-1], b"")
    assert (peer.errors, pc.errors, pc.sent, pc.waiting, pc.sending) == (0, 0, len(data), 0, False)


def test_bytes_follow_each_other_without_a_gap() -> None:
    clock = Clock()
    pc, peer = pair(clock)
    pc.send(bytes(9600 // 10))
    clock.run_until(1_000_000_000)
    assert len(peer.received) == 960


def test_seven_bits_and_even_parity() -> None:
    clock = Clock()
    wire = Wire("line")
    pc = Uart("pc", clock, wire, None, seven_even=True)
    peer = Uart("peer", clock, None, wire, seven_even=True)
    probe = Probe("probe", clock, wire)
    pc.send(b"C")  # 43h: three ones, parity 1
    clock.run_until(10 * MS)
    assert peer.received == b"C"
    bit_ns = 1e9 / 9600
    assert [round(edge.time_ns / bit_ns) for edge in probe.edges[1:]] == [0, 1, 3, 7]


def test_wrong_parity_and_breaks_are_counted() -> None:
    clock, wire = Clock(), Wire("line")
    sender = Uart("pc", clock, wire, None)
    even = Uart("peer", clock, None, wire, seven_even=True)
    sender.send(b"\x01")
    clock.run_until(10 * MS)
    assert (even.received, even.errors) == (b"", 1)
    wire.drive("pc", 0)
    clock.run_until(100 * MS)
    wire.drive("pc", 1)
    assert (even.received, even.errors) == (b"", 2)
    sender.send(b"\x03")
    clock.run_until(200 * MS)
    assert even.received == b"\x03"


def test_a_glitch_is_no_byte() -> None:
    clock, wire = Clock(), Wire("line", pull=1)
    uart = Uart("peer", clock, None, wire)
    wire.drive("x", 0)
    clock.run_until(10_000)
    wire.drive("x", 1)
    clock.run_until(10 * MS)
    assert (uart.received, uart.errors) == (b"", 0)


def test_what_is_sent_comes_back_and_mixes_with_what_the_chip_sends() -> None:
    """On the port a space is 1 and driven, so the bytes of both come out as their AND."""
    clock, sin, sout = Clock(), Wire("SIN", pull=0), Wire("SOUT", pull=0)
    pc = Uart("pc", clock, sin, sout, mark=0, echo=True)
    pc.send(b"hello")
    clock.run_until(10 * MS)
    assert pc.take() == b"hello"
    chip = Uart("chip", clock, None, None)
    bits = (0, *(0xF0 >> place & 1 for place in range(8)), 1)
    start_ns = clock.now_ns
    for number, bit in enumerate(bits):
        clock.at(
            start_ns + number * 1_000_000_000 // 9600,
            lambda bit=bit: sout.drive("chip.SOUT", None if bit else 1),  # type: ignore[misc]
        )
    pc.send(b"\x3c")
    clock.run_until(20 * MS)
    assert pc.take() == b"\x30"
    assert chip.sent == 0


def test_it_waits_until_it_may_send() -> None:
    clock = Clock()
    pc, peer = pair(clock)
    allowed: list[bool] = []
    pc.may_send = lambda: bool(allowed)
    pc.send(b"ab")
    clock.run_until(10 * MS)
    assert (peer.received, pc.waiting) == (b"", 2)
    allowed.append(True)
    pc.poke()
    clock.run_until(20 * MS)
    assert peer.received == b"ab"


def test_bytes_are_told_as_they_come() -> None:
    clock, heard = Clock(), []
    pc, peer = pair(clock)
    peer.heard = lambda byte: heard.append((byte, clock.now_ns))
    pc.send(b"a")
    clock.run_until(10 * MS)
    # in the middle of the stop bit
    assert heard == [(0x61, int(9.5e9 // 9600))]
