"""The kinds of faults that a bench file can name, and their settings."""

from collections.abc import Callable

from cgagen.emulator.bench import Bench
from cgagen.emulator.bench_table import LONGEST_US, BenchTable
from cgagen.emulator.parts.fault import BrownOut, Fault
from cgagen.emulator.parts.noise import Noise
from cgagen.emulator.parts.sonar import Sonar
from cgagen.emulator.parts.sonar_faults import LateEcho, NoEcho, StuckEcho
from cgagen.emulator.parts.wire_faults import Bridge, Open, Short, Stuck
from cgagen.emulator.wires import Wire


def make_fault(bench: Bench, name: str, kind: str, table: BenchTable) -> Fault:
    """Return a fault of a kind, by its settings; the bench is whole but for faults.

    Raises:
        BenchError: a setting that cannot be.
    """
    from_ns, until_ns = table.nanoseconds("from_ms") or 0, table.nanoseconds("until_ms")
    if until_ns is not None and until_ns <= from_ns:
        raise table.error("until_ms", f"{until_ns / 1e6:g} is not later than from_ms; swap them")
    return FAULTS[kind](bench, name, table, (from_ns, until_ns))


STUCK_US = 850.0
"""Echo of a PING))) that is stuck. Ref: S10 (95609, 101364, 111253): 422 to 428 counts of 2 us."""

_Times = tuple[int, int | None]


def _no_echo(bench: Bench, name: str, table: BenchTable, times: _Times) -> Fault:
    return NoEcho(name, bench.clock, _sonar(bench, table), *times)


def _late_echo(bench: Bench, name: str, table: BenchTable, times: _Times) -> Fault:
    late_ns = round(table.number("late_us", 0, LONGEST_US) * 1_000)
    return LateEcho(name, bench.clock, _sonar(bench, table), late_ns, *times)


def _stuck_echo(bench: Bench, name: str, table: BenchTable, times: _Times) -> Fault:
    echo_ns = round(table.number_or("echo_us", 1, LONGEST_US, STUCK_US) * 1_000)
    return StuckEcho(name, bench.clock, _sonar(bench, table), echo_ns, *times)


def _stuck(bench: Bench, name: str, table: BenchTable, times: _Times) -> Fault:
    return Stuck(name, bench.clock, _end(bench, table), table.integer("level", 0, 1), *times)


def _open(bench: Bench, name: str, table: BenchTable, times: _Times) -> Fault:
    return Open(name, bench.clock, _end(bench, table), *times)


def _short(bench: Bench, name: str, table: BenchTable, times: _Times) -> Fault:
    wire, level = _wire(bench, table, table.text("wire")), table.integer("level", 0, 1)
    return Short(name, bench.clock, wire, level, *times)


def _bridge(bench: Bench, name: str, table: BenchTable, times: _Times) -> Fault:
    wanted = "a list of two wires"
    names = table.texts("wires", wanted)
    if len(names) != 2:
        raise table.error("wires", f"{names!r} is not {wanted}")
    one, other = (_wire(bench, table, each, "wires") for each in names)
    return Bridge(name, bench.clock, one, other, *times)


def _noise(bench: Bench, name: str, table: BenchTable, times: _Times) -> Fault:
    end = _end(bench, table)
    every_ns = round(table.number("every_us", 1, LONGEST_US) * 1_000)
    width_ns = round(table.number("width_us", 0.001, LONGEST_US) * 1_000)
    seed = table.integer_or("seed", 0, 1 << 62, 0)
    return Noise(name, bench.clock, end, every_ns, width_ns, seed, *times)


def _brown_out(bench: Bench, name: str, table: BenchTable, times: _Times) -> Fault:
    names = table.texts("chips", "a list of chips")
    for one in names:
        if one not in bench.chips:
            known = ", ".join(bench.chips) or "none"
            raise table.error("chips", f"{one} is no chip; the chips are {known}")
    chips = [bench.chips[one] for one in names]

    def power(on: bool) -> None:
        for chip in chips:
            if on:
                chip.reset()
            else:
                chip.hold()

    return BrownOut(name, bench.clock, power, *times)


def _sonar(bench: Bench, table: BenchTable) -> Sonar:
    name, sonars = table.text("part"), bench.parts_of(Sonar)
    if name not in sonars:
        known = ", ".join(sonars) or "none"
        raise table.error("part", f"{name} is no sonar; the sonars are {known}")
    return sonars[name]


def _end(bench: Bench, table: BenchTable) -> Wire:
    name = table.text("end")
    if bench.wire_of(name) is None:
        known = ", ".join(bench.connected) or "none"
        raise table.error("end", f"{name} is on no wire; put it on one, or name one of {known}")
    return bench.end(name)


def _wire(bench: Bench, table: BenchTable, name: str, key: str = "wire") -> Wire:
    if name not in bench.wires:
        raise table.error(
            key, f"{name} is no wire; the wires are {', '.join(bench.wires) or 'none'}"
        )
    return bench.wires[name]


FAULTS: dict[str, Callable[[Bench, str, BenchTable, _Times], Fault]] = {
    "no_echo": _no_echo,
    "late_echo": _late_echo,
    "stuck_echo": _stuck_echo,
    "stuck": _stuck,
    "open": _open,
    "short": _short,
    "bridge": _bridge,
    "noise": _noise,
    "brown_out": _brown_out,
}
"""By the word in the file."""
