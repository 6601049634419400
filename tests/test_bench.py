"""Benches: the robot's own, faults on it, going back in time, and files that are refused."""

import re
from pathlib import Path

import pytest

from cgagen.build.bench import bench_text
from cgagen.emulator.bench import Bench
from cgagen.emulator.bench_file import parse_bench, read_bench
from cgagen.emulator.chip import Chip
from cgagen.emulator.parts.fault import BrownOut, Fault
from cgagen.emulator.parts.photocell import Photocell
from cgagen.emulator.parts.ping import Ping
from cgagen.emulator.parts.probe import Probe
from cgagen.emulator.parts.servo import Servo
from cgagen.emulator.parts.sonar import Sonar, middle_ns
from cgagen.emulator.parts.srf04 import Srf04
from cgagen.emulator.parts.uart import Uart
from cgagen.emulator.parts.whisker import Whisker
from cgagen.errors import BenchError, CgagenError, ContentionError, SourceError
from cgagen.robot import load_robot
from cgagen.stamp.chips import chip as model
from cgagen.stamp.image import Image
from cgagen.tokenizer import Tokenizer
from cgagen.tokenizer.files import read_source

FIRMWARE = Path(__file__).parent.parent / "firmware"
MS = 1_000_000
S = 1_000_000_000


def robot_bench(role: str, faults: str = "") -> Bench:
    """The checked-in programs of a robot, with a host on each Stamp and a target in front."""
    text = bench_text(load_robot(f"servobot-{role}")) + faults
    bench = parse_bench(text, "bench.toml", FIRMWARE / role)
    for chip in bench.chips:
        bench.host(chip)
    return bench


def decisions(bench: Bench) -> list[dict[str, int]]:
    """The telemetry of the main controller: `:0 F7374 R9218 ... S7 C6` is one decision."""
    text = bench.host("main").received.decode("latin-1")
    lines = [line for line in text.split("\r") if line.startswith(":")]
    return [
        {name: int(value) for name, value in re.findall(r"([A-Z]+)(\d+)", line)} for line in lines
    ]


# -- The robot --------------------------------------------------------------------------------


def test_the_predator_sees_what_its_parts_show() -> None:
    bench = robot_bench("predator")
    bench.part("sonar_front", Sonar).see_echo(middle_ns(4321, 800))
    bench.part("sonar_right", Sonar).see(20)
    bench.part("antenna_left", Whisker).touch(True)
    bench.part("light_left", Photocell).drain(middle_ns(612, 750))
    bench.run(3 * S)
    (seen, *_) = decisions(bench)
    # 20 in are 20 x 2 x 73.746 us; nothing in view of the third is 18.5 ms; dark is 0.
    assert seen | {"S": 0, "C": 0} == {
        "F": 4321,
        "R": int(20 * 2 * 73.746 / 0.8),
        "L": 23_125,
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
    bench.run(3 * S)
    before = decisions(bench)[-1]
    for side in ("left", "right"):
        bench.part(f"light_{side}", Photocell).drain(middle_ns(170, 750))
    bench.run(6 * S)
    after = decisions(bench)[-1]
    assert (before["LL"], after["LL"]) == (0, 170)
    assert before["S"] != after["S"]


def test_every_servo_is_pulsed_in_time_and_none_goes_limp() -> None:
    bench = robot_bench("predator")
    bench.run(5 * S)
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
    bench.run(2 * S)
    assert all(abs(servo.angle_deg) <= 0.5 for servo in bench.parts_of(Servo).values())
    left, right = (bench.part(f"servo_{leg}_vertical", Servo) for leg in ("LM", "RM"))
    assert left.width_ns is not None
    assert left.target_deg == pytest.approx(-right.target_deg)
    assert left.target_deg == pytest.approx(left.width_ns / 10_000 - 150)


def test_the_prey_has_six_sonars_and_answers_a_touch() -> None:
    bench = robot_bench("prey")
    assert len(bench.parts_of(Ping)) == 6
    bench.part("antenna_left", Whisker).touch(True)
    bench.run(3 * S)
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
        text.replace("pulsin_ns = 800", "pulsin_ns = 750"), "b", FIRMWARE / "predator"
    )
    bench.host("main")
    bench.part("sonar_front", Sonar).see_echo(1_500_000)
    bench.run(3 * S)
    assert decisions(bench)[0]["F"] == 2000


# -- Faults -----------------------------------------------------------------------------------


def fired(bench: Bench) -> dict[str, bool]:
    return {name: fault.fired > 0 for name, fault in bench.parts_of(Fault).items()}


def test_a_silent_sonar_counts_zero() -> None:
    bench = robot_bench("predator", '\n[fault.f]\nkind = "no_echo"\npart = "sonar_front"\n')
    bench.run(3 * S)
    assert decisions(bench)[0]["F"] == 0
    assert decisions(bench)[0]["R"] == 23_125
    assert bench.part("f", Fault).first_ns is not None


def test_an_echo_that_comes_too_late_is_none() -> None:
    """PULSIN gives up 65,535 units, 52.4 ms, after it began."""
    bench = robot_bench(
        "predator",
        '\n[fault.f]\nkind = "late_echo"\npart = "sonar_front"\nlate_us = 60000\n'
        '[fault.g]\nkind = "late_echo"\npart = "sonar_right"\nlate_us = 3000\n',
    )
    bench.run(3 * S)
    assert (decisions(bench)[0]["F"], decisions(bench)[0]["R"]) == (0, 23_125)
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
    bench.run(3 * S)
    assert decisions(bench)[0][reading] == value
    assert fired(bench) == {"f": True}


def test_without_the_step_line_the_main_controller_says_so() -> None:
    bench = robot_bench("predator", '\n[fault.f]\nkind = "open"\nend = "main.P3"\n')
    bench.run(5 * S)
    assert decisions(bench) == []
    assert b"*BUSY\r" in bench.host("main").received
    assert bench.floated == ["main.P3"]
    assert fired(bench) == {"f": True}


def test_noise_on_a_sonar_shortens_its_echo() -> None:
    bench = robot_bench(
        "predator",
        '\n[fault.f]\nkind = "noise"\nend = "main.P4"\nevery_us = 3000\nwidth_us = 20\n',
    )
    bench.run(3 * S)
    assert 0 < decisions(bench)[0]["F"] < 23_125
    assert decisions(bench)[0]["R"] == 23_125
    assert bench.part("f", Fault).fired > 500


def test_bridged_outputs_are_a_short_circuit_with_both_names() -> None:
    bench = robot_bench(
        "predator", '\n[fault.f]\nkind = "bridge"\nwires = ["servo_LF_horizontal", "step"]\n'
    )
    with pytest.raises(ContentionError, match=r"(locomotion|main)\.P\d+ drives .* drives"):
        bench.run(5 * S)


def test_a_brown_out_starts_the_chip_anew() -> None:
    bench = robot_bench(
        "predator",
        '\n[fault.f]\nkind = "brown_out"\nchips = ["main"]\nfrom_ms = 3000\nuntil_ms = 3200\n',
    )
    bench.run(3 * S + 100 * MS)
    main = bench.chip("main")
    assert (main.pins.directions, main.registers["W3"]) == (0, 0)
    assert bench.wires["command_0"].level == 0  # the pull-down
    asked = bench.part("sonar_front", Sonar).triggers
    bench.run(3 * S + 199 * MS)
    assert bench.part("sonar_front", Sonar).triggers == asked
    bench.run(6 * S)
    assert bench.host("main").received.count(b"servobot-predator") == 2
    assert bench.host("locomotion").received.count(b"servobot-predator") == 1
    assert bench.part("f", BrownOut).fired == 1
    assert bench.part("sonar_front", Sonar).triggers > asked


def test_reset_is_by_name() -> None:
    bench = robot_bench("prey")
    bench.run(1 * S)
    bench.reset("main")
    bench.run(2 * S)
    assert bench.host("main").received.count(b"servobot-prey") == 2
    with pytest.raises(BenchError, match="mian: no such chip; did you mean main"):
        bench.reset("mian")


# -- Going back -------------------------------------------------------------------------------

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
    bench.run(3 * S)
    first = record(bench)
    bench.restore(before)
    bench.part("sonar_front", Sonar).see(8)
    bench.run(3 * S)
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


# -- The bench itself -------------------------------------------------------------------------


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
    bench.run(1 * S)
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
        bench.run(1 * S)


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


# -- Files ------------------------------------------------------------------------------------

HEAD = 'format = "cgagen-bench-1"\n'
CHIP = HEAD + '[chip.main]\nmodel = "BS2"\nimage = "main.bin"\n'
PING = CHIP + '[part.front]\nkind = "ping"\n[wire.w]\nends = ["main.P4", "front.signal"]\n'


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("format = 3", "b.toml: format: 3 is not one of cgagen-bench-1"),
        ("chip = ", "b.toml: not TOML:"),
        (HEAD + "[chips.main]", "b.toml: chips: no such key; did you mean chip?"),
        (HEAD + "chip = 3", r"b.toml: chip: 3 is not a table \[chip\]"),
        (HEAD + "[chip]\nmain = 3", r"\[chip\] main: 3 is not a table \[chip.main\]"),
        (HEAD + '[chip."a b"]', r"\[chip\] a b: is no name"),
        (HEAD + "[chip.main]", r"\[chip.main\] source: missing; wanted a text"),
        (HEAD + '[chip.main]\nimage = "main.bin"', r"\[chip.main\] model: missing; bytes alone"),
        (CHIP.replace("BS2", "BS3"), r"\[chip.main\] model: 'BS3' is not one of BS2, BS2e"),
        (CHIP.replace("main.bin", "no.bin"), r"\[chip.main\] image: no.bin cannot be read"),
        (CHIP.replace("main.bin", "short.bin"), r"\[chip.main\] image: an EEPROM image of a BS2"),
        (CHIP + "slot = 1", r"\[chip.main\] image: a BS2 has no program slot 1"),
        (CHIP + "colour = 1", r"\[chip.main\] colour: no such key; known here: model"),
        (
            CHIP.replace("BS2", "BS2p") + '[[chip.main.also]]\nimage = "main.bin"',
            r"\[chip.main\] image: main: give one image for each program slot",
        ),
        (HEAD + '[chip.main]\nsource = "a.bs2"', r"\[chip.main\] source: a.bs2 is no image"),
        (CHIP + "[chip.main.timing]\npulsin = 3", r"\[chip.main.timing\] pulsin: no such key; did"),
        (CHIP + "[chip.main.timing]\npulsin_ns = 0", "pulsin_ns: 0 is not a whole number from 1"),
        (CHIP + "[wire.w]", r"\[wire.w\] ends: missing; wanted a list of ends"),
        (CHIP + "[wire.w]\nends = []", r"\[wire.w\] ends: \[\] is not a list of ends"),
        (CHIP + '[wire.w]\nends = ["legs.P3"]', r"\[wire.w\] ends: legs.P3 leads nowhere; chips"),
        (CHIP + '[wire.w]\nends = ["main.P16"]', r"\[wire.w\] ends: main.P16: no such end; there"),
        (CHIP + '[wire.w]\nends = ["main.P3"]\npull = "left"', "pull: 'left' is not one of up, do"),
        (PING + '[wire.v]\nends = ["main.P4"]', r"\[wire.v\] ends: main.P4 is on the wire w alre"),
        (PING.replace("front.signal", "front.echo"), "ends: front.echo: no such end; there are f"),
        (PING.replace('"ping"', '"pong"'), r"\[part.front\] kind: 'pong' is not one of ping, srf"),
        (PING.replace(', "front.signal"', ""), r"\[part.front\] kind: ping, but front.signal is"),
        (PING.replace('"ping"', '"ping"\ndistance = 3'), "distance: no such key; did you mean dis"),
        (PING.replace('"ping"', '"ping"\ndistance_in = -3'), "distance_in: -3 is not a number fr"),
        (CHIP + '[part.x]\nkind = "uart"', r"\[part.x\] kind: a uart has transmit or receive on"),
        (CHIP + '[part.main]\nkind = "probe"', r"\[part.main\] has the name of \[chip.main\]"),
        (
            PING.replace('"ping"', '"signal"\nchanges = [[2, 1], [1, 0]]').replace(
                "front.signal", "front.output"
            ),
            r"\[part.front\] changes: .* is not a list of \[ms, level\]",
        ),
        (PING + '[fault.f]\nkind = "rust"', r"\[fault.f\] kind: 'rust' is not one of no_echo"),
        (PING + '[fault.f]\nkind = "no_echo"\npart = "left"', r"part: left is no sonar; the sona"),
        (PING + '[fault.f]\nkind = "open"\nend = "main.P7"', "end: main.P7 is on no wire"),
        (PING + '[fault.f]\nkind = "short"\nwire = "x"\nlevel = 1', "wire: x is no wire; the wire"),
        (PING + '[fault.f]\nkind = "bridge"\nwires = ["w"]', "wires: .* is not a list of two wire"),
        (PING + '[fault.f]\nkind = "brown_out"\nchips = ["x"]', "chips: x is no chip; the chips"),
        (PING + '[fault.f]\nkind = "open"\nend = "main.P4"\nfrom_ms = -1', "from_ms: -1 is not"),
        (PING + '[fault.f]\nkind = "open"\nend = "main.P4"\nwhen = 1', "when: no such key"),
        (
            PING.replace('"front.signal"', '"front.signal", "a.output", "b.output"')
            + '[part.a]\nkind = "signal"\nlevel = 1\n[part.b]\nkind = "signal"\nlevel = 0\n',
            r"b.toml: \[wire\] w: b drives 0, a drives 1",
        ),
    ],
)
def test_a_file_that_cannot_be_is_refused_in_a_sentence(
    text: str, sentence: str, tmp_path: Path
) -> None:
    (tmp_path / "main.bin").write_bytes((FIRMWARE / "predator" / "locomotion.bin").read_bytes())
    (tmp_path / "short.bin").write_bytes(b"abc")
    with pytest.raises(BenchError, match=sentence) as refused:
        parse_bench(text, "b.toml", tmp_path)
    assert "\n" not in str(refused.value)


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(BenchError, match=r"no\.toml: cannot be read"):
        read_bench(tmp_path / "no.toml")
    (tmp_path / "b.toml").write_bytes(b"\xff")
    with pytest.raises(BenchError, match="not UTF-8 at byte 0"):
        read_bench(tmp_path / "b.toml")


def test_sources_are_compiled_before_the_emulator_sees_them(
    tmp_path: Path, tokenizer: Tokenizer
) -> None:
    source = "' {$STAMP BS2p}\n' {$PBASIC 2.5}\nDEBUG \"hello\"\nSTOP\n"
    (tmp_path / "a.bsp").write_text(source)
    (tmp_path / "b.bsp").write_text(source.replace("hello", "second"))
    text = (
        HEAD + '[chip.main]\nsource = "a.bsp"\n'
        '[[chip.main.also]]\nsource = "b.bsp"\nslot = 2\n'
        '[part.pc]\nkind = "uart"\ninverted = true\n'
        '[wire.port]\nends = ["main.SOUT", "pc.receive"]\n'
    )
    (tmp_path / "bench.toml").write_text(text)

    def compiled(path: Path) -> object:
        return tokenizer.compile(read_source(path), path.name)

    bench = read_bench(tmp_path / "bench.toml", compiled)  # type: ignore[arg-type]
    bench.run(1 * S)
    assert bench.part("pc", Uart).received == b"hello"
    assert sorted(bench.programs["main"]) == [0, 2]
    assert bench.chip("main").eeprom(2) != bench.chip("main").eeprom(0)

    (tmp_path / "a.bin").write_bytes(bench.chip("main").eeprom(2))
    both = HEAD + '[chip.main]\nmodel = "BS2p"\nimage = "a.bin"\nsource = "a.bsp"\n'
    with pytest.raises(BenchError, match=r"\[chip.main\] source: compiles to other bytes"):
        parse_bench(both, "b", tmp_path, compiled)  # type: ignore[arg-type]
    assert parse_bench(both, "b", tmp_path).programs == {}
    with pytest.raises(BenchError, match=r"model: BS2, but the source is for a BS2p"):
        parse_bench(both.replace("BS2p", "BS2"), "b", tmp_path, compiled)  # type: ignore[arg-type]
    (tmp_path / "a.bsp").write_text("' {$STAMP BS2p}\nHIGH\n")
    with pytest.raises(SourceError):
        parse_bench(both, "b", tmp_path, compiled)  # type: ignore[arg-type]


def test_every_part_and_fault_can_be_named(tmp_path: Path) -> None:
    (tmp_path / "main.bin").write_bytes(bytes(2048))
    text = (
        CHIP
        + """
[wire.a]
ends = ["main.P0", "srf.trigger", "gen.output"]
[wire.b]
ends = ["main.P1", "srf.echo", "probe.signal"]
[wire.c]
ends = ["main.P2", "cell.signal"]
[wire.d]
ends = ["main.P3", "servo.signal"]
[part.srf]
kind = "srf04"
echo_us = 2000.5
[part.gen]
kind = "signal"
level = 0
changes = [[5, 1], [5.02, 0], [100, -1]]
[part.probe]
kind = "probe"
limit_edges = 10
[part.cell]
kind = "photocell"
capacitor_uf = 0.1
drain_us = 300
[part.servo]
kind = "servo"
us_per_deg = 9
deg_per_s = 400
centre_us = 1520
angle_deg = 12.5
[fault.f]
kind = "no_echo"
part = "srf"
from_ms = 50
"""
    )
    bench = parse_bench(text, "b", tmp_path)
    bench.run(40 * MS)
    (echo,) = bench.part("probe", Probe).pulses()
    assert (echo.start_ns, echo.width_ns) == (5_020_000 + 300_000, 2_000_500)
    assert bench.part("cell", Photocell).drain_ns == 300_000
    assert bench.part("servo", Servo).angle_deg == 12.5
    assert bench.wires["a"].level == 0
    bench.run(120 * MS)
    assert bench.wires["a"].level is None


@pytest.mark.parametrize("role", ["predator", "prey"])
def test_the_robots_bench_is_the_same_text_every_time(role: str) -> None:
    robot = load_robot(f"servobot-{role}")
    assert bench_text(robot) == bench_text(load_robot(f"servobot-{role}"))
    assert bench_text(robot).isascii()


def test_errors_of_benches_have_an_exit_code() -> None:
    assert issubclass(BenchError, CgagenError)
    assert ContentionError.exit_code == BenchError.exit_code == 3
