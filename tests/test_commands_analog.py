"""PWM, FREQOUT and DTMFOUT: how long, how much, how often."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cgagen.emulator.commands.analog import Edges, dtmf_millihertz, dtmfout, freqout, pwm
from cgagen.emulator.port import Result
from cgagen.emulator.requests import Command
from tests.command_bench import MS, US, Bench, Sent, Task, ToyPort, Trace


def played(port: ToyPort, command: Command[Result], pin: int = 0) -> tuple[Trace, Task]:
    bench = Bench()
    trace = bench.trace(port.pins.wires[pin])
    task = bench.start(port, command)
    bench.run()
    assert task.done_ns is not None
    return trace, task


def high_ns(trace: Trace, end_ns: int) -> int:
    ends = [*trace.times_ns[1:], end_ns]
    return sum(
        end - begin
        for begin, end, level in zip(trace.times_ns, ends, trace.levels, strict=True)
        if level
    )


@given(st.integers(0, 255))
def test_pwm_is_high_in_so_many_of_256_slots(duty: int) -> None:
    """S4 (PWM): the average is duty / 256; S7: a duty of 255 is not all."""
    port = ToyPort()
    trace, task = played(port, pwm(port, duty=duty, duration=1, pin=0))
    assert task.done_ns == MS
    assert abs(high_ns(trace, MS) - MS * duty / 256) < 256
    assert not port.pins.directions


def test_pwm_is_spread_evenly() -> None:
    """S9 (1.8) p. 295: pulses as short as a slot. A half is 128 of them."""
    port = ToyPort()
    trace, _ = played(port, pwm(port, duty=128, duration=1, pin=0))
    assert trace.levels.count(1) == 128
    trace, _ = played(port, pwm(port, duty=64, duration=1, pin=0))
    assert trace.levels.count(1) == 64


@pytest.mark.parametrize(
    ("model", "cycle_us"),
    [("BS2", 1000), ("BS2e", 1000), ("BS2sx", 400), ("BS2p", 653.595), ("BS2pe", 1620)],
)
def test_pwm_lasts_its_cycles(model: str, cycle_us: float) -> None:
    """S4 (PWM), S5 (PWM)."""
    port = ToyPort(model)
    task = played(port, pwm(port, duty=100, duration=40, pin=0))[1]
    assert task.done_ns == 40 * round(cycle_us * US)
    assert played(port, pwm(port, duty=100, duration=0, pin=0))[1].done_ns == 0


TONES = [
    # S2 p. 199: units of time and of frequency
    ("BS2", 1000, 1.0, 1000), ("BS2sx", 400, 2.5, 2500), ("BS2p", 265, 3.77, 3770),
    ("BS2pe", 1000, 1.51, 1510), ("BS2e", 1000, 1.0, 1000),
]  # fmt: skip


@pytest.mark.parametrize(("model", "unit_us", "hertz", "_"), TONES)
def test_freqout_has_its_frequency_and_length(
    model: str, unit_us: int, hertz: float, _: int
) -> None:
    port = ToyPort(model)
    trace, task = played(port, freqout(port, pin=0, duration=200, frequency=2500))
    seconds = 200 * unit_us / 1e6
    assert task.done_ns == 200 * unit_us * US
    rises = trace.levels.count(1)
    assert abs(rises - seconds * 2500 * hertz) <= 1
    assert (port.pins.directions, port.pins.latch) == (1, 0)
    assert trace.levels[-1] == 0


def test_one_period_of_a_tone() -> None:
    port = ToyPort()
    trace, _ = played(port, freqout(port, pin=0, duration=2, frequency=1000))
    half = MS // 2
    assert trace.changes == [(0, 1), (half, 0), (2 * half, 1), (3 * half, 0)]


def test_no_frequency_is_silence_and_no_time_is_nothing() -> None:
    port = ToyPort()
    trace, task = played(port, freqout(port, pin=0, duration=7, frequency=0))
    assert (task.done_ns, trace.levels) == (7 * MS, [None, 0])
    assert played(port, freqout(port, pin=0, duration=0, frequency=440))[1].done_ns == 0


@given(st.integers(1, 3000), st.integers(0, 3000))
def test_two_tones_have_the_sign_of_their_sum(first: int, second: int) -> None:
    port = ToyPort()
    duration = 10
    trace, task = played(
        port, freqout(port, pin=0, duration=duration, frequency=first, second=second)
    )
    assert task.done_ns == duration * MS
    for step in range(1, 400):
        at_ns = step * duration * MS // 400
        seconds = at_ns / 1e9
        both = math.sin(math.tau * first * seconds) + math.sin(math.tau * second * seconds)
        if abs(both) > 1e-3:
            assert trace.at(at_ns) == (both > 0)


def test_edges_are_exact() -> None:
    edges = Edges([1000])  # 1 Hz
    assert [edges.pop_ns() for _ in range(3)] == [10**9 // 2, 10**9, 3 * 10**9 // 2]
    assert Edges([]).silent
    twice = Edges([1000, 1000])
    assert twice.pop_ns() == 10**9 // 2


def test_telephone_keys() -> None:
    """ITU-T Q.23, with S2 p. 180 for the numbers of star, pound and the fourth column."""
    hertz = {key: tuple(f // 1000 for f in dtmf_millihertz(key)) for key in range(16)}
    assert [hertz[key] for key in (1, 5, 9, 0)] == [
        (697, 1209), (770, 1336), (852, 1477), (941, 1336),
    ]  # fmt: skip
    assert [hertz[key] for key in (10, 11, 12, 15)] == [
        (941, 1209), (941, 1477), (697, 1633), (941, 1633),
    ]  # fmt: skip
    assert len(set(hertz.values())) == 16


@pytest.mark.parametrize(
    ("model", "on_us"), [("BS2", 1000), ("BS2sx", 400), ("BS2p", 265), ("BS2pe", 1000)]
)
def test_dtmfout_dials(model: str, on_us: int) -> None:
    """S2 p. 179: on times in the model's unit, off times in ms; an input at the end."""
    port = ToyPort(model)
    keys = [Sent(6, fetch_ns=11), Sent(2), Sent(4)]
    trace, task = played(port, dtmfout(port, keys, pin=0, on_time=200, off_time=50))
    on_ns = 200 * on_us * US
    assert task.done_ns == 11 + 3 * (on_ns + 50 * MS)
    assert not port.pins.directions
    assert trace.at(11 + on_ns + 25 * MS) == 0
    assert any(11 <= time <= 11 + on_ns for time in trace.times_ns)
