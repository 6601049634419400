"""SEROUT: bits on the wire against a decoder that was written for these tests alone."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cgagen.emulator.commands.serial_in import serin
from cgagen.emulator.commands.serial_out import serout, serout_flow
from cgagen.emulator.pins import SIN
from cgagen.emulator.port import Jump
from cgagen.errors import ExecutionError
from tests.command_bench import MS, US, Bench, Got, Sent, Task, ToyPort, Trace, finished, text
from tests.serial_frames import INVERTED, MODES, NO_LABEL, OPEN, RATES, SEVEN, frame_7e1, frame_8n1


def decoded(trace: Trace, bit_ns: int, *, inverted: bool, end_ns: int) -> list[int]:
    """Decode 10-bit frames: each as a number whose lowest bit is the start bit.

    Written from the picture of a frame alone: an edge to the space level begins one, bits are
    read in their middles, and the line is a mark when the next may begin.
    """
    space = 1 if inverted else 0
    frames: list[int] = []
    now = 0
    while True:
        begin = next(
            (
                time
                for time, level in zip(trace.times_ns, trace.levels, strict=True)
                if time >= now and level == space and trace.at(time) == space
            ),
            None,
        )
        if begin is None or begin >= end_ns:
            return frames
        frame = 0
        for index in range(10):
            level = trace.at(begin + index * bit_ns + bit_ns // 2)
            assert level is not None
            frame |= (level ^ inverted) << index
        frames.append(frame)
        now = begin + 10 * bit_ns - bit_ns // 2


def sent_bytes(
    baud: int, data: bytes, model: str = "BS2", pin: int = 3, pull: int | None = None
) -> tuple[list[int], Trace, Task, ToyPort]:
    """Send bytes; the frames on the wire, its levels, how it went."""
    bench, port = Bench(), ToyPort(model)
    wire = port.pins.sout if pin == SIN else port.pins.wires[pin]
    if pull is not None:
        wire.pull = wire.level = pull
    trace = bench.trace(wire)
    task = bench.start(port, serout(port, text(data), baud=baud, pin=pin))
    bench.run()
    assert task.done_ns is not None
    bit_ns = ((baud & 0x1FFF) + 20) * (400 if model in ("BS2sx", "BS2p") else 1000)
    inverted = pin == SIN or bool(baud & INVERTED)
    frames = decoded(trace, bit_ns, inverted=inverted, end_ns=task.done_ns)
    return frames, trace, task, port


@pytest.mark.parametrize("model", RATES)
def test_bit_times_give_the_rates_of_the_manual(model: str) -> None:
    """Within what a receiver bears: less than half a bit in ten."""
    for rate, word in RATES[model]:
        *_, task, _ = sent_bytes(word, b"U", model)
        assert task.done_ns is not None
        assert abs(task.done_ns * rate / 10 / 1e9 - 1) < 0.04, rate


def test_the_letter_a_at_9600_baud_as_edges() -> None:
    """41h, lowest bit first, 104 us each: start, 1000 0010, stop."""
    _, trace, task, port = sent_bytes(84, b"A")
    b = 104 * US
    assert trace.changes == [(0, 0), (b, 1), (2 * b, 0), (7 * b, 1), (8 * b, 0), (9 * b, 1)]
    assert task.done_ns == 10 * b
    assert (port.pins.latch, port.pins.directions) == (8, 8)


@pytest.mark.parametrize("mode", MODES)
@given(data=st.binary(max_size=5))
def test_frames(mode: int, data: bytes) -> None:
    frames, *_ = sent_bytes(84 | mode, data)
    frame = frame_7e1 if mode & SEVEN else frame_8n1
    assert frames == [frame(byte) for byte in data]


def test_the_manuals_parity_example() -> None:
    """S2 p. 407: the seven bits 0011010 have parity bit 1."""
    assert sent_bytes(84 | SEVEN, bytes([0b0011010]))[0] == [0b1_1_0011010_0]


@pytest.mark.parametrize("mode", [0, INVERTED])
def test_open_lines_drive_one_level_only(mode: int) -> None:
    """S9 (1.8) p. 325: inverted drives 1 and needs a resistor to ground, true drives 0."""
    mark = 0 if mode else 1
    frames, _, task, port = sent_bytes(84 | OPEN | mode, b"Ok", pull=mark)
    assert frames == [frame_8n1(byte) for byte in b"Ok"]
    assert not port.pins.directions
    # a second talker at rest does no harm, and nobody ever drives the mark
    bench, port = Bench(), ToyPort()
    port.pins.wires[3].drive("other", mark)
    bench.start(port, serout(port, [], baud=84 | OPEN | mode, pin=3))
    bench.run()
    assert task.done_ns == 20 * 104 * US


@pytest.mark.parametrize("mode", [0, INVERTED, OPEN, OPEN | INVERTED])
def test_the_programming_port_is_always_inverted_and_driven(mode: int) -> None:
    """S2 p. 419."""
    frames, trace, _, port = sent_bytes(84 | mode, b"Hi", pin=SIN)
    assert frames == [frame_8n1(byte) for byte in b"Hi"]
    assert trace.levels[-1] == 0
    assert (port.pins.latch, port.pins.directions) == (0, 0)


@pytest.mark.parametrize(("mode", "mark"), [(0, 1), (INVERTED, 0)])
def test_the_line_is_a_mark_before_the_first_item_is_fetched(mode: int, mark: int) -> None:
    bench, port = Bench(), ToyPort()
    wire = port.pins.wires[3]
    wire.pull = wire.level = 1 - mark
    port.pins.set_latch(0xFFFF * (1 - mark))
    trace = bench.trace(wire)
    bench.start(port, serout(port, [Sent(0x41, fetch_ns=300 * US)], baud=84 | mode, pin=3))
    bench.run()
    assert trace.changes[:2] == [(0, mark), (300 * US, 1 - mark)]


def test_items_pace_and_time_to_fetch() -> None:
    """S2 p. 415: the pace lies between bytes. REP and STR are bytes like others."""
    port = ToyPort()
    port.registers.data[6:10] = b"ab\0c"
    items = [Sent(0x41, fetch_ns=7), Sent(6 + 0x200, 32), Sent(6, 4), Sent(0x2B, 0x400, 2)]
    items.append(Sent(0x03D6, 7))
    task = finished(serout(port, items, baud=84, pin=1, pace=5), port)
    data = b"A" + b"ab" + b"ab\0c" + b"++" + b"007"
    assert task.done_ns == 7 + len(data) * 1040 * US + (len(data) - 1) * 5 * MS


def test_a_string_without_an_end_stops_with_the_registers() -> None:
    """S2 p. 163: up to the first 0, or the end of RAM."""
    port = ToyPort()
    port.registers.data[:] = b"x" * 32
    task = finished(serout(port, [Sent(30 + 0x200, 32)], baud=84, pin=1), port)
    assert task.done_ns == 2 * 1040 * US
    task = finished(serout(port, [Sent(30, 4)], baud=84, pin=1), port)
    assert task.done_ns == 4 * 1040 * US


def test_items_that_no_compiler_makes_are_refused() -> None:
    port = ToyPort()
    with pytest.raises(ExecutionError, match="output item has 4 values"):
        finished(serout(port, [Sent(1, 2, 3, 4)], baud=84, pin=1), port)
    with pytest.raises(ExecutionError, match="input item"):
        finished(serin(port, [Got(5, stores=False)], timeout=NO_LABEL, baud=84, pin=1), port)


def test_flow_control_waits_for_every_byte() -> None:
    """S2 p. 424: go is 0 for true data and 1 for inverted; each byte asks."""
    for mode, go in ((0, 0), (INVERTED, 1)):
        bench, port = Bench(), ToyPort()
        bench.play(port.pins.wires[0], [(0, 1 - go), (5 * MS, go), (int(5.5 * MS), 1 - go)])
        bench.play(port.pins.wires[0], [(20 * MS, go)])
        trace = bench.trace(port.pins.wires[1])
        bench.run(0)
        task = bench.start(port, serout_flow(port, text(b"ab"), baud=84 | mode, pin=1, flow_pin=0))
        bench.run()
        assert task.done_ns == 20 * MS + 1040 * US
        frames = decoded(trace, 104 * US, inverted=bool(mode), end_ns=task.done_ns)
        assert frames == [frame_8n1(byte) for byte in b"ab"]


def test_flow_control_gives_up() -> None:
    """S2 p. 416, 425: 1 ms units, 0.4 ms on a BS2p; the rest of the list is not sent."""
    for model, unit_ns in (("BS2", MS), ("BS2p", 400 * US)):
        bench, port = Bench(), ToyPort(model)
        port.pins.wires[0].drive("other", 1)
        command = serout_flow(
            port, text(b"ab"), baud=84, pin=1, flow_pin=0, timeout=2000, timeout_target=77
        )
        task = bench.start(port, command)
        bench.run()
        assert (task.result, task.done_ns) == (Jump(77), 2000 * unit_ns)
