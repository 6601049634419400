"""SEROUT and SERIN: bits on the wire against a decoder of its own, and against each other."""

import pytest
from command_bench import MS, US, Bench, Got, Sent, Task, ToyPort, Trace, finished, text
from hypothesis import given
from hypothesis import strategies as st

from cgagen.emulator.commands.serial_in import serin
from cgagen.emulator.commands.serial_out import serout, serout_flow
from cgagen.emulator.pins import SIN
from cgagen.emulator.port import Jump
from cgagen.emulator.requests import Delay, Until
from cgagen.emulator.wires import Wire
from cgagen.errors import ExecutionError

SEVEN, INVERTED, OPEN = 0x2000, 0x4000, 0x8000
MODES = [0, SEVEN, INVERTED, INVERTED | SEVEN]
NO_LABEL = 1
"""What a SERIN without a label pushes for its time-out."""

RATES = {  # S2 p. 394, 395, 419: baud rates and the words of the manual's tables
    "BS2": [(300, 3313), (600, 1646), (1200, 813), (2400, 396), (4800, 188), (9600, 84),
            (19200, 32), (38400, 6), (50000, 0)],
    "BS2p": [(1200, 2063), (2400, 1021), (4800, 500), (9600, 240), (19200, 110), (38400, 45),
             (115200, 1)],
}  # fmt: skip


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


def frame_8n1(byte: int) -> int:
    return 1 << 9 | byte << 1


def frame_7e1(byte: int) -> int:
    byte &= 0x7F
    return 1 << 9 | (bin(byte).count("1") % 2) << 8 | byte << 1


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


# -- SERIN ----------------------------------------------------------------------------------------


def waveform(
    data: bytes,
    bit_ns: int,
    *,
    inverted: bool = False,
    start_ns: int = MS,
    gap_ns: int = 0,
    seven: bool = False,
    bad_parity: bool = False,
) -> list[tuple[int, int | None]]:
    """Return the changes of a line on which these bytes arrive."""
    changes: list[tuple[int, int | None]] = [(0, 1 ^ inverted)]
    for byte in data:
        frame = frame_7e1(byte) ^ bad_parity << 8 if seven else frame_8n1(byte)
        for index in range(10):
            changes.append((start_ns + index * bit_ns, (frame >> index & 1) ^ inverted))
        start_ns += 10 * bit_ns + gap_ns
    return changes


def received(
    items: list[Got],
    data: bytes,
    *,
    port: ToyPort | None = None,
    baud: int = 84,
    pin: int = 1,
    gap_ns: int = 0,
    bad_parity: bool = False,
    until_ns: int = 10**12,
    **labels: int,
) -> Task:
    """Let bytes arrive at a SERIN that has begun."""
    bench, port = Bench(), port or ToyPort()
    wire = port.pins.wires[pin]
    bit_ns = ((baud & 0x1FFF) + 20) * port.timing.serial_unit_ns
    bench.play(
        wire,
        waveform(
            data,
            bit_ns,
            inverted=pin == SIN or bool(baud & INVERTED),
            gap_ns=gap_ns,
            seven=bool(baud & SEVEN),
            bad_parity=bad_parity,
        ),
    )
    bench.run(0)
    task = bench.start(
        port, serin(port, items, **{"timeout": NO_LABEL, "baud": baud, "pin": pin, **labels})
    )
    bench.run(until_ns)
    return task


@given(data=st.binary(min_size=1, max_size=4), mode=st.sampled_from(MODES))
def test_bytes_arrive(data: bytes, mode: int) -> None:
    items = [Got() for _ in data]
    assert received(items, data, baud=84 | mode).done_ns is not None
    mask = 0x7F if mode & SEVEN else 0xFF
    assert [item.taken for item in items] == [[byte & mask] for byte in data]


@given(byte=st.integers(0, 255), drift=st.floats(-0.045, 0.045))
def test_bits_are_read_in_their_middles(byte: int, drift: float) -> None:
    """A sender up to 4.5 % off is still understood, as with any receiver of ten bits."""
    bench, port = Bench(), ToyPort()
    bench.play(port.pins.wires[1], waveform(bytes([byte]), round(104 * US * (1 + drift))))
    bench.run(0)
    item = Got()
    bench.start(port, serin(port, [item], timeout=NO_LABEL, baud=84, pin=1))
    bench.run()
    assert item.taken == [byte]


def test_where_a_byte_is_sampled() -> None:
    """One bit and a half behind the edge, then every bit; ready in the middle of the stop bit."""
    item, b = Got(), 104 * US
    task = received([item], b"U")
    delays = [request.ns for request in task.requests if isinstance(request, Delay)]
    assert delays == [0, b * 3 // 2, *[b] * 7, b]
    assert task.done_ns == MS + b * 19 // 2


def test_sin_is_inverted_whatever_the_word_says() -> None:
    for mode in (0, INVERTED):
        item = Got()
        received([item], b"Q", baud=84 | mode, pin=SIN)
        assert item.taken == [0x51]


def both(
    baud: int,
    data: bytes,
    model: str,
    *,
    pull: int | None = None,
    sender_pin: int = 4,
    fetch_ns: int = 0,
) -> list[int]:
    """Send from one chip to another; what arrives."""
    bench, sender, taker = Bench(), ToyPort(model, "sender"), ToyPort(model, "taker")
    wire = Wire("line", pull=pull)
    sender.pins.connect(sender_pin, wire)
    taker.pins.connect(5, wire)
    sent = text(data, fetch_ns)
    items = [Got() for _ in data]
    take = bench.start(taker, serin(taker, items, timeout=NO_LABEL, baud=baud, pin=5))
    bench.run(0)
    bench.start(sender, serout(sender, sent, baud=baud, pin=sender_pin))
    bench.run()
    assert take.done_ns is not None
    return [item.taken[0] for item in items]


@given(
    st.sampled_from(sorted(RATES)),
    st.data(),
    st.binary(min_size=1, max_size=6),
    st.sampled_from([0, SEVEN, INVERTED, SEVEN | INVERTED]),
    st.booleans(),
)
def test_what_serout_sends_serin_receives(
    model: str, data: st.DataObject, payload: bytes, mode: int, is_open: bool
) -> None:
    _, word = data.draw(st.sampled_from(RATES[model]))
    mark = 0 if mode & INVERTED else 1
    got = both(word | mode | (OPEN if is_open else 0), payload, model, pull=mark)
    assert bytes(got) == bytes(byte & 0x7F if mode & SEVEN else byte for byte in payload)


@given(st.integers(0, 0x1FFF), st.binary(min_size=1, max_size=3))
def test_any_bit_time_does(word: int, payload: bytes) -> None:
    assert bytes(both(word, payload, "BS2p", pull=1)) == payload


@given(st.integers(0, 0xFFFF), st.sampled_from([0x01B6, 0x05B6, 0x01C0, 0x0DC0, 0x0B0E, 0x03E0]))
def test_a_number_goes_over_the_line(value: int, form: int) -> None:
    bench, sender, taker = Bench(), ToyPort("BS2", "sender"), ToyPort("BS2p", "taker")
    wire = Wire("line", pull=1)
    sender.pins.connect(0, wire)
    taker.pins.connect(0, wire)
    item = Got(form, 0)
    bench.start(taker, serin(taker, [item], timeout=NO_LABEL, baud=240, pin=0))
    bench.run(0)
    bench.start(sender, serout(sender, [Sent(form, value), Sent(13)], baud=84, pin=0))
    bench.run()
    # HEX2 keeps two digits of it
    assert item.taken == [value & 0xFF if form == 0x03E0 else value]


def test_skip_wait_str_and_spstr() -> None:
    """S2 p. 404; the words are S3's."""
    port = ToyPort("BS2p")
    last = Got()
    items = [
        Got(ord("C"), ord("B"), ord("A"), 0xC44, 3, stores=False),  # WAIT("ABC")
        Got(0x400, 2, stores=False),  # SKIP 2
        Got(6, 3, stores=False),  # STR b\3
        Got(ord("*"), 10 + 0x200, 5, stores=False),  # STR c\5\"*"
        Got(0x1000, 4, stores=False),  # SPSTR 4
        last,
    ]
    port.registers.data[10:16] = b"oldest"
    data = b"xAABABC--abcde*spad!"
    assert received(items, data, port=port, baud=240).done_ns is not None
    assert bytes(port.registers.data[6:9]) == b"abc"
    assert bytes(port.registers.data[10:16]) == b"de\0\0\0t"
    assert bytes(port.scratch[:5]) == b"spad\0"
    assert last.taken == [ord("!")]


def test_waitstr() -> None:
    for item in (Got(6 + 0x800, 32, stores=False), Got(6 + 0xA00, 2, stores=False)):
        port, last = ToyPort(), Got()
        port.registers.data[6:9] = b"ok\0"
        received([item, last], b"oxook7", port=port)
        assert last.taken == [ord("7")]
    # an empty string is there at once
    last = Got()
    received([Got(6 + 0x800, 32, stores=False), last], b"q")
    assert last.taken == [ord("q")]


def test_spstr_keeps_what_fits_and_needs_a_scratch_pad() -> None:
    port, last = ToyPort("BS2p"), Got()
    received([Got(0x1000, 130, stores=False), last], bytes(range(131)), port=port, baud=240)
    assert bytes(port.scratch[:127]) == bytes(range(127))
    assert bytes(port.scratch[127:]) == bytes(9)
    assert last.taken == [130]
    with pytest.raises(ExecutionError, match="BS2 has no scratch pad"):
        received([Got(0x1000, 1, stores=False)], b"a")


def test_the_time_out_is_that_of_a_byte() -> None:
    """S9 (1.8) p. 315: any byte stops it, also one that is no use; S2 p. 394 for the units."""
    number = Got(0x01B6, 0)
    task = received([number], b"ABCD", gap_ns=9 * MS, timeout=10, timeout_target=99)
    start_of_last = MS + 3 * (1040 * US + 9 * MS)
    assert task.result == Jump(99)
    assert task.done_ns == start_of_last + 988 * US + 10 * MS
    assert number.taken == []
    for model, unit_ns in (("BS2pe", MS), ("BS2sx", 400 * US)):
        task = received([Got()], b"", port=ToyPort(model), timeout=2000, timeout_target=99)
        assert (task.result, task.done_ns) == (Jump(99), 2000 * unit_ns)


def test_without_a_label_it_waits_for_ever() -> None:
    assert received([Got()], b"", until_ns=10**15).done_ns is None
    # the 1 that stands for "no time-out" is none, with a parity label either
    task = received([Got()], b"", until_ns=10**15, baud=84 | SEVEN, parity_target=5)
    assert task.done_ns is None


def test_parity() -> None:
    """S2 p. 407: an error ends the instruction at once; without a label nobody looks."""
    first, second = Got(), Got()
    task = received(
        [first, second],
        b"ab",
        baud=84 | SEVEN,
        bad_parity=True,
        parity_target=55,
        timeout_target=66,
        timeout=1000,
    )
    assert (task.result, first.taken) == (Jump(55), [])
    assert task.done_ns == MS + 988 * US
    task = received([first], b"a", baud=84 | SEVEN, bad_parity=True)
    assert (task.result, first.taken) == (None, [ord("a")])


def test_serin_permits_while_it_listens() -> None:
    """S9 (1.8) p. 316: go at its start, stop when it has what it wants, and when it gives up."""
    for mode, go in ((0, 0), (INVERTED, 1)):
        port = ToyPort()
        bench = Bench()
        trace = bench.trace(port.pins.wires[0])
        wave = waveform(b"z", 104 * US, inverted=bool(mode))
        bench.play(port.pins.wires[1], wave)
        bench.run(0)
        labels = {"timeout": 50, "timeout_target": 8}
        bench.start(port, serin(port, [Got(), Got()], baud=84 | mode, pin=1, flow_pin=0, **labels))
        bench.run()
        assert trace.changes[-2:] == [(0, go), (MS + 988 * US + 50 * MS, 1 - go)]
        assert port.pins.directions == 1


def test_two_chips_with_flow_control_lose_nothing() -> None:
    """S2 p. 424: the receiver takes one byte a second, and the sender waits."""
    bench, sender, taker = Bench(), ToyPort("BS2", "sender"), ToyPort("BS2", "taker")
    data_line, flow_line = Wire("data", pull=0), Wire("flow", pull=0)
    for port in (sender, taker):
        port.pins.connect(1, data_line)
        port.pins.connect(0, flow_line)
    flow = {"baud": 84 | INVERTED, "pin": 1, "flow_pin": 0}
    bench.start(sender, serout_flow(sender, text(b"HELLO!"), **flow))
    items = [Got() for _ in range(6)]
    for second, item in enumerate(items):
        bench.at(
            second * 1000 * MS,
            lambda item=item: bench.start(taker, serin(taker, [item], timeout=1, **flow)),  # type: ignore[misc]
        )
    bench.run()
    assert bytes(item.taken[0] for item in items) == b"HELLO!"


def test_a_chip_that_is_busy_between_bytes_loses_the_next() -> None:
    """S2 p. 411: no buffer. Up to a bit and a half of work fits beside the stop bit."""
    b = 104 * US
    for busy_ns, arrives in ((b * 3 // 2 - 1, True), (b * 3, False)):
        second = Got(fetch_ns=busy_ns)
        received([Got(), second], b"\x55\x0f", until_ns=10 * MS)
        assert (second.taken == [0x0F]) is arrives


def test_serin_touches_only_its_pins() -> None:
    port = ToyPort()
    port.pins.set_directions(0b1110)
    port.pins.set_latch(0b1100)
    task = received([Got()], b"a", port=port, pin=SIN)
    assert (port.pins.directions, port.pins.latch) == (0b1110, 0b1100)
    assert all(r.pin == SIN for r in task.requests if isinstance(r, Until))
    received([Got()], b"a", port=port, pin=0)
    assert port.pins.directions == 0b1110


@given(st.lists(st.integers(0, 3 * 104 * US), max_size=60), st.integers(0, 0xFFFF))
def test_any_line_is_survived(steps: list[int], baud: int) -> None:
    bench, port = Bench(), ToyPort()
    level, now = 0, 0
    for step in steps:
        now, level = now + step, 1 - level
        bench.at(now, lambda level=level: port.pins.wires[1].drive("noise", level))  # type: ignore[misc]
    items = [Got() for _ in range(3)]
    command = serin(port, items, timeout=5, timeout_target=3, baud=baud, pin=1)
    task = bench.start(port, command)
    bench.run()
    assert task.result in (None, Jump(3))
