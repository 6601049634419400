"""Benches: files, what can be in them, and those that are refused."""

import re
from pathlib import Path

import pytest

from cgagen.build.bench import bench_text
from cgagen.emulator import bench_file
from cgagen.emulator.bench_file import parse_bench, read_bench
from cgagen.emulator.fault_kinds import FAULTS
from cgagen.emulator.part_kinds import PARTS
from cgagen.emulator.parts.photocell import Photocell
from cgagen.emulator.parts.probe import Probe
from cgagen.emulator.parts.servo import Servo
from cgagen.emulator.parts.uart import Uart
from cgagen.errors import BenchError, CgagenError, ContentionError, SourceError
from cgagen.robot import load_robot
from cgagen.tokenizer import Tokenizer
from cgagen.tokenizer.files import read_source
from tests.bench_cases import FIRMWARE, MS, S

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
        (CHIP.replace("main.bin", "no.bin"), r"\[chip.main\] image: .*no.bin: cannot be read"),
        (CHIP.replace("main.bin", "short.bin"), r"\[chip.main\] image: an EEPROM image of a BS2"),
        (CHIP + "slot = 1", r"\[chip.main\] image: a BS2 has no program slot 1"),
        (CHIP + "colour = 1", r"\[chip.main\] colour: no such key; known here: model"),
        (
            CHIP.replace("BS2", "BS2p") + '[[chip.main.also]]\nimage = "main.bin"',
            r"\[chip.main\] also: main: give one image for each program slot",
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
        (
            PING.replace('"ping"', '"ping"\ndistance_in = 3\necho_us = 9'),
            "echo_us: says the same thing as distance_in; leave one of them out",
        ),
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
        (
            PING + '[fault.f]\nkind = "open"\nend = "main.P7"',
            "end: main.P7 is on no wire; put it on one, or name one of main.P4, front.signal$",
        ),
        (
            PING + '[fault.f]\nkind = "open"\nend = "main.P4"\nfrom_ms = 5\nuntil_ms = 5',
            "until_ms: 5 is not later than from_ms",
        ),
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

    named = source.replace("BS2p", "BS2p, b.bsp").replace("hello", "first")
    (tmp_path / "a.bsp").write_text(named)
    alone = parse_bench(HEAD + '[chip.main]\nsource = "a.bsp"\n', "b", tmp_path, compiled)  # type: ignore[arg-type]
    assert {slot: one.name for slot, one in alone.programs["main"].items()} == {
        0: "a.bsp",
        1: "b.bsp",
    }
    assert sorted(parse_bench(text, "b", tmp_path, compiled).programs["main"]) == [0, 2]  # type: ignore[arg-type]
    (tmp_path / "a.bsp").write_text(source)

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


NEEDED = {
    "air": 'sonars = ["s"]',
    "photocell": "capacitor_uf = 1",
    "late_echo": 'part = "s"\nlate_us = 1',
    "no_echo": 'part = "s"',
    "stuck_echo": 'part = "s"',
    "stuck": 'end = "main.P4"\nlevel = 1',
    "open": 'end = "main.P4"',
    "short": 'wire = "w"\nlevel = 1',
    "bridge": 'wires = ["w", "v"]',
    "noise": 'end = "main.P4"\nevery_us = 9\nwidth_us = 1',
    "brown_out": 'chips = ["main"]',
    "uart": 'send = "a"',
}
"""Settings that a kind cannot do without."""


@pytest.mark.parametrize("section", ["part", "fault"])
def test_what_can_be_in_a_file_is_described(section: str, tmp_path: Path) -> None:
    """Every kind has a row in the module's text, with all its ends and settings."""
    (tmp_path / "main.bin").write_bytes(bytes(2048))
    described = re.findall(r"^    (\w+) +(\S.*(?:\n {33}.*)?)$", bench_file.__doc__ or "", re.M)
    rows = {word: set(re.findall(r"\w+", rest)) for word, rest in described}
    for kind in PARTS if section == "part" else FAULTS:
        part = PARTS.get(kind)
        leads = () if part is None else (*part.leads, *part.optional)
        ends = [f'"x.{lead}", "main.P{n}"' for n, lead in enumerate(leads)]
        wires = "".join(f"[wire.w{n}]\nends = [{end}]\n" for n, end in enumerate(ends))
        text = (
            CHIP + '[part.s]\nkind = "ping"\n[wire.w]\nends = ["s.signal", "main.P4"]\n'
            f'[wire.v]\nends = ["main.P5"]\n{wires}'
            f'[{section}.x]\nkind = "{kind}"\n{NEEDED.get(kind, "")}\n"?" = 1\n'
        )
        with pytest.raises(BenchError, match=r"no such key; known here: ") as refused:
            parse_bench(text, "b", tmp_path)
        known = set(re.findall(r"\w+", str(refused.value).rpartition(": ")[2]))
        assert rows[kind] >= known - {"kind", "from_ms", "until_ms"} | set(leads), kind


@pytest.mark.parametrize("role", ["predator", "prey"])
def test_the_robots_bench_is_the_same_text_every_time(role: str) -> None:
    robot = load_robot(f"servobot-{role}")
    assert bench_text(robot) == bench_text(load_robot(f"servobot-{role}"))
    assert bench_text(robot).isascii()


def test_errors_of_benches_have_an_exit_code() -> None:
    assert issubclass(BenchError, CgagenError)
    assert ContentionError.exit_code == BenchError.exit_code == 3
