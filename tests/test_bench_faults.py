"""Benches: faults on the robot's own."""

import pytest

from cgagen.emulator.bench import Bench
from cgagen.emulator.parts.fault import BrownOut, Fault
from cgagen.emulator.parts.photocell import Photocell
from cgagen.emulator.parts.sonar import Sonar
from cgagen.errors import BenchError, ContentionError
from tests.bench_cases import MS, STARTS, S, decisions, robot_bench


def fired(bench: Bench) -> dict[str, bool]:
    return {name: fault.fired > 0 for name, fault in bench.parts_of(Fault).items()}


def test_a_silent_sonar_counts_zero() -> None:
    bench = robot_bench("predator", '\n[fault.f]\nkind = "no_echo"\npart = "sonar_front"\n')
    bench.run((3 + STARTS) * S)
    assert decisions(bench)[0]["F"] == 0
    assert decisions(bench)[0]["R"] == 26_666
    assert bench.part("f", Fault).first_ns is not None


def test_an_echo_that_comes_too_late_is_none() -> None:
    """PULSIN gives up 65,535 units, 49.2 ms, after it began."""
    bench = robot_bench(
        "predator",
        '\n[fault.f]\nkind = "late_echo"\npart = "sonar_front"\nlate_us = 60000\n'
        '[fault.g]\nkind = "late_echo"\npart = "sonar_right"\nlate_us = 3000\n',
    )
    bench.run((3 + STARTS) * S)
    assert (decisions(bench)[0]["F"], decisions(bench)[0]["R"]) == (0, 26_666)
    assert fired(bench) == {"f": True, "g": True}


@pytest.mark.parametrize(
    ("fault", "reading", "value"),
    [
        ('kind = "stuck"\nend = "main.P8"\nlevel = 0', "AL", 0),
        ('kind = "short"\nwire = "antenna_left"\nlevel = 0', "AL", 0),
        ('kind = "open"\nend = "antenna_left.signal"', "AL", 0),
        ('kind = "open"\nend = "sonar_front.signal"', "F", 0),
        ('kind = "stuck"\nend = "main.P4"\nlevel = 1', "F", 0),
        ('kind = "short"\nwire = "light_left"\nlevel = 0', "LL", 1),
    ],
)
def test_a_fault_on_a_wire_is_what_the_chip_reads(fault: str, reading: str, value: int) -> None:
    bench = robot_bench("predator", f"\n[fault.f]\n{fault}\n")
    for cell in bench.parts_of(Photocell).values():
        cell.light(20_000)
    bench.run((3 + STARTS) * S)
    assert decisions(bench)[0][reading] == value
    assert fired(bench) == {"f": True}


def test_without_the_step_line_the_main_controller_says_so() -> None:
    bench = robot_bench("predator", '\n[fault.f]\nkind = "open"\nend = "main.P3"\n')
    bench.run((5 + STARTS) * S)
    assert decisions(bench) == []
    assert b"*BUSY\r" in bench.host("main").received
    assert bench.floated == ["main.P3"]
    assert fired(bench) == {"f": True}


def test_noise_on_a_sonar_shortens_its_echo() -> None:
    bench = robot_bench(
        "predator",
        '\n[fault.f]\nkind = "noise"\nend = "main.P4"\nevery_us = 3000\nwidth_us = 20\n',
    )
    bench.run((3 + STARTS) * S)
    assert 0 < decisions(bench)[0]["F"] < 26_666
    assert decisions(bench)[0]["R"] == 26_666
    assert bench.part("f", Fault).fired > 500


def test_bridged_outputs_are_a_short_circuit_with_both_names() -> None:
    bench = robot_bench(
        "predator", '\n[fault.f]\nkind = "bridge"\nwires = ["servo_LF_horizontal", "step"]\n'
    )
    with pytest.raises(ContentionError, match=r"(locomotion|main)\.P\d+ drives .* drives"):
        bench.run((5 + STARTS) * S)


def test_a_brown_out_starts_the_chip_anew() -> None:
    bench = robot_bench(
        "predator",
        '\n[fault.f]\nkind = "brown_out"\nchips = ["main"]\nfrom_ms = 3000\nuntil_ms = 3200\n',
    )
    bench.run((3 + STARTS) * S + 100 * MS)
    main = bench.chip("main")
    assert (main.pins.directions, main.registers["W3"]) == (0, 0)
    assert bench.wires["command_0"].level == 0  # the pull-down
    asked = bench.part("sonar_front", Sonar).triggers
    bench.run((3 + STARTS) * S + 199 * MS)
    assert bench.part("sonar_front", Sonar).triggers == asked
    bench.run((6 + STARTS) * S)
    assert bench.host("main").received.count(b"servobot-predator") == 2
    assert bench.host("locomotion").received.count(b"servobot-predator") == 1
    assert bench.part("f", BrownOut).fired == 1
    assert bench.part("sonar_front", Sonar).triggers > asked


def test_reset_is_by_name() -> None:
    bench = robot_bench("prey")
    bench.run((1 + STARTS) * S)
    bench.reset("main")
    bench.run((2 + STARTS) * S)
    assert bench.host("main").received.count(b"servobot-prey") == 2
    with pytest.raises(BenchError, match="mian: no such chip; did you mean main"):
        bench.reset("mian")
