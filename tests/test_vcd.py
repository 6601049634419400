"""Waveforms: what is in the file, that it repeats, and that a decoder reads text out of it."""

import io
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from cgagen.emulator.bench import Bench
from cgagen.emulator.bench_file import parse_bench
from cgagen.emulator.clock import Clock
from cgagen.emulator.parts.signal import Signal
from cgagen.emulator.parts.uart import Uart
from cgagen.emulator.recording import record_bench
from cgagen.emulator.vcd import Waveform, waveform_file
from cgagen.emulator.wires import Wire
from cgagen.errors import BenchError, ContentionError, StorageError
from cgagen.tokenizer import Tokenizer
from cgagen.tokenizer.files import read_source

MS = 1_000_000
TEXT = b"count 1234\r\x00\xff!"


def record(work: Callable[[Clock, Wire, Waveform], None]) -> str:
    """What a program does to `main.SOUT`, as VCD."""
    clock, wire, file = Clock(), Wire("main.SOUT", pull=0), io.StringIO()
    with Waveform(file, clock, {"main.SOUT": wire, "led": Wire("led")}, ["main.line"]) as waveform:
        work(clock, wire, waveform)
    return file.getvalue()


def say(clock: Clock, wire: Wire, waveform: Waveform) -> None:
    """Send TEXT after 2 ms, with two lines of source."""
    uart = Uart("main", clock, wire, None, mark=0)
    clock.run_until(2 * MS)
    waveform.set("main.line", 7)
    uart.send(TEXT)
    clock.run_until(40 * MS)
    waveform.set("main.line", 8)


class Trace:
    """A reader of VCD that shares nothing with the writer."""

    def __init__(self, text: str) -> None:
        head, body = text.split("$enddefinitions $end")
        self.scale = head.split("$timescale")[1].split("$end")[0].strip()
        self.kinds: dict[str, str] = {}
        self.changes: dict[str, list[tuple[int, str]]] = {}
        names: dict[str, str] = {}
        scope: list[str] = []
        for line in head.splitlines():
            words = line.split()
            if words[:1] == ["$scope"]:
                scope.append(words[2])
            elif words[:1] == ["$upscope"]:
                scope.pop()
            elif words[:1] == ["$var"]:
                name = ".".join([*scope, words[4]])
                names[words[3]], self.kinds[name] = name, words[1]
                self.changes[name] = []
        now = 0
        for line in body.split("\n"):
            if line.startswith("#"):
                now = int(line[1:])
            elif line.startswith("r"):
                value, mark = line[1:].split()
                self.changes[names[mark]].append((now, value))
            elif line and line[0] in "01zx":
                self.changes[names[line[1:]]].append((now, line[0]))
        self.end = now

    def level(self, name: str, time: float) -> str:
        return [value for at, value in self.changes[name] if at <= time][-1]

    def bytes_of(self, name: str, baud: int, mark: str) -> bytes:
        """Decode 8N1: find a start bit, look at the middle of each bit."""
        bit, out, free = 1e9 / baud, bytearray(), 0.0
        for at, value in self.changes[name][1:]:
            if value == mark or at < free:
                continue
            bits = [self.level(name, at + (n + 0.5) * bit) == mark for n in range(10)]
            assert not bits[0]
            assert bits[9]
            out.append(sum(one << n for n, one in enumerate(bits[1:9])))
            free = at + 9.5 * bit
        return bytes(out)


def test_a_decoder_of_its_own_reads_the_text() -> None:
    trace = Trace(record(say))
    assert trace.bytes_of("main.SOUT", 9600, "0") == TEXT
    assert (trace.scale, trace.end) == ("1 ns", 40 * MS)
    assert trace.changes["wires.led"] == [(0, "z")]
    assert trace.changes["main.line"] == [(0, "0"), (2 * MS, "7"), (40 * MS, "8")]


@pytest.mark.skipif(not shutil.which("sigrok-cli"), reason="sigrok-cli is not installed")
def test_sigrok_reads_the_text(tmp_path: Path) -> None:
    file = tmp_path / "t.vcd"
    file.write_text(record(say), "ascii")
    done = subprocess.run(
        f"sigrok-cli -I vcd -i {file} -P uart:rx=SOUT:baudrate=9600:invert_rx=yes "
        f"-A uart=rx-data".split(),
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
        stdin=subprocess.DEVNULL,
    )
    assert bytes(int(line.split()[1], 16) for line in done.stdout.splitlines()) == TEXT


def test_equal_runs_give_equal_bytes() -> None:
    text = record(say)
    assert text == record(say)
    assert "$date" not in text


def test_levels_are_one_zero_and_floating() -> None:
    def work(clock: Clock, wire: Wire, _: Waveform) -> None:
        wire.pull = None
        for time_ns, level in ((10, 1), (20, None), (30, 0)):
            clock.run_until(time_ns)
            wire.drive("x", level)

    changes = Trace(record(work)).changes["main.SOUT"]
    assert changes == [(0, "0"), (10, "1"), (20, "z"), (30, "0")]


def test_recording_may_begin_later_and_ends_when_it_is_closed() -> None:
    clock, wire, file = Clock(), Wire("w"), io.StringIO()
    clock.run_until(100)
    waveform = Waveform(file, clock, {"w": wire})
    clock.run_until(150)
    wire.drive("x", 1)
    waveform.close()
    clock.run_until(200)
    wire.drive("x", 0)
    waveform.close()
    assert Trace(file.getvalue()).changes["wires.w"] == [(100, "z"), (150, "1")]


def test_time_does_not_go_back_in_a_waveform() -> None:
    clock, wire = Clock(), Wire("w")
    before = clock.state()
    with Waveform(io.StringIO(), clock, {"w": wire}):
        clock.run_until(50)
        wire.drive("x", 1)
        clock.restore(before)
        with pytest.raises(BenchError, match="went back to 0 ns"):
            wire.drive("x", 0)


def test_after_an_error_the_file_has_everything_up_to_there(tmp_path: Path) -> None:
    clock, wire, path = Clock(), Wire("w"), tmp_path / "w.vcd"
    wire.drive("a", 1)

    def short() -> None:
        with waveform_file(path, clock, {"w": wire}):
            clock.run_until(5)
            wire.drive("a", 0)
            clock.run_until(9)
            wire.drive("b", 1)

    with pytest.raises(ContentionError):
        short()
    trace = Trace(path.read_text("ascii"))
    assert (trace.changes["wires.w"], trace.end) == ([(0, "1"), (5, "0")], 9)
    assert [one.name for one in tmp_path.iterdir()] == ["w.vcd"]


def test_a_folder_that_is_not_there_is_a_sentence(tmp_path: Path) -> None:
    with pytest.raises(StorageError, match="cannot be written"):
        with waveform_file(tmp_path / "no" / "w.vcd", Clock(), {}):
            pass


PROGRAM = """' {$STAMP BS2}
' {$PBASIC 2.5}
HIGH 3
DEBUG "Hi", CR
LOW 3
STOP
"""


def robot_like(tokenizer: Tokenizer, folder: Path) -> Bench:
    """A chip with a wire and its source."""
    (folder / "a.bs2").write_text(PROGRAM)
    text = (
        'format = "cgagen-bench-1"\n[chip.main]\nsource = "a.bs2"\n[wire.led]\nends = ["main.P3"]\n'
    )
    return parse_bench(
        text, "b", folder, lambda path: tokenizer.compile(read_source(path), path.name)
    )


def test_a_bench_is_recorded_with_its_lines(tokenizer: Tokenizer, tmp_path: Path) -> None:
    files = []
    for name in ("one.vcd", "two.vcd"):
        bench = robot_like(tokenizer, tmp_path)
        host = bench.host("main")
        with record_bench(tmp_path / name, bench):
            bench.run(100 * MS)
        assert host.received == b"Hi\r"
        files.append((tmp_path / name).read_bytes())
    assert files[0] == files[1]
    trace = Trace(files[0].decode("ascii"))
    assert trace.bytes_of("main.SOUT", 9600, "0") == b"Hi\r"
    (_, high), (low_ns, low) = trace.changes["wires.led"][1:]
    assert (high, low) == ("1", "0")
    assert set(trace.changes) == {"main.SIN", "main.SOUT", "main.line", "wires.led"}
    lines = [value for _, value in trace.changes["main.line"]]
    assert lines == ["3", "4", "5", "6"]
    start_bit = trace.changes["main.SOUT"][1][0]
    assert trace.level("main.line", start_bit) == "4"
    assert trace.level("main.line", low_ns - 1) == "5"  # the next begins in that moment


def test_wires_to_record_can_be_chosen(tokenizer: Tokenizer, tmp_path: Path) -> None:
    bench = robot_like(tokenizer, tmp_path)
    with record_bench(tmp_path / "t.vcd", bench, ["main.P3", "led"], lines=False):
        bench.run(100 * MS)
    trace = Trace((tmp_path / "t.vcd").read_text("ascii"))
    assert trace.changes["main.P3"] == trace.changes["wires.led"]
    assert set(trace.changes) == {"main.P3", "wires.led"}
    with pytest.raises(BenchError, match="lad: no such wire; did you mean led"):
        with record_bench(tmp_path / "u.vcd", bench, ["lad"]):
            pass


def test_it_goes_on_behind_a_restore() -> None:
    """The file's time never goes back; every wire is at its level of that moment."""
    bench, file = Bench(), io.StringIO()
    part = bench.add_part(Signal("tester", bench.clock, bench.end("tester.out"), 0))
    wire = bench.connect("line", "tester.out")
    before = bench.snapshot()
    with Waveform(file, bench.clock, {"line": wire}) as waveform:
        bench.on_restore.append(waveform.rejoin)
        for _ in range(2):
            bench.run(bench.clock.now_ns + 5)
            part.set(1)
            bench.run(bench.clock.now_ns + 5)
            bench.restore(before)
        bench.run(bench.clock.now_ns + 7)
    told = file.getvalue().partition("$dumpvars")[2].split()
    assert told[told.index("#5") :] == ["#5", "1!", "#10", "0!", "#15", "1!", "#20", "0!", "#27"]


def test_a_full_disk_is_told_by_the_files_name(tmp_path: Path) -> None:
    def record() -> None:
        clock, wire = Clock(), Wire("w")
        with waveform_file(tmp_path / "w.vcd", clock, {"w": wire}):
            for time_ns in range(20_000):
                clock.run_until(time_ns)
                wire.drive("a", time_ns & 1)

    (tmp_path / "w.vcd").symlink_to("/dev/full")  # takes nothing, as a disk without room
    with pytest.raises(StorageError, match=r"w\.vcd: cannot be written .*No space left"):
        record()
