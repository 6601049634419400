"""SHIFTOUT and SHIFTIN against shift registers, and their edges against the manual's diagram."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cgagen.emulator.commands.shift import shiftin, shiftout
from cgagen.emulator.wires import Wire
from tests.command_bench import US, Bench, Got, Sent, Task, ToyPort, finished

LSB_FIRST, MSB_FIRST = 0, 1
MSB_PRE, LSB_PRE, MSB_POST, LSB_POST = range(4)


def shifted(items: list[Sent], mode: int, model: str = "BS2") -> tuple[str, Task]:
    """Shift out; what a register that takes its bit at the rising edge got."""
    bench, port = Bench(), ToyPort(model)
    data, clock = port.pins.wires[0], port.pins.wires[1]
    bits: list[str] = []
    clock.listen(lambda level: bits.append(str(data.level)) if level else None)
    task = bench.start(port, shiftout(port, items, mode=mode, data_pin=0, clock_pin=1))
    bench.run()
    assert port.pins.directions & 2
    assert not port.pins.latch & 2
    return "".join(bits), task


@pytest.mark.parametrize(
    ("count", "value", "mode", "bits"),
    [
        # S2 p. 437
        (8, 250, MSB_FIRST, "11111010"),
        (4, 250, MSB_FIRST, "1010"),
        (6, 250 >> 2, MSB_FIRST, "111110"),
        (16, 1045, MSB_FIRST, "0000010000010101"),
        # S2 p. 435: the rightmost bits in either order
        (8, 250, LSB_FIRST, "01011111"),
        (4, 250, LSB_FIRST, "0101"),
        (0, 250, LSB_FIRST, ""),
        (99, 1, LSB_FIRST, "1000000000000000"),
    ],
)
def test_shiftout(count: int, value: int, mode: int, bits: str) -> None:
    assert shifted([Sent(count, value)], mode)[0] == bits


def test_one_shiftout_of_twenty_bits() -> None:
    """S2 p. 437."""
    bits, _ = shifted([Sent(4, 250), Sent(16, 1045)], MSB_FIRST)
    assert bits == "1010" + "0000010000010101"


@pytest.mark.parametrize(
    ("model", "high_ns", "low_ns", "setup_ns", "hold_ns"),
    [
        ("BS2", 14 * US, 46 * US, 15 * US, 30 * US),
        ("BS2e", 14 * US, 46 * US, 15 * US, 30 * US),
        ("BS2sx", 5600, 18 * US, 6300, 12_500),
        ("BS2p", 5600, 18 * US, 6300, 12_500),
        ("BS2pe", 14 * US, 46 * US, 15 * US, 30 * US),
    ],
)
def test_edges_of_shiftout(
    model: str, high_ns: int, low_ns: int, setup_ns: int, hold_ns: int
) -> None:
    """S2 p. 435 and its figure: t_h, t_l, t_a twice before the first clock, t_b behind each."""
    bench, port = Bench(), ToyPort(model)
    data, clock = bench.trace(port.pins.wires[0]), bench.trace(port.pins.wires[1])
    bench.start(port, shiftout(port, [Sent(3, 0b101)], mode=LSB_FIRST, data_pin=0, clock_pin=1))
    bench.run()
    rise = 2 * setup_ns
    period = high_ns + low_ns
    assert clock.changes == [(0, 0)] + [
        edge
        for index in range(3)
        for edge in ((rise + index * period, 1), (rise + index * period + high_ns, 0))
    ]
    fall = rise + high_ns
    assert data.changes == [
        (0, None),
        (setup_ns, 1),
        (fall + hold_ns, 0),
        (fall + period + hold_ns, 1),
    ]


def from_register(items: list[Got], mode: int, bits: str, *, first_is_out: bool) -> list[int]:
    """Shift in from a register that changes its output at every falling edge of the clock."""
    bench, port = Bench(), ToyPort("BS2p")
    data, clock = port.pins.wires[2], port.pins.wires[3]
    coming = iter(bits)

    def shift(level: int | None) -> None:
        if level == 0:
            data.drive("register", int(next(coming, "0")))

    if first_is_out:
        data.drive("register", int(next(coming)))
    port.pins.set_directions(8)  # the clock is low already: no edge but those of the instruction
    clock.listen(shift)
    bench.start(port, shiftin(port, items, mode=mode, data_pin=2, clock_pin=3))
    bench.run()
    assert not port.pins.directions & 4
    return [item.taken[0] for item in items]


def test_the_manuals_flip_flop() -> None:
    """S9 (1.8) p. 330: a flip-flop that toggles with each clock reads 10101010, then 01010101."""
    for mode, value in ((MSB_PRE, 0b10101010), (MSB_POST, 0b01010101)):
        assert from_register([Got(8, 0)], mode, "1010101010", first_is_out=True) == [value]
    assert from_register([Got(4, 0)], MSB_PRE, "1010", first_is_out=True) == [0b1010]
    five_and_eight = [Got(5, 0), Got(8, 0)]
    assert from_register(five_and_eight, MSB_PRE, "1010101010101", first_is_out=True) == [
        0b10101,
        0b01010101,
    ]


@given(
    st.integers(0, 0xFFFF),
    st.integers(1, 16),
    st.sampled_from([MSB_PRE, LSB_PRE, MSB_POST, LSB_POST]),
)
def test_every_mode_puts_the_bits_where_they_belong(value: int, count: int, mode: int) -> None:
    """S2 p. 432."""
    value &= (1 << count) - 1
    bits = f"{value:0{count}b}"
    if mode in (LSB_PRE, LSB_POST):
        bits = bits[::-1]
    pre = mode in (MSB_PRE, LSB_PRE)
    assert from_register([Got(count, 0)], mode, bits, first_is_out=pre) == [value]


def test_pre_modes_look_before_the_clock_rises_and_post_modes_after_it_fell() -> None:
    for mode in range(4):
        bench, port = Bench(), ToyPort()
        wire = port.pins.wires[0]
        # the line is 1 only until the first clock rises, or only between the first two clocks
        before = mode in (MSB_PRE, LSB_PRE)
        bench.play(wire, [(0, 1), (31 * US, 0)] if before else [(0, 0), (44 * US, 1), (90 * US, 0)])
        item = Got(2, 0)
        bench.start(port, shiftin(port, [item], mode=mode, data_pin=0, clock_pin=1))
        bench.run()
        assert item.taken == [2 if mode in (MSB_PRE, MSB_POST) else 1]


def test_edges_of_shiftin() -> None:
    """S2 p. 431: t_h and t_l, and no level but low before the first pulse."""
    for mode in range(4):
        bench, port = Bench(), ToyPort()
        port.pins.set_latch(2)
        clock = bench.trace(port.pins.wires[1])
        bench.start(port, shiftin(port, [Got(2, 0)], mode=mode, data_pin=0, clock_pin=1))
        bench.run()
        assert clock.levels == [None, 0, 1, 0, 1, 0]
        rises = [time_ns for time_ns, level in clock.changes if level]
        assert rises == [30 * US, 90 * US]


def test_rates_of_the_manual() -> None:
    """S2 p. 431, 435: about 16 and 42 kbit/s."""
    for model, rate in (("BS2", 16_000), ("BS2p", 42_000)):
        port = ToyPort(model)
        items = [Sent(16, 0x5555)] * 20
        task = finished(shiftout(port, items, mode=0, data_pin=0, clock_pin=1), port)
        assert task.done_ns is not None
        assert abs(320 * 1e9 / task.done_ns / rate - 1) < 0.05


@given(st.lists(st.integers(0, 0xFFFF), min_size=1, max_size=3), st.booleans())
def test_over_a_register_and_back(values: list[int], msb_first: bool) -> None:
    """What SHIFTOUT put into a long register, SHIFTIN takes out of it in the same order."""
    bits, _ = shifted([Sent(16, value) for value in values], int(msb_first))
    items = [Got(16, 0) for _ in values]
    mode = MSB_PRE if msb_first else LSB_PRE
    assert from_register(items, mode, bits, first_is_out=True) == values


def test_wires_of_a_clock_are_shared() -> None:
    """Two chips: one shifts out, the other's clock input sees every edge."""
    port, wire = ToyPort(), Wire("clock")
    edges: list[int | None] = []
    port.pins.connect(9, wire)
    wire.listen(edges.append)
    finished(shiftout(port, [Sent(8, 1)], mode=0, data_pin=8, clock_pin=9), port)
    assert edges == [0] + [1, 0] * 8
