"""The light circuit against its formula: t = R C ln(V0 / Vth)."""

import math

import pytest

from cgagen.emulator.clock import Clock
from cgagen.emulator.parts.photocell import Photocell
from cgagen.emulator.parts.sonar import middle_ns
from cgagen.emulator.pins import Pins
from cgagen.emulator.wires import Wire

US = 1_000
MS = 1_000_000
PIN = 10


class CellBench:
    """A light sensor on a chip's pin."""

    def __init__(self, capacitor_uf: float = 0.01) -> None:
        self.clock = Clock()
        self.pins = Pins("main")
        wire = Wire("light")
        self.cell = Photocell("left", self.clock, wire, capacitor_uf)
        self.pins.connect(PIN, wire)

    def measure_ns(self, charge_ns: int = MS, limit_ns: int = 60 * MS) -> int | None:
        """Do what HIGH, PAUSE and RCTIME do; None where the pin is still high after `limit_ns`."""
        self.pins.set_latch(1 << PIN)
        self.pins.set_directions(1 << PIN)
        self.clock.run_until(self.clock.now_ns + charge_ns)
        self.pins.set_directions(0)
        start_ns = self.clock.now_ns
        while self.pins.level(PIN) == 1:
            if self.clock.next_ns() > start_ns + limit_ns:
                self.clock.run_until(start_ns + limit_ns)
                return None
            self.clock.run_next()
        return self.clock.now_ns - start_ns


@pytest.mark.parametrize("resistance_ohm", [2_000, 10_000, 100_000])
@pytest.mark.parametrize("capacitor_uf", [0.01, 0.1])
def test_the_capacitor_drains_through_the_photoresistor(
    resistance_ohm: float, capacitor_uf: float
) -> None:
    bench = CellBench(capacitor_uf)
    bench.cell.light(resistance_ohm)
    expected_s = resistance_ohm * capacitor_uf * 1e-6 * math.log(5.0 / 1.4)
    assert bench.measure_ns() == pytest.approx(expected_s * 1e9, abs=1.0)


def test_counts_are_those_of_the_manuals_formula() -> None:
    """1.273 RC: 63 counts of 2 us and 169 of 0.75 us at 10 kohm and 0.01 uF."""
    bench = CellBench()
    bench.cell.light(10_000)
    time_ns = bench.measure_ns()
    assert time_ns is not None
    assert (time_ns // 2000, time_ns // 750) == (63, 169)


def test_a_wanted_count_comes_from_its_middle() -> None:
    bench = CellBench()
    bench.cell.drain(middle_ns(612, 750))
    assert bench.measure_ns() == 612 * 750 + 375


def test_measuring_again_gives_the_same() -> None:
    bench = CellBench()
    bench.cell.light(30_000)
    assert bench.measure_ns() == bench.measure_ns()


def test_dark_never_falls() -> None:
    bench = CellBench()
    bench.cell.light(None)
    assert bench.measure_ns() is None


def test_not_charged_long_enough_is_a_smaller_count() -> None:
    """1 uF behind 220 ohm has a time constant of 220 us."""
    bench = CellBench(1.0)
    bench.cell.light(10_000)
    full_ns = bench.measure_ns(10 * MS)
    # Wait until it is empty: 5 V fall to a nanovolt in 22 time constants of 10 ms.
    bench.clock.run_until(bench.clock.now_ns + 300 * MS)
    half_ns = bench.measure_ns(220 * US)
    expected_s = 0.01 * math.log((1 - math.exp(-1.0)) / 0.28)
    assert half_ns == pytest.approx(expected_s * 1e9, rel=1e-6)
    assert full_ns is not None
    assert half_ns is not None
    assert half_ns < full_ns


@pytest.mark.parametrize("constants", [2, 3, 8])
def test_what_charging_misses_is_missing_from_the_count(constants: int) -> None:
    """After n time constants of 220 ohm and C there are 1 - exp(-n) of the supply."""
    bench = CellBench(0.1)
    bench.cell.light(10_000)
    charged = 1 - math.exp(-constants)
    expected_s = 10_000 * 0.1e-6 * math.log(charged * 5.0 / 1.4)
    assert bench.measure_ns(charge_ns=constants * 22 * US) == pytest.approx(
        expected_s * 1e9, abs=2.0
    )


def test_hardly_charged_reads_low_at_once() -> None:
    bench = CellBench(1.0)
    bench.cell.light(10_000)
    # 0.28 of the supply would be reached after 0.33 time constants, 72 us.
    assert bench.measure_ns(70 * US) == 0
    bench.clock.run_until(bench.clock.now_ns + 300 * MS)
    assert bench.measure_ns(75 * US) != 0


def test_what_is_left_in_the_capacitor_counts() -> None:
    """Charged again at the threshold, it starts there and not at 0 V."""
    bench = CellBench(1.0)
    bench.cell.light(10_000)
    bench.measure_ns(10 * MS)
    again_ns = bench.measure_ns(100 * US)
    volts = 1 - (1 - 0.28) * math.exp(-100 / 220)
    assert again_ns == pytest.approx(0.01 * math.log(volts / 0.28) * 1e9, rel=1e-6)


def test_a_pin_that_drives_low_empties_it() -> None:
    bench = CellBench()
    bench.cell.light(None)
    bench.pins.set_latch(1 << PIN)
    bench.pins.set_directions(1 << PIN)
    bench.clock.run_until(MS)
    bench.pins.set_latch(0)
    bench.clock.run_until(2 * MS)
    bench.pins.set_directions(0)
    assert (bench.pins.level(PIN), bench.cell.charge) == (0, 0.0)


def test_light_that_changes_on_the_way_counts_from_then() -> None:
    bench = CellBench()
    bench.cell.light(100_000)
    full_ns = 1_272_965
    bench.clock.at(MS + full_ns // 2, lambda: bench.cell.light(10_000))
    time_ns = bench.measure_ns()
    # Half the way took half the time; the other half is ten times as fast.
    assert time_ns == pytest.approx(full_ns // 2 + full_ns / 20, abs=3)


def test_letting_go_makes_no_glitch() -> None:
    bench = CellBench()
    bench.cell.light(10_000)
    bench.pins.set_latch(1 << PIN)
    bench.pins.set_directions(1 << PIN)
    bench.clock.run_until(MS)
    heard: list[int | None] = []
    bench.pins.wires[PIN].listen(heard.append)
    bench.pins.set_directions(0)
    assert heard == []
    bench.clock.run_until(2 * MS)
    assert heard == [0]


def test_a_pin_that_is_cut_off_lets_go() -> None:
    bench = CellBench()
    bench.cell.light(10_000)
    end = Wire("main.P11")
    bench.pins.wires[PIN].join(end)
    end.drive("main.P11", 1)
    bench.clock.run_until(MS)
    end.cut("open")
    assert bench.pins.level(PIN) == 1
    bench.clock.run_until(2 * MS)
    assert bench.pins.level(PIN) == 0
