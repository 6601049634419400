"""PULSOUT, PULSIN, RCTIME and COUNT at the edges of what the manual says."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cgagen.emulator.commands.pulses import count, pulsin, pulsout, rctime
from cgagen.emulator.pins import Pins
from cgagen.emulator.port import Result
from cgagen.emulator.requests import Command, Delay
from tests.command_bench import MS, US, Bench, ToyPort, finished

MODELS = ["BS2", "BS2e", "BS2sx", "BS2p", "BS2pe"]


def measured(
    model: str,
    changes: list[tuple[int, int | None]],
    kind: str,
    value: int,
) -> tuple[Result, int]:
    """Run an instruction that measures pin 3, whose wire changes so; the result, and when."""
    bench, port = Bench(), ToyPort(model)
    port.pins.wires[3].pull = port.pins.wires[3].level = 0
    bench.play(port.pins.wires[3], changes)
    command: Command[Result] = {
        "PULSIN": lambda: pulsin(port, state=value, pin=3),
        "RCTIME": lambda: rctime(port, state=value, pin=3),
        "COUNT": lambda: count(port, duration=value, pin=3),
    }[kind]()
    bench.run(0)
    task = bench.start(port, command)
    bench.run()
    assert task.done_ns is not None
    assert not port.pins.directions & 8
    return task.result, task.done_ns


@pytest.mark.parametrize(
    ("model", "unit_ns"),
    [("BS2", 2000), ("BS2e", 2000), ("BS2sx", 800), ("BS2p", 800), ("BS2pe", 2000)],
)
@pytest.mark.parametrize("latch", [0, 1])
def test_pulsout_is_exact_and_against_the_latch(model: str, unit_ns: int, latch: int) -> None:
    """S2 p. 347: units, and the bit inverted and back; the pin stays an output."""
    bench, port = Bench(), ToyPort(model)
    port.pins.set_latch(latch << 7)
    port.pins.set_directions(1 << 7)
    trace = bench.trace(port.pins.wires[7])
    task = bench.start(port, pulsout(port, duration=750, pin=7))
    bench.run()
    assert trace.changes == [(0, 1 - latch), (750 * unit_ns, latch)]
    assert task.done_ns == 750 * unit_ns
    assert (port.pins.latch, port.pins.directions) == (latch << 7, 1 << 7)


def test_pulsout_of_an_input_shows_the_latch_first() -> None:
    """S9 (1.8) p. 291: an input that is pulled high falls for a few microseconds, then pulses."""
    bench, port = Bench(), ToyPort()
    wire = port.pins.wires[7]
    wire.pull = wire.level = 1
    trace = bench.trace(wire)
    bench.start(port, pulsout(port, duration=5, pin=7))
    bench.run()
    shown_ns = port.timing.pulsout_glitch_ns
    assert trace.changes == [(0, 0), (shown_ns, 1), (shown_ns + 10 * US, 0)]


def test_pulsout_of_nothing_is_no_pulse() -> None:
    port = ToyPort()
    port.pins.set_directions(2)
    assert finished(pulsout(port, duration=0, pin=1), port).requests == []
    assert port.pins.latch == 0


def test_the_longest_pulsout() -> None:
    """S2 p. 347: 131.07 ms on a BS2, 52.428 ms on a BS2p."""
    for model, most_ns in (("BS2", 131_070 * US), ("BS2p", 52_428 * US)):
        port = ToyPort(model)
        port.pins.set_directions(1)
        assert finished(pulsout(port, duration=65535, pin=0), port).requests == [Delay(most_ns)]


PULSES = [
    # changes of the wire, state, count (BS2: 2 us each): S9 (1.8) p. 289
    ("a pulse", [(5 * MS, 1), (6 * MS, 0)], 1, 500),
    ("a low pulse", [(0, 1), (5 * MS, 0), (6 * MS, 1)], 0, 500),
    ("one that began before is not seen", [(0, 1), (1 * MS, 0)], 1, 0),
    ("the next after it is", [(0, 1), (1 * MS, 0), (2 * MS, 1), (2 * MS + 20 * US, 0)], 1, 10),
    ("none", [], 1, 0),
    ("none from a pin that stays", [(0, 1)], 1, 0),
    ("too long", [(1 * MS, 1)], 1, 0),
    ("the longest", [(1 * MS, 1), (1 * MS + 131_071 * US, 0)], 1, 65535),
    ("one unit more", [(1 * MS, 1), (1 * MS + 131_072 * US, 0)], 1, 0),
    ("512 us, which a byte takes for 0", [(1 * MS, 1), (1 * MS + 512 * US, 0)], 1, 256),
    ("not two units", [(1 * MS, 1), (1 * MS + 3_999, 0)], 1, 1),
    ("less than one", [(1 * MS, 1), (1 * MS + 1_999, 0)], 1, 1),
]


@pytest.mark.parametrize(("_", "changes", "state", "expected"), PULSES)
def test_pulsin(_: str, changes: list[tuple[int, int | None]], state: int, expected: int) -> None:
    assert measured("BS2", changes, "PULSIN", state)[0] == expected


def test_pulsin_gives_up_when_the_manual_says() -> None:
    """As long as the longest pulse: 131.07 ms (S2 p. 343), a BS2p 49.151 ms (S4)."""
    assert measured("BS2", [], "PULSIN", 1) == (0, 131_070 * US)
    assert measured("BS2p", [], "PULSIN", 1) == (0, 49_151_250)
    # leaving the level takes of the same time
    assert measured("BS2", [(0, 1), (100 * MS, 0)], "PULSIN", 1) == (0, 131_070 * US)
    late: list[tuple[int, int | None]] = [(0, 0), (130 * MS, 1), (230 * MS, 0)]
    assert measured("BS2", late, "PULSIN", 1) == (50_000, 230 * MS)


@pytest.mark.parametrize(
    ("model", "counts"),
    # 1234 units of 2 us, of 0.8 us, of 0.8 us in 0.75 us, of 2 us in 1.88 us
    [("BS2", 1234), ("BS2e", 1234), ("BS2sx", 1234), ("BS2p", 1316), ("BS2pe", 1312)],
)
def test_pulsin_measures_pulsout_in_its_own_units(model: str, counts: int) -> None:
    bench, sender, taker = Bench(), ToyPort(model, "sender"), ToyPort(model, "taker")
    sender.pins.set_directions(1)
    taker.pins.connect(2, sender.pins.wires[0])
    measure = bench.start(taker, pulsin(taker, state=1, pin=2))
    bench.run(MS)
    bench.start(sender, pulsout(sender, duration=1234, pin=0))
    bench.run()
    assert measure.result == counts


@given(st.integers(1, 140_000))
def test_pulsin_counts_whole_units(width_us: int) -> None:
    result, _ = measured("BS2p", [(7, 1), (7 + width_us * US, 0)], "PULSIN", 1)
    units = width_us * 1000 // 750
    assert result == (max(units, 1) if units <= 65535 else 0)


RC = [
    # S2 p. 363
    ("already there", [(0, 1)], 0, 1),
    ("falls", [(0, 1), (2 * MS, 0)], 1, 1000),
    ("rises", [(2 * MS, 1)], 0, 1000),
    ("never", [(0, 1)], 1, 0),
    ("the longest", [(0, 1), (131_071 * US, 0)], 1, 65535),
    ("one unit more", [(0, 1), (131_072 * US, 0)], 1, 0),
    ("at once", [(0, 1), (1, 0)], 1, 1),
]


@pytest.mark.parametrize(("_", "changes", "state", "expected"), RC)
def test_rctime(_: str, changes: list[tuple[int, int | None]], state: int, expected: int) -> None:
    assert measured("BS2", changes, "RCTIME", state)[0] == expected


def test_a_pin_that_floats_is_reported() -> None:
    for function in (pulsin, rctime):
        floated: list[int] = []
        port = ToyPort()
        port.pins = Pins("chip", floated.append)
        bench = Bench()
        bench.start(port, function(port, state=0, pin=4))
        bench.run()
        assert floated == [4]


def test_rctime_of_a_bs2p() -> None:
    """S2 p. 363: 0.75 us, 49.151 ms."""
    assert measured("BS2p", [(0, 1), (750 * US, 0)], "RCTIME", 1)[0] == 1000
    _, overflow_ns = measured("BS2p", [(0, 1)], "RCTIME", 1)
    assert abs(overflow_ns - 49_151 * US) < 2 * US


def square(period_ns: int, until_ns: int) -> list[tuple[int, int | None]]:
    half = period_ns // 2
    return [(at_ns, index & 1) for index, at_ns in enumerate(range(half, until_ns, half), start=1)]


@pytest.mark.parametrize(
    ("model", "duration", "window_ms"),
    [("BS2", 100, 100), ("BS2sx", 250, 100), ("BS2p", 100, 28.7), ("BS2pe", 100, 72)],
)
def test_count_counts_cycles_of_its_window(model: str, duration: int, window_ms: float) -> None:
    """S2 p. 149: units of 1 ms, 0.4 ms, 0.287 ms and 0.72 ms."""
    result, done_ns = measured(model, square(MS, 200 * MS), "COUNT", duration)
    assert done_ns == window_ms * MS
    assert isinstance(result, int)
    assert abs(result - window_ms) <= 1


def test_count_is_blind_to_short_pulses() -> None:
    """S2 p. 149: 4.16 us is the shortest that a BS2 sees, 120 kHz the highest frequency."""
    assert measured("BS2", square(8_320, 20 * MS), "COUNT", 10)[0] in (1201, 1200)
    spike: list[tuple[int, int | None]] = [(4_170, 1), (4_180, 0)]
    assert measured("BS2", spike, "COUNT", 1)[0] == 0
    wide: list[tuple[int, int | None]] = [(4_170, 1), (8_400, 0)]
    assert measured("BS2", wide, "COUNT", 1)[0] == 1


def test_count_lasts_for_all_of_its_window() -> None:
    """Also where a change comes behind the last look: 10 ms are 2,403.8 looks of 4.16 us."""
    late: list[tuple[int, int | None]] = [(MS, 1), (2 * MS, 0), (10 * MS - 100, 1)]
    assert measured("BS2", late, "COUNT", 10) == (1, 10 * MS)


def test_count_of_no_time_and_of_half_a_cycle() -> None:
    assert measured("BS2", square(MS, 5 * MS), "COUNT", 0) == (0, 0)
    assert measured("BS2", [(MS, 1)], "COUNT", 10)[0] == 0
    assert measured("BS2", [(0, 1), (MS, 0), (2 * MS, 1)], "COUNT", 10)[0] == 1
