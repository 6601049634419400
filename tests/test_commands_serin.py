"""SERIN: what it makes of bits on a wire."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cgagen.emulator.commands.serial_in import serin
from cgagen.emulator.pins import SIN
from cgagen.emulator.port import Jump
from cgagen.emulator.requests import Delay, Until
from cgagen.errors import ExecutionError
from tests.command_bench import MS, US, Bench, Got, Task, ToyPort, finished
from tests.serial_frames import INVERTED, MODES, NO_LABEL, SEVEN, frame_7e1, frame_8n1


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
    for model in ("BS2", "BS2sx"):
        with pytest.raises(ExecutionError, match=f"{model} has no SPSTR"):
            received([Got(0x1000, 1, stores=False)], b"a", port=ToyPort(model))


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


@given(byte=st.integers(0, 127), bad=st.booleans())
def test_parity_is_even_for_every_byte(byte: int, bad: bool) -> None:
    got = Got()
    data = bytes([byte])
    task = received([got], data, baud=84 | SEVEN, bad_parity=bad, parity_target=5)
    assert (task.result, got.taken) == ((Jump(5), []) if bad else (None, [byte]))


def test_serin_permits_while_it_listens() -> None:
    """S9 (1.8) p. 307, 316: byte by byte; stop when it has what it wants, and when it gives up."""
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
        last_bit, looks_again = MS + 884 * US, MS + 988 * US
        assert trace.changes[-4:] == [
            (0, go),
            (last_bit, 1 - go),
            (looks_again, go),
            (looks_again + 50 * MS, 1 - go),
        ]
        assert port.pins.directions == 1


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


def test_serin_makes_its_pin_an_input() -> None:
    """S2 p. 394."""
    port = ToyPort()
    port.pins.set_directions(0b1110)
    command = serin(port, [Got()], timeout=1, timeout_target=5, baud=84, pin=2)
    finished(command, port)
    assert port.pins.directions == 0b1010


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
