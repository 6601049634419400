"""Benches: going back in time."""

from pathlib import Path

import pytest

from cgagen.build.bench import bench_text
from cgagen.emulator.bench import Bench
from cgagen.emulator.bench_file import parse_bench
from cgagen.emulator.parts.fault import Fault
from cgagen.emulator.parts.photocell import Photocell
from cgagen.emulator.parts.probe import Probe
from cgagen.emulator.parts.servo import Servo
from cgagen.emulator.parts.sonar import Sonar
from cgagen.emulator.parts.uart import Uart
from cgagen.emulator.parts.whisker import Whisker
from cgagen.errors import BenchError
from cgagen.robot import load_robot
from tests.bench_cases import FIRMWARE, MS, S, robot_bench

NOISY = """
[part.watch]
kind = "probe"
[part.step_watch]
kind = "probe"
[fault.hiss]
kind = "noise"
end = "main.P6"
every_us = 5000
width_us = 15
seed = 3
[fault.silence]
kind = "no_echo"
part = "sonar_right"
from_ms = 1200
until_ms = 2500
"""


def watched_bench() -> Bench:
    """The predator with noise, a fault that comes and goes, and probes."""
    text = bench_text(load_robot("servobot-predator")) + NOISY
    text = text.replace('"sonar_left.signal"]', '"sonar_left.signal", "watch.signal"]')
    text = text.replace('"locomotion.P15"]', '"locomotion.P15", "step_watch.signal"]')
    bench = parse_bench(text, "bench.toml", FIRMWARE / "predator")
    for number, sonar in enumerate(bench.parts_of(Sonar).values()):
        sonar.see(25 + 20 * number)
    bench.part("light_left", Photocell).light(50_000)
    for chip in bench.chips:
        bench.host(chip)
    return bench


def record(bench: Bench) -> tuple[object, ...]:
    """Everything that could be seen from outside."""
    probes = [probe.edges for probe in bench.parts_of(Probe).values()]
    texts = [host.received for host in bench.parts_of(Uart).values()]
    servos = [(servo.pulses, servo.angle_deg) for servo in bench.parts_of(Servo).values()]
    return probes, texts, servos, [fault.fired for fault in bench.parts_of(Fault).values()]


def test_what_follows_a_snapshot_follows_again() -> None:
    """At odd times: within echoes, bits, pulses, pauses and compiled code."""
    bench, again = watched_bench(), watched_bench()
    again.run(3 * S)
    for time_ns in (1, 617_283_945, 1_450_003_217, 2_031_415_926, 2_718_281_828):
        bench.run(time_ns)
        before = bench.snapshot()
        bench.run(3 * S)
        first = record(bench)
        assert first == record(again)
        bench.restore(before)
        assert bench.snapshot() == before
        bench.run(3 * S)
        assert record(bench) == first
        bench.restore(before)


def test_a_snapshot_is_not_changed_by_what_follows() -> None:
    bench = watched_bench()
    bench.run(1500 * MS)
    bench.host("main").send(b"x")
    before = bench.snapshot()
    seen = record(bench)
    bench.run(2 * S)
    bench.part("antenna_left", Whisker).touch(True)
    bench.chip("main").machine.memory.write(0, 2000, 77)
    bench.restore(before)
    assert record(bench) == seen
    assert bench.wires["antenna_left"].level == 1
    bench.restore(before)
    bench.run(1600 * MS)
    assert b"x" in bench.host("main").received


def test_the_other_future_differs() -> None:
    bench = watched_bench()
    bench.run(1500 * MS)
    before = bench.snapshot()
    bench.run(6 * S)
    first = record(bench)
    bench.restore(before)
    bench.part("sonar_front", Sonar).see(8)
    bench.run(6 * S)
    assert record(bench) != first


def test_faults_on_wires_can_be_taken_back() -> None:
    bench = robot_bench("predator", '\n[fault.f]\nkind = "open"\nend = "main.P8"\nfrom_ms = 1000\n')
    bench.run(900 * MS)
    before = bench.snapshot()
    bench.run(1100 * MS)
    assert bench.end("main.P8").level is None
    bench.restore(before)
    assert (bench.end("main.P8").level, bench.part("f", Fault).fired) == (1, 0)
    bench.run(1100 * MS)
    assert (bench.end("main.P8").level, bench.part("f", Fault).fired) == (None, 1)


OVERLAPPING = """format = "cgagen-bench-1"
[wire.a]
ends = ["gen.output", "seen.signal"]
[wire.b]
ends = ["other.signal"]
pull = "up"
[part.gen]
kind = "signal"
level = 0
changes = [[3, 1], [6, 0], [9, 1], [12, 0], [15, 1], [18, 0]]
[part.seen]
kind = "probe"
[part.other]
kind = "probe"
[fault.cut]
kind = "open"
end = "seen.signal"
from_ms = 2
until_ms = 14
[fault.touch]
kind = "bridge"
wires = ["a", "b"]
from_ms = 4
until_ms = 16
[fault.ground]
kind = "short"
wire = "b"
level = 0
from_ms = 8
until_ms = 13
[fault.dead]
kind = "stuck"
end = "seen.signal"
level = 1
from_ms = 10
until_ms = 17
"""


@pytest.mark.parametrize("when_ms", [1, 3, 5, 9, 11, 13, 15, 16, 17])
def test_overlapping_faults_can_be_taken_back(when_ms: int, tmp_path: Path) -> None:
    bench = parse_bench(OVERLAPPING, "b", tmp_path)
    bench.run(when_ms * MS)
    before = bench.snapshot()
    bench.run(20 * MS)
    first = record(bench)
    levels = [bench.wire(name).level for name in ("a", "b", "seen.signal", "other.signal")]
    assert levels == [0, 1, 0, 1]
    seen, other = (bench.part(name, Probe).edges for name in ("seen", "other"))
    assert [(edge.time_ns // MS, edge.level) for edge in seen] == [
        *((0, 0), (2, None), (10, 1), (17, None), (17, 1), (18, 0))
    ]
    assert [(edge.time_ns // MS, edge.level) for edge in other] == [(0, 1), (6, 0), (15, 1)]
    bench.restore(before)
    bench.run(20 * MS)
    assert record(bench) == first


def test_bookings_that_nobody_owns_are_refused() -> None:
    bench = robot_bench("prey")
    bench.clock.at(5 * MS, lambda: None)
    with pytest.raises(BenchError, match="booked at 5000000 ns that no part and no chip knows"):
        bench.snapshot()


def test_a_snapshot_fits_its_own_bench_only() -> None:
    bench = robot_bench("prey")
    before = bench.snapshot()
    bench.add_part(Whisker("late", bench.clock, bench.end("late.signal")))
    with pytest.raises(BenchError, match="other parts or chips"):
        bench.restore(before)
