"""OWIN and OWOUT against a thermometer made here from the rules of the bus."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cgagen.emulator.clock import Clock
from cgagen.emulator.commands.onewire import owin, owout
from cgagen.emulator.wires import Wire
from cgagen.errors import ExecutionError
from tests.command_bench import US, Bench, Got, Task, ToyPort, text


class Thermometer:
    """A 1-Wire part: it answers resets, collects written bits and gives those in `answer`."""

    def __init__(self, clock: Clock, wire: Wire, answer: str = "", fast: bool = False) -> None:
        self.resets, self.written, self.pulses = 0, "", list[int]()
        self._clock, self._wire, self._answer = clock, wire, answer
        self._scale = 8 if fast else 1
        self._fell_ns = 0
        self._holds = False
        wire.pull = wire.level = 1
        wire.listen(self._heard)

    def _heard(self, level: int | None) -> None:
        now = self._clock.now_ns
        if level == 0 and not self._holds:
            self._fell_ns = now
            bit, self._answer = self._answer[:1], self._answer[1:]
            if bit == "0":
                self._hold(30 * US // self._scale)
        elif level == 1 and not self._holds:
            self._pulse(now - self._fell_ns)

    def _pulse(self, width_ns: int) -> None:
        self.pulses.append(width_ns)
        if width_ns >= 480 * US // self._scale:
            self.resets += 1
            self._clock.after(30 * US // self._scale, lambda: self._hold(100 * US // self._scale))
        else:
            self.written += "1" if width_ns < 15 * US // self._scale else "0"

    def _hold(self, ns: int) -> None:
        self._holds = True
        self._wire.drive("thermometer", 0)
        self._clock.after(ns, self._let_go)

    def _let_go(self) -> None:
        self._wire.drive("thermometer", None)
        self._holds = False


def one_wire(mode: int, sent: bytes, model: str = "BS2p") -> tuple[Thermometer, Task, ToyPort]:
    bench, port = Bench(), ToyPort(model)
    part = Thermometer(bench.clock, port.pins.wires[0], fast=bool(mode & 8))
    task = bench.start(port, owout(port, text(sent), mode=mode, pin=0))
    bench.run()
    return part, task, port


@pytest.mark.parametrize(("mode", "resets"), [(0, 0), (1, 1), (2, 1), (3, 2), (9, 1), (11, 2)])
def test_owout_resets_where_the_mode_says(mode: int, resets: int) -> None:
    """S2 p. 305: OWOUT 0, 1, [$4E] resets, then sends 4Eh, lowest bit first."""
    part, task, port = one_wire(mode, b"\x4e")
    assert part.resets == resets
    assert part.written == "01110010"
    assert task.done_ns is not None
    assert port.pins.directions == 0
    assert port.pins.wires[0].level == 1


@pytest.mark.parametrize(("mode", "resets"), [(0, 0), (1, 1), (2, 1), (3, 2), (9, 1), (11, 2)])
def test_owin_resets_where_the_mode_says(mode: int, resets: int) -> None:
    """S2 p. 297."""
    bench, port = Bench(), ToyPort("BS2p")
    wire = port.pins.wires[0]
    wire.pull = wire.level = 1
    part = Thermometer(bench.clock, wire, fast=bool(mode & 8))
    task = bench.start(port, owin(port, [Got()], mode=mode, pin=0))
    bench.run()
    assert task.done_ns is not None
    assert part.resets == resets


def test_low_times_of_owout() -> None:
    """S2 p. 303, 308: reset about 564 us, a 1 begins with about 8 us, a 0 is low for 72 us."""
    part, task, _ = one_wire(1, b"\x01")
    assert part.pulses == [564 * US, 8 * US, *[72 * US] * 7]
    assert task.done_ns == 564 * US + 480 * US + 8 * 80 * US


def test_bit_mode_sends_one_bit_of_each() -> None:
    """S2 p. 305."""
    assert one_wire(4, b"\x01\x02\x03")[0].written == "101"


@pytest.mark.parametrize("mode", [0, 8])
@given(data=st.binary(min_size=1, max_size=3))
def test_owin_reads_low_bit_first(mode: int, data: bytes) -> None:
    bench, port = Bench(), ToyPort("BS2p")
    answer = "".join(f"{byte:08b}"[::-1] for byte in data)
    Thermometer(bench.clock, port.pins.wires[5], answer, fast=bool(mode))
    items = [Got() for _ in data]
    bench.start(port, owin(port, items, mode=mode, pin=5))
    bench.run()
    assert bytes(item.taken[0] for item in items) == data


def test_owin_of_single_bits() -> None:
    """S2 p. 297: in bit mode every variable takes one bit."""
    bench, port = Bench(), ToyPort("BS2p")
    Thermometer(bench.clock, port.pins.wires[5], "011")
    items = [Got(), Got(), Got()]
    bench.start(port, owin(port, items, mode=4, pin=5))
    bench.run()
    assert [item.taken for item in items] == [[0], [1], [1]]


def test_a_bs2pe_has_no_high_speed() -> None:
    """S2 p. 295."""
    with pytest.raises(ExecutionError, match="BS2pe has no high speed"):
        one_wire(9, b"a", "BS2pe")
