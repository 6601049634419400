"""Faults of wires and supplies: what they do, and that they say so."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cgagen.emulator.clock import Clock
from cgagen.emulator.parts.fault import BrownOut, Fault
from cgagen.emulator.parts.noise import Noise
from cgagen.emulator.parts.probe import Probe
from cgagen.emulator.parts.signal import Signal
from cgagen.emulator.parts.whisker import Whisker
from cgagen.emulator.parts.wire_faults import Bridge, Open, Short, Stuck
from cgagen.emulator.pins import Pins
from cgagen.emulator.wires import Wire
from cgagen.errors import ContentionError

MS = 1_000_000


class WireBench:
    """A whisker on a pin, each with its own end of the wire."""

    def __init__(self) -> None:
        self.clock = Clock()
        self.wire = Wire("whisker")
        self.floated: list[int] = []
        self.pins = Pins("main", self.floated.append)
        lead = Wire("left.signal")
        self.whisker = Whisker("left", self.clock, lead)
        self.wire.join(self.pins.wires[8])
        self.wire.join(lead)

    @property
    def pin(self) -> Wire:
        return self.pins.wires[8]

    def at(self, time_ms: int) -> None:
        self.clock.run_until(time_ms * MS)


def test_a_stuck_pin_reads_one_level() -> None:
    bench = WireBench()
    fault = Stuck("stuck", bench.clock, bench.pin, 1, from_ns=10 * MS, until_ns=30 * MS)
    bench.at(10)
    assert (bench.pins.level(8), fault.fired) == (1, 0)
    bench.at(20)
    bench.whisker.touch(True)
    assert (bench.pins.level(8), bench.wire.level) == (1, 0)
    assert (fault.fired, fault.first_ns) == (1, 20 * MS)
    bench.at(30)
    assert bench.pins.level(8) == 0
    bench.whisker.touch(False)
    bench.whisker.touch(True)
    assert fault.fired == 1


def test_nothing_comes_out_of_a_stuck_pin() -> None:
    bench = WireBench()
    fault = Stuck("stuck", bench.clock, bench.pin, 1)
    bench.at(1)
    bench.pins.set_directions(1 << 8)
    assert (bench.wire.level, bench.pins.level(8), fault.fired) == (1, 1, 1)


def test_an_open_wire_floats_and_comes_back() -> None:
    bench = WireBench()
    fault = Open("open", bench.clock, bench.pin, from_ns=None)
    fault.switch(True)
    assert (bench.pins.level(8), bench.floated) == (0, [8])
    assert (bench.wire.level, fault.fired, fault.first_ns) == (1, 1, 0)
    fault.switch(False)
    assert bench.pins.level(8) == 1


def test_an_open_wire_that_changes_nothing_has_not_fired() -> None:
    clock, wire, end = Clock(), Wire("w"), Wire("e")
    wire.join(end)
    fault = Open("open", clock, end)
    clock.run_until(MS)
    assert fault.on
    assert fault.fired == 0
    end.drive("main.P0", 1)
    assert (fault.fired, wire.level) == (1, None)
    end.drive("main.P0", 0)
    assert fault.fired == 1  # it still matters; it began to once
    end.drive("main.P0", None)
    end.drive("main.P0", 0)
    assert fault.fired == 2


@pytest.mark.parametrize("level", [0, 1])
def test_a_short_decides_on_every_end(level: int) -> None:
    bench = WireBench()
    fault = Short("short", bench.clock, bench.wire, level, from_ns=None)
    bench.whisker.touch(level == 0)
    fault.switch(True)
    assert fault.fired == 0
    bench.at(5)
    bench.whisker.touch(level == 1)
    assert (bench.pins.level(8), bench.wire.level) == (level, level)
    assert (fault.fired, fault.first_ns) == (1, 5 * MS)
    fault.switch(False)
    assert bench.pins.level(8) == 1 - level


def test_a_short_beats_an_output_without_ending_the_run() -> None:
    bench = WireBench()
    fault = Short("short", bench.clock, bench.wire, 0)
    bench.at(1)
    bench.pins.set_latch(1 << 8)
    bench.pins.set_directions(1 << 8)
    assert (bench.pins.level(8), fault.fired) == (0, 1)


def test_bridged_wires_are_one_until_they_are_not() -> None:
    clock, one, other, end = Clock(), Wire("one"), Wire("other"), Wire("end")
    other.join(end)
    fault = Bridge("bridge", clock, one, other, from_ns=10 * MS, until_ns=20 * MS)
    one.drive("main.P0", 1)
    assert end.level is None
    clock.run_until(10 * MS)
    assert (end.level, other.level, fault.fired) == (1, 1, 1)
    with pytest.raises(ContentionError, match=r"main\.P0 drives 1"):
        end.drive("main.P1", 0)
    clock.run_until(20 * MS)
    assert (one.level, other.level, end.level) == (1, None, None)
    end.drive("main.P1", 0)
    assert (one.level, other.level) == (1, 0)


def test_noise_is_short_often_enough_and_the_same_every_time() -> None:
    def run(seed: int) -> tuple[list[tuple[int, int | None]], int]:
        clock, wire, end = Clock(), Wire("w", pull=1), Wire("e")
        wire.join(end)
        probe = Probe("probe", clock, end)
        noise = Noise("noise", clock, end, 1 * MS, 2_000, seed, 10 * MS, 110 * MS)
        heard: list[int | None] = []
        wire.listen(heard.append)
        clock.run_until(200 * MS)
        assert (end.level, heard) == (1, [])
        glitches = probe.pulses(0)
        assert noise.fired == len(glitches)
        assert noise.first_ns == glitches[0].start_ns
        assert {pulse.width_ns for pulse in glitches} == {2_000}
        assert all(10 * MS < pulse.start_ns < 110 * MS for pulse in glitches)
        return [tuple(edge) for edge in probe.edges], noise.fired

    first, fired = run(1)
    assert 80 <= fired <= 120
    assert run(1) == (first, fired)
    assert run(2)[0] != first


def test_noise_that_ends_within_a_glitch_leaves_nothing_behind() -> None:
    clock, wire = Clock(), Wire("w", pull=1)
    noise = Noise("noise", clock, wire, MS, 400_000)
    while wire.level == 1:
        clock.run_next()
    noise.switch(False)
    assert wire.level == 1
    clock.run_until(clock.now_ns + 20 * MS)
    assert (wire.level, noise.fired) == (1, 1)


def test_noise_on_a_floating_wire_has_nothing_to_turn_round() -> None:
    clock, wire = Clock(), Wire("w")
    noise = Noise("noise", clock, wire, MS, 1_000)
    clock.run_until(50 * MS)
    assert (noise.fired, wire.level) == (0, None)


def test_a_brown_out_takes_the_supply_away_and_gives_it_back() -> None:
    clock, told = Clock(), []
    fault = BrownOut("supply", clock, lambda on: told.append((clock.now_ns, on)), 5 * MS, 8 * MS)
    clock.run_until(100 * MS)
    assert told == [(5 * MS, False), (8 * MS, True)]
    assert (fault.fired, fault.first_ns) == (1, 5 * MS)


def test_a_signal_plays_its_levels() -> None:
    clock, wire = Clock(), Wire("w")
    probe = Probe("probe", clock, wire)
    Signal("button", clock, wire, 1, [(5 * MS, 0), (8 * MS, None)])
    clock.run_until(10 * MS)
    assert [tuple(edge) for edge in probe.edges[1:]] == [(0, 1), (5 * MS, 0), (8 * MS, None)]


def test_a_probe_keeps_the_newest_edges() -> None:
    clock, wire = Clock(), Wire("w")
    probe = Probe("probe", clock, wire, limit=10)
    for number in range(1000):
        clock.run_until(number)
        wire.drive("x", number & 1)
    assert probe.count == 1000
    assert 10 <= len(probe.edges) <= 20
    assert probe.edges[-1] == (999, 1)
    assert probe.pulses()[-1] == (997, 1, 1)


def test_a_whisker_gives_way_to_an_output() -> None:
    """220 ohm and 10 kohm: a pin that is an output by mistake wins, and nothing burns."""
    bench = WireBench()
    bench.pins.set_directions(1 << 8)
    assert bench.wire.level == 0
    bench.pins.set_latch(1 << 8)
    bench.whisker.touch(True)
    assert bench.wire.level == 1
    bench.pins.set_directions(0)
    assert bench.wire.level == 0


class TwoWires:
    """Two wires with two ends each, and a fault of every kind on them that tests switch."""

    def __init__(self) -> None:
        clock = self.clock = Clock()
        self.wires = Wire("a", pull=1), Wire("b", pull=0)
        self.ends = tuple(Wire(f"{wire.name}.{n}") for wire in self.wires for n in (0, 1))
        for number, end in enumerate(self.ends):
            self.wires[number // 2].join(end)
        self.faults: dict[str, Fault] = {
            "open": Open("open", clock, self.ends[0], None),
            "again": Open("again", clock, self.ends[0], None),
            "stuck": Stuck("stuck", clock, self.ends[0], 0, None),
            "other": Open("other", clock, self.ends[2], None),
            "short": Short("short", clock, self.wires[0], 0, None),
            "short_1": Short("short_1", clock, self.wires[1], 1, None),
            "bridge": Bridge("bridge", clock, self.wires[0], self.wires[1], None),
            "twice": Bridge("twice", clock, self.wires[1], self.wires[0], None),
            "noise": Noise("noise", clock, self.ends[0], 1_000, 600, 0, None),
        }

    def ends_of(self, end: int) -> set[str]:
        return {wire.name for wire in self.ends[end].ends}

    def levels(self) -> list[int | None]:
        return [wire.level for wire in (*self.wires, *self.ends)]


@given(
    st.lists(st.sampled_from([*TwoWires().faults]), max_size=12),
    st.lists(st.integers(0, 2_000), min_size=12, max_size=12),
)
def test_faults_that_overlap_leave_nothing_behind(names: list[str], waits_ns: list[int]) -> None:
    """Each name switches its fault over; who is joined follows from those that are on."""
    bench, on = TwoWires(), set[str]()
    whole, levels = [bench.ends_of(end) for end in range(4)], bench.levels()
    for name, wait_ns in zip(names, waits_ns, strict=False):
        on ^= {name}
        bench.faults[name].switch(name in on)
        bench.clock.run_until(bench.clock.now_ns + wait_ns)
        cut = [bool(on & {"open", "again", "stuck"}), False, "other" in on, False]
        bridged = bool(on & {"bridge", "twice"})
        for end, wire in enumerate("aabb"):
            joined = {f"{wire}.{n}" for n in (0, 1)} | {wire}
            if bridged:
                joined |= whole[0] | whole[2]
            joined -= {one.name for one, gone in zip(bench.ends, cut, strict=True) if gone}
            assert bench.ends_of(end) == ({bench.ends[end].name} if cut[end] else joined)
        if not on & {"noise", "open", "again"} and "stuck" in on:
            assert bench.ends[0].level == 0
        if on & {"short", "short_1"} == {"short"}:
            assert {bench.wires[0].level, bench.ends[1].level} == {0}
    for name in sorted(on):
        bench.faults[name].switch(False)
    assert [bench.ends_of(end) for end in range(4)] == whole
    assert bench.levels() == levels
