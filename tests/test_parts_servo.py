"""Servos: a pulse is an angle, at a speed, for fifty milliseconds."""

import pytest

from cgagen.emulator.clock import Clock
from cgagen.emulator.parts.servo import Servo
from cgagen.emulator.wires import Wire

US = 1_000
MS = 1_000_000


class ServoBench:
    """A servo and a hand that pulses it."""

    def __init__(self) -> None:
        self.clock = Clock()
        self.wire = Wire("LF")
        self.servo = Servo("LF", self.clock, self.wire)
        self.wire.drive("legs.P0", 0)

    def pulse(self, start_ns: int, width_ns: int) -> None:
        self.clock.run_until(start_ns)
        self.wire.drive("legs.P0", 1)
        self.clock.run_until(start_ns + width_ns)
        self.wire.drive("legs.P0", 0)

    def frames(self, count: int, width_ns: int, period_ns: int = 20 * MS) -> None:
        start_ns = self.clock.now_ns
        for number in range(count):
            self.pulse(start_ns + number * period_ns, width_ns)


@pytest.mark.parametrize(
    ("width_us", "angle_deg"),
    [(1500, 0), (1000, -50), (2000, 50), (700, -60), (2300, 60), (1510, 1)],
)
def test_the_width_is_an_angle_between_the_end_stops(width_us: int, angle_deg: float) -> None:
    bench = ServoBench()
    bench.frames(20, width_us * US)
    assert bench.servo.angle_deg == angle_deg
    assert bench.servo.width_ns == width_us * US


def test_it_turns_sixty_degrees_in_a_fifth_of_a_second() -> None:
    bench = ServoBench()
    bench.pulse(0, 2000 * US)
    bench.clock.run_until(2 * MS + 40 * MS)
    assert bench.servo.angle_deg == pytest.approx(12.0)
    bench.pulse(42 * MS, 1000 * US)  # back at once: 1 ms more forward, then backward
    bench.clock.run_until(43 * MS + 10 * MS)
    assert bench.servo.angle_deg == pytest.approx(12.0 + 0.3 - 3.0)


def test_it_holds_as_long_as_pulses_come() -> None:
    bench = ServoBench()
    bench.frames(20, 1800 * US, 45 * MS)
    assert not bench.servo.limp
    assert bench.servo.angle_deg == pytest.approx(30)
    assert bench.servo.pulses.limp == 0


def test_it_goes_limp_fifty_milliseconds_after_the_last_pulse() -> None:
    bench = ServoBench()
    assert bench.servo.limp
    bench.pulse(0, 2000 * US)
    bench.clock.run_until(52 * MS - 1)
    assert not bench.servo.limp
    bench.clock.run_until(500 * MS)
    assert bench.servo.limp
    assert bench.servo.angle_deg == pytest.approx(15.0)  # 50 ms of turning
    assert bench.servo.target_deg == 50
    bench.pulse(500 * MS, 2000 * US)
    assert bench.servo.pulses.limp == 1


@pytest.mark.parametrize(("start_ms", "limp"), [(49, 0), (51, 1)])
def test_a_pulse_within_fifty_milliseconds_keeps_it_held(start_ms: int, limp: int) -> None:
    bench = ServoBench()
    bench.pulse(0, 1500 * US)
    bench.pulse(start_ms * MS, 1500 * US)
    assert bench.servo.pulses.limp == limp


def test_width_period_and_jitter_are_recorded() -> None:
    bench = ServoBench()
    for start_ms, width_us in ((0, 1500), (20, 1490), (42, 1520), (61, 1500)):
        bench.pulse(start_ms * MS, width_us * US)
    seen = bench.servo.pulses
    assert (seen.taken, seen.shortest_ns, seen.longest_ns) == (4, 1490 * US, 1520 * US)
    assert (seen.shortest_period_ns, seen.longest_period_ns) == (19 * MS, 22 * MS)
    assert seen.jitter_ns == 3 * MS
    bench.servo.forget()
    bench.pulse(90 * MS, 1500 * US)
    seen = bench.servo.pulses
    assert (seen.taken, seen.longest_period_ns) == (1, 0)
    assert (seen.shortest_ns, seen.longest_ns) == (1500 * US, 1500 * US)


def test_what_is_no_pulse_moves_nothing() -> None:
    bench = ServoBench()
    bench.pulse(0, 300 * US)
    bench.pulse(20 * MS, 5 * MS)
    assert (bench.servo.pulses.odd, bench.servo.pulses.taken) == (2, 0)
    assert bench.servo.angle_deg == 0
    assert bench.servo.limp
