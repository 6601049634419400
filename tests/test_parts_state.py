"""Every part goes back to where it was, and what follows follows again."""

from collections.abc import Callable

import pytest

from cgagen.emulator.clock import Clock
from cgagen.emulator.parts.noise import Noise
from cgagen.emulator.parts.part import Part
from cgagen.emulator.parts.photocell import Photocell
from cgagen.emulator.parts.ping import Ping
from cgagen.emulator.parts.probe import Probe
from cgagen.emulator.parts.servo import Servo
from cgagen.emulator.parts.signal import Signal
from cgagen.emulator.parts.sonar_faults import LateEcho, NoEcho, StuckEcho
from cgagen.emulator.parts.srf04 import Srf04
from cgagen.emulator.parts.uart import Uart
from cgagen.emulator.parts.whisker import Whisker
from cgagen.emulator.parts.wire_faults import Bridge, Open, Short, Stuck
from cgagen.emulator.wires import Wire

MS = 1_000_000


class Small:
    """Two joined ends, a third wire, and a hand that works on the first end."""

    def __init__(self) -> None:
        self.clock = Clock()
        self.hand, self.lead, self.other = Wire("hand"), Wire("lead"), Wire("other")
        self.hand.join(self.lead)
        changes = [(time_ns, time_ns // 1000 % 2) for time_ns in range(3_000, 30 * MS, 1_777_000)]
        changes = [(time_ns, level if level else None) for time_ns, level in changes]
        self.parts: list[Part] = [
            Signal("signal", self.clock, self.hand, None, changes),
            Probe("on_lead", self.clock, self.lead),
            Probe("on_other", self.clock, self.other),
        ]

    def snapshot(self) -> tuple[object, ...]:
        wires = [(wire, wire.state()) for wire in (self.hand, self.lead, self.other)]
        return self.clock.state(), wires, [part.state() for part in self.parts]

    def restore(self, state: tuple[object, ...]) -> None:
        clock, wires, parts = state
        self.clock.restore(clock)  # type: ignore[arg-type]
        for wire, before in wires:  # type: ignore[attr-defined]
            wire.restore(before)
        for part, before in zip(self.parts, parts, strict=True):  # type: ignore[call-overload]
            part.restore(before)


def _late(small: Small) -> list[Part]:
    ping = Ping("ping", small.clock, small.lead)
    return [ping, LateEcho("late", small.clock, ping, MS, 5 * MS, 20 * MS)]


def _dead(small: Small) -> list[Part]:
    srf = Srf04("srf", small.clock, small.lead, small.other)
    srf.see(10)
    return [srf, NoEcho("dead", small.clock, srf, 9 * MS, 20 * MS)]


def _cell(small: Small) -> list[Part]:
    cell = Photocell("cell", small.clock, small.lead, 0.1)
    cell.light(20_000)
    return [cell]


def _uart(small: Small) -> list[Part]:
    uart = Uart("uart", small.clock, small.other, small.lead, 2400, echo=True)
    uart.send(b"0123456789")
    return [uart]


def _stuck(small: Small) -> list[Part]:
    ping = Ping("ping", small.clock, small.lead)
    ping.hear_nothing(6 * MS, 7_000)
    return [ping, StuckEcho("stuck_echo", small.clock, ping, 3 * MS, 9 * MS, 20 * MS)]


MAKERS: dict[str, Callable[[Small], list[Part]]] = {
    "ping": lambda small: [Ping("p", small.clock, small.lead)],
    "late": _late,
    "stuck_echo": _stuck,
    "srf04": _dead,
    "whisker": lambda small: [Whisker("w", small.clock, small.lead)],
    "photocell": _cell,
    "servo": lambda small: [Servo("s", small.clock, small.lead)],
    "uart": _uart,
    "noise": lambda small: [Noise("n", small.clock, small.lead, MS, 5_000, 3, 2 * MS, 25 * MS)],
    "open": lambda small: [Open("o", small.clock, small.lead, 4 * MS, 20 * MS)],
    "stuck": lambda small: [Stuck("k", small.clock, small.hand, 1, 4 * MS, 20 * MS)],
    "short": lambda small: [Short("h", small.clock, small.lead, 0, 4 * MS, 20 * MS)],
    "bridge": lambda small: [Bridge("b", small.clock, small.hand, small.other, 4 * MS, 20 * MS)],
}


@pytest.mark.parametrize("kind", MAKERS)
@pytest.mark.parametrize("time_ns", [0, 1_783_500, 6_250_001, 13 * MS, 22_222_222])
def test_a_part_goes_back(kind: str, time_ns: int) -> None:
    small = Small()
    small.parts += MAKERS[kind](small)
    small.clock.run_until(time_ns)
    before = small.snapshot()
    small.clock.run_until(40 * MS)
    end = small.snapshot()
    small.restore(before)
    assert small.snapshot() == before
    small.clock.run_until(40 * MS)
    assert small.snapshot() == end
    assert end != before
