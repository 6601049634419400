"""Benches: the robot's own with all its parts, and what chips and hosts do on any."""

import pytest

from cgagen.build.bench import bench_text
from cgagen.emulator.bench import Bench
from cgagen.emulator.bench_file import parse_bench
from cgagen.emulator.chip import Chip
from cgagen.emulator.parts.photocell import Photocell
from cgagen.emulator.parts.ping import Ping
from cgagen.emulator.parts.servo import Servo
from cgagen.emulator.parts.sonar import Sonar, middle_ns
from cgagen.emulator.parts.srf04 import Srf04
from cgagen.emulator.parts.whisker import Whisker
from cgagen.errors import BenchError, ContentionError
from cgagen.robot import load_robot
from cgagen.stamp.chips import chip as model
from cgagen.stamp.image import Image
from cgagen.tokenizer import Tokenizer
from hil.simulated import SimulatedTarget
from hil.subject import read_subject
from hil.target import Stimulus
from tests.bench_cases import FIRMWARE, MS, STARTS, S, decisions, robot_bench


def test_the_predator_sees_what_its_parts_show() -> None:
    bench = robot_bench("predator")
    bench.part("sonar_front", Sonar).see_echo(middle_ns(4321, 750))
    bench.part("sonar_right", Sonar).see(20)
    bench.part("antenna_left", Whisker).touch(True)
    bench.part("light_left", Photocell).drain(middle_ns(612, 750))
    bench.run((3 + STARTS) * S)
    (seen, *_) = decisions(bench)
    # 20 in are 20 x 2 x 73.746 us; nothing in view of the third is 20 ms (S10); dark is 0.
    assert seen | {"S": 0, "C": 0} == {
        "F": 4321,
        "R": int(20 * 2 * 73.746 / 0.75),
        "L": 26_666,
        "LL": 612,
        "LR": 0,
        "AL": 0,
        "AR": 1,
        "S": 0,
        "C": 0,
    }
    assert bench.floated == []


def test_a_light_that_comes_on_changes_the_decision() -> None:
    bench = robot_bench("predator")
    bench.run((3 + STARTS) * S)
    before = decisions(bench)[-1]
    for side in ("left", "right"):
        bench.part(f"light_{side}", Photocell).drain(middle_ns(170, 750))
    bench.run((6 + STARTS) * S)
    after = decisions(bench)[-1]
    assert (before["LL"], after["LL"]) == (0, 170)
    assert before["S"] != after["S"]


def test_every_servo_is_pulsed_in_time_and_none_goes_limp() -> None:
    bench = robot_bench("predator")
    bench.run((5 + STARTS) * S)
    servos = bench.parts_of(Servo)
    assert len(servos) == 12
    for servo in servos.values():
        seen = servo.pulses
        assert seen.taken > 100
        assert (seen.odd, seen.limp) == (0, 0)
        assert 1_000_000 <= seen.shortest_ns <= seen.longest_ns <= 2_000_000
        assert seen.longest_period_ns < 45 * MS


def test_mirrored_servos_turn_the_same_way() -> None:
    """Centred by the locomotion controller after its start, all stand within one step of 0."""
    bench = robot_bench("prey")
    bench.run((2 + STARTS) * S)
    assert all(abs(servo.angle_deg) <= 0.5 for servo in bench.parts_of(Servo).values())
    left, right = (bench.part(f"servo_{leg}_vertical", Servo) for leg in ("LM", "RM"))
    assert left.width_ns is not None
    assert left.target_deg == pytest.approx(-right.target_deg)
    assert left.target_deg == pytest.approx(left.width_ns / 10_000 - 150)


def test_the_prey_has_six_sonars_and_answers_a_touch() -> None:
    bench = robot_bench("prey")
    assert len(bench.parts_of(Ping)) == 6
    bench.part("antenna_left", Whisker).touch(True)
    bench.run((3 + STARTS) * S)
    assert decisions(bench)[0]["AL"] == 0
    assert decisions(bench)[0]["C"] != 1  # WAIT


def test_the_bench_of_an_srf04_has_two_wires() -> None:
    text = load_robot("servobot-predator").text
    text = text.replace('"ping"', '"srf04"').replace(
        "\npin = 4 ", "\ntrigger_pin = 4\necho_pin = 7 "
    )
    text = text.replace("\npin = 5 ", "\ntrigger_pin = 5\necho_pin = 12 ")
    text = text.replace("\npin = 6 ", "\ntrigger_pin = 6\necho_pin = 13 ")
    from cgagen.robot.reader import parse_robot

    bench = parse_bench(bench_text(parse_robot(text, "srf")), "b", FIRMWARE / "predator")
    assert len(bench.parts_of(Srf04)) == 3
    assert bench.wire_of("main.P12") == bench.wire_of("sonar_right.echo") == "sonar_right_echo"


def test_units_of_the_robot_are_those_of_the_emulated_chip() -> None:
    text = bench_text(load_robot("servobot-predator"))
    bench = parse_bench(
        text.replace("pulsin_ns = 750", "pulsin_ns = 800"), "b", FIRMWARE / "predator"
    )
    bench.host("main")
    bench.part("sonar_front", Sonar).see_echo(1_500_000)
    bench.run((3 + STARTS) * S)
    assert decisions(bench)[0]["F"] == 1875


def test_however_long_a_silence_is_it_is_farther_than_everything() -> None:
    """19.98 to 20.01 ms within a day (S10, 119926); the simulator has the 18.5 ms of S6."""
    ping = 'kind = "ping"'
    text = bench_text(load_robot("servobot-predator"))
    text = text.replace(ping, f"{ping}\nsilence_us = 19982\ndrift_us = 28")
    bench = parse_bench(text, "b", FIRMWARE / "predator")
    for chip in ("main", "locomotion"):
        bench.host(chip)
    bench.run((12 + STARTS) * S)
    seen = decisions(bench)
    counts = [one["F"] for one in seen]
    # the first stands behind the prompts
    assert len(counts) >= 7
    steps = [n % 8 for n in range(1, 1 + len(counts))]
    assert counts == [(19_982_000 + 4_000 * step) // 750 for step in steps]
    simulated = SimulatedTarget(read_subject(FIRMWARE / "predator"))
    nothing = simulated.decide(Stimulus((24_666,) * 3, lights=(0, 0)))
    assert {one["S"] for one in seen} == {nothing.state}


def program(tokenizer: Tokenizer, source: str, name: str = "BS2") -> Image:
    return tokenizer.compile(f"' {{$STAMP {name}}}\n' {{$PBASIC 2.5}}\n{source}\n").image


def test_two_chips_talk_over_a_wire(tokenizer: Tokenizer) -> None:
    """One writes a nibble and pulls a wire; the other answers on its port."""
    bench = Bench()
    writer = "OUTA = %101\nDIRA = %1111\nPAUSE 5\nHIGH 3\nSTOP"
    reader = "DO : LOOP UNTIL IN3 = 1\nDEBUG BIN3 (INA & 7), CR\nSTOP"
    bench.add_chip(Chip("a", [program(tokenizer, writer)], bench.clock))
    bench.add_chip(Chip("b", [program(tokenizer, reader, "BS2p")], bench.clock))
    for pin in range(4):
        bench.connect(f"w{pin}", f"a.P{pin}", f"b.P{pin}", pull=0)
    host = bench.host("b")
    assert bench.run_until(lambda: host.received.endswith(b"\r"), 1 * S)
    assert host.received == b"101\r"
    assert 5 * MS < bench.clock.now_ns < 30 * MS
    assert not bench.run_until(lambda: False, 1 * S)
    assert bench.clock.now_ns == 1 * S


def test_what_a_host_sends_comes_back(tokenizer: Tokenizer) -> None:
    bench = Bench()
    source = "x VAR Byte\nPAUSE 20\nDEBUGIN DEC x\nDEBUG DEC x * 2\nSTOP"
    bench.add_chip(Chip("a", [program(tokenizer, source)], bench.clock))
    host = bench.host("a")
    bench.run(30 * MS)
    host.send(b"21\r")
    bench.run((1 + STARTS) * S)
    assert host.received == b"21\r42"
    assert bench.host("a") is host


def test_run_until_gives_up_at_its_limit_also_where_nothing_is_booked() -> None:
    bench = Bench()
    assert not bench.run_until(lambda: False, 7 * MS)
    assert bench.clock.now_ns == 7 * MS
    assert bench.run_until(lambda: True, 7 * MS)


def test_outputs_of_two_chips_on_one_wire_are_contention(tokenizer: Tokenizer) -> None:
    bench = Bench()
    bench.add_chip(Chip("a", [program(tokenizer, "HIGH 0\nSTOP")], bench.clock))
    bench.add_chip(Chip("b", [program(tokenizer, "PAUSE 2\nLOW 7\nSTOP")], bench.clock))
    bench.connect("bus", "a.P0", "b.P7")
    with pytest.raises(ContentionError, match=r"^bus: b\.P7 drives 0, a\.P0 drives 1; take one"):
        bench.run((1 + STARTS) * S)


def test_ends_and_names() -> None:
    bench = Bench()
    bench.add_chip(Chip("main", [Image(model("BS2"), bytes(2048))], bench.clock))
    with pytest.raises(BenchError, match=r"main\.P16: no such end"):
        bench.connect("w", "main.P16")
    bench.connect("w", "main.P0")
    with pytest.raises(BenchError, match=r"v: main\.P0 is on the wire w already"):
        bench.connect("v", "main.P0")
    with pytest.raises(BenchError, match="main: there is one of that name already"):
        bench.add_part(Whisker("main", bench.clock, bench.end("x.signal")))
    bench.add_part(Whisker("left", bench.clock, bench.end("left.signal")))
    with pytest.raises(BenchError, match="left: is a Whisker, where a Ping is wanted"):
        bench.part("left", Ping)
    with pytest.raises(BenchError, match="front: no such part; there are left"):
        bench.part("front", Ping)
    with pytest.raises(BenchError, match="no such chip"):
        bench.host("legs")
