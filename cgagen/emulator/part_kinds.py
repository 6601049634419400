"""The kinds of parts that a bench file can name, and their settings."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from cgagen.emulator.bench import Bench
from cgagen.emulator.bench_table import LONGEST_US, BenchTable
from cgagen.emulator.parts.air import Air
from cgagen.emulator.parts.part import Part
from cgagen.emulator.parts.photocell import Photocell
from cgagen.emulator.parts.ping import SILENCE_NS, Ping
from cgagen.emulator.parts.probe import LIMIT_EDGES, Probe
from cgagen.emulator.parts.servo import CENTRE_NS, Servo
from cgagen.emulator.parts.signal import Signal
from cgagen.emulator.parts.sonar import Sonar
from cgagen.emulator.parts.srf04 import Srf04
from cgagen.emulator.parts.uart import BAUD, Uart
from cgagen.emulator.parts.whisker import Whisker
from cgagen.emulator.wires import Strength, Wire


@dataclass(frozen=True, slots=True)
class PartKind:
    """A kind of part.

    Attributes:
        leads: that must be on wires.
        optional: leads that may be.
        make: from bench, name, the leads that are on wires, and settings.
    """

    leads: tuple[str, ...]
    optional: tuple[str, ...]
    make: Callable[[Bench, str, Mapping[str, Wire], BenchTable], Part]


def _sonar(sonar: Sonar, table: BenchTable) -> Sonar:
    given = table.either("distance_in", "echo_us")
    if given == "echo_us":
        sonar.see_echo(table.nanoseconds("echo_us"))
    elif given is not None:
        sonar.see(table.number("distance_in", 0, 1000))
    return sonar


def _ping(bench: Bench, name: str, leads: Mapping[str, Wire], table: BenchTable) -> Part:
    ping = Ping(name, bench.clock, leads["signal"])
    silence_us = table.number_or("silence_us", 115, LONGEST_US, SILENCE_NS / 1_000)
    drift_us = table.number_or("drift_us", 0, LONGEST_US, 0)
    ping.hear_nothing(round(silence_us * 1_000), round(drift_us * 1_000))
    return _sonar(ping, table)


def _srf04(bench: Bench, name: str, leads: Mapping[str, Wire], table: BenchTable) -> Part:
    grounded = table.flag_or("mode_grounded", False)
    return _sonar(Srf04(name, bench.clock, leads["trigger"], leads["echo"], grounded), table)


def _air(bench: Bench, name: str, leads: Mapping[str, Wire], table: BenchTable) -> Part:
    wanted = "a list of sonars that stand before it in the file"
    sonars = bench.parts_of(Sonar)
    named = table.texts("sonars", wanted)
    for one in named:
        if one not in sonars or named.count(one) > 1:
            raise table.error("sonars", f"{one!r} is not {wanted}, each once")
        if sonars[one].air is not None:
            raise table.error("sonars", f"{one!r} shares another air; name it in one of them")
    air = Air(name, bench.clock, [sonars[one] for one in named])
    if table.offers("late_in"):
        air.see(*table.numbers("late_in", 0, 1000))
    return air


def _whisker(bench: Bench, name: str, leads: Mapping[str, Wire], table: BenchTable) -> Part:
    whisker = Whisker(name, bench.clock, leads["signal"])
    whisker.touch(table.flag_or("touched", False))
    return whisker


def _photocell(bench: Bench, name: str, leads: Mapping[str, Wire], table: BenchTable) -> Part:
    capacitor_uf = table.number("capacitor_uf", 1e-6, 1e4)
    cell = Photocell(name, bench.clock, leads["signal"], capacitor_uf)
    given = table.either("resistance_ohm", "drain_us")
    if given == "drain_us":
        cell.drain(table.nanoseconds("drain_us"))
    elif given is not None:
        cell.light(table.number("resistance_ohm", 1, 1e9))
    return cell


def _servo(bench: Bench, name: str, leads: Mapping[str, Wire], table: BenchTable) -> Part:
    mirrored = table.flag_or("mirrored", False)
    return Servo(
        name,
        bench.clock,
        leads["signal"],
        table.number_or("us_per_deg", 1, 100, 10) * (-1_000 if mirrored else 1_000),
        1e9 / table.number_or("deg_per_s", 1, 10_000, 300),
        table.number_or("angle_deg", -180, 180, 0),
        round(table.number_or("centre_us", 500, 2_500, CENTRE_NS / 1_000) * 1_000),
    )


def _uart(bench: Bench, name: str, leads: Mapping[str, Wire], table: BenchTable) -> Part:
    if not leads:
        raise table.error("kind", "a uart has transmit or receive on a wire; connect one")
    uart = Uart(
        name,
        bench.clock,
        leads.get("transmit"),
        leads.get("receive"),
        table.integer_or("baud", 50, 1_000_000, BAUD),
        0 if table.flag_or("inverted", False) else 1,
        table.flag_or("seven_even", False),
        table.flag_or("echo", False),
    )
    if table.offers("send"):
        data = table.text("send").encode("latin-1", "replace")
        uart.send_at(data, table.nanoseconds("send_ms") or 0)
    return uart


def _probe(bench: Bench, name: str, leads: Mapping[str, Wire], table: BenchTable) -> Part:
    limit = table.integer_or("limit_edges", 1, 10_000_000, LIMIT_EDGES)
    return Probe(name, bench.clock, leads["signal"], limit)


def _signal(bench: Bench, name: str, leads: Mapping[str, Wire], table: BenchTable) -> Part:
    level = table.integer("level", 0, 1) if table.offers("level") else None
    strength = Strength.RESISTOR if table.flag_or("resistor", False) else Strength.OUTPUT
    changes = _changes(table) if table.offers("changes") else []
    return Signal(name, bench.clock, leads["output"], level, changes, strength)


def _changes(table: BenchTable) -> list[tuple[int, int | None]]:
    wanted = "a list of [ms, level] with rising times and the levels 0, 1 or -1 to let go"
    value = table.take("changes", wanted)
    changes: list[tuple[int, int | None]] = []
    for one in value if isinstance(value, list) else [None]:
        match one:
            case [int() | float() as time_ms, 0 | 1 | -1 as level] if (
                0 <= time_ms <= LONGEST_US / 1_000
                and (not changes or round(time_ms * 1_000_000) > changes[-1][0])
            ):
                changes.append((round(time_ms * 1_000_000), None if level < 0 else int(level)))
            case _:
                raise table.error("changes", f"{value!r} is not {wanted}")
    return changes


PARTS: dict[str, PartKind] = {
    "ping": PartKind(("signal",), (), _ping),
    "srf04": PartKind(("trigger", "echo"), (), _srf04),
    "air": PartKind((), (), _air),
    "whisker": PartKind(("signal",), (), _whisker),
    "photocell": PartKind(("signal",), (), _photocell),
    "servo": PartKind(("signal",), (), _servo),
    "uart": PartKind((), ("transmit", "receive"), _uart),
    "probe": PartKind(("signal",), (), _probe),
    "signal": PartKind(("output",), (), _signal),
}
"""By the word in the file."""
