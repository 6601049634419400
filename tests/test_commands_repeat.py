"""Every instruction can be repeated: the same levels and answers give the same requests.

A snapshot in the middle of an instruction rests on that.
"""

import inspect
from collections import deque
from collections.abc import Callable

import pytest

from cgagen.emulator.commands import COMMANDS
from cgagen.emulator.commands.analog import dtmfout, freqout, pwm
from cgagen.emulator.commands.i2c import i2cin, i2cout
from cgagen.emulator.commands.lcd import lcdcmd, lcdin, lcdout
from cgagen.emulator.commands.onewire import owin, owout
from cgagen.emulator.commands.pulses import count, pulsin, pulsout, rctime
from cgagen.emulator.commands.serial_in import serin
from cgagen.emulator.commands.serial_out import serout, serout_flow
from cgagen.emulator.commands.shift import shiftin, shiftout
from cgagen.emulator.commands.xout import xout
from cgagen.emulator.port import Jump, Result
from cgagen.emulator.requests import Command, Delay, Request
from cgagen.stamp.chips import CHIPS
from cgagen.stamp.opcodes import opcodes_of
from tests.command_bench import MS, US, Bench, Got, Sent, ToyPort, finished, text

Start = Callable[[ToyPort], Command[Result]]

RUNS: dict[str, Start] = {
    "COUNT": lambda p: count(p, duration=20, pin=1),
    "DTMFOUT": lambda p: dtmfout(p, [Sent(5), Sent(11)], pin=2, off_time=1, on_time=3),
    "FREQOUT": lambda p: freqout(p, pin=2, duration=3, frequency=900),
    "FREQOUT_TWO": lambda p: freqout(p, pin=2, duration=3, frequency=900, second=700),
    "I2CIN": lambda p: i2cin(p, [Got()], pin=8, slave=0xA1, address=3),
    "I2CIN_LOW": lambda p: i2cin(p, [Got()], pin=8, slave=0xA1, address=3, low_address=4),
    "I2COUT": lambda p: i2cout(p, text(b"a"), pin=8, slave=0xA0, address=3),
    "I2COUT_LOW": lambda p: i2cout(p, text(b"a"), pin=8, slave=0xA0, address=3, low_address=4),
    "LCDCMD": lambda p: lcdcmd(p, command=1, pin=8),
    "LCDIN": lambda p: lcdin(p, [Got(6, 2, stores=False)], command=1, pin=8),
    "LCDOUT": lambda p: lcdout(p, text(b"ab"), command=1, pin=8),
    "OWIN": lambda p: owin(p, [Got()], mode=3, pin=4),
    "OWOUT": lambda p: owout(p, text(b"a"), mode=3, pin=3),
    "PULSIN": lambda p: pulsin(p, state=1, pin=1),
    "PULSOUT": lambda p: pulsout(p, duration=100, pin=2),
    "PWM": lambda p: pwm(p, duty=77, duration=2, pin=2),
    "RCTIME": lambda p: rctime(p, state=0, pin=1),
    "SERIN": lambda p: serin(p, [Got(), Got(6, 3, stores=False)], timeout=1, baud=240, pin=1),
    "SERIN_FLOW": lambda p: serin(
        p, [Got()], timeout=9, timeout_target=5, baud=240, pin=1, flow_pin=3
    ),
    "SEROUT": lambda p: serout(p, text(b"hello", 9), baud=240, pin=2, pace=1),
    "SEROUT_FLOW": lambda p: serout_flow(p, text(b"hi"), baud=240, pin=2, flow_pin=1),
    "SHIFTIN": lambda p: shiftin(p, [Got(8, 0)], mode=0, data_pin=1, clock_pin=2),
    "SHIFTOUT": lambda p: shiftout(p, [Sent(8, 99)], mode=0, data_pin=3, clock_pin=2),
    "XOUT": lambda p: xout(p, [Sent(0x20, 0xFFFD)], pin=2, zero_pin=1),
}


def test_every_instruction_with_a_list_of_its_own_is_here() -> None:
    assert set(RUNS) == set(COMMANDS)


def test_arguments_are_those_of_the_table() -> None:
    """What the table of opcodes calls an operand, the function calls it, too."""
    for model in CHIPS:
        for opcode in opcodes_of(model).values():
            if opcode.name not in COMMANDS:
                continue
            parameters = inspect.signature(COMMANDS[opcode.name]).parameters
            named = {p.name for p in parameters.values() if p.kind is p.KEYWORD_ONLY}
            needed = {
                p.name
                for p in parameters.values()
                if p.kind is p.KEYWORD_ONLY and p.default is p.empty
            }
            for form in opcode.forms:
                assert needed <= set(form) <= named, opcode.name
            has_items = len(parameters) - len(named) == 2
            lists = {"PAIRS", "OUTPUT", "INPUT", "SHIFTED", "VALUES"}
            assert has_items is bool(lists & set(opcode.tail)), opcode.name


def lively_port() -> tuple[Bench, ToyPort]:
    """A bench whose pin 1 is a square wave of 3 ms, and whose other pins are pulled up."""
    bench, port = Bench(), ToyPort("BS2p")
    for wire in port.pins.wires[:16]:
        wire.pull = wire.level = 1
    port.pins.wires[1].pull = None
    bench.play(port.pins.wires[1], [(n * 1500 * US, n & 1) for n in range(400)])
    bench.run(0)
    return bench, port


FETCHED: dict[str, Callable[[ToyPort, int], Command[Result]]] = {
    "DTMFOUT": lambda p, ns: dtmfout(p, text(b"12", ns), pin=2, off_time=1, on_time=3),
    "I2CIN": lambda p, ns: i2cin(
        p, [Got(fetch_ns=ns), Got(fetch_ns=ns)], pin=8, slave=0xA1, address=3
    ),
    "I2COUT": lambda p, ns: i2cout(p, text(b"ab", ns), pin=8, slave=0xA0, address=3),
    "LCDIN": lambda p, ns: lcdin(p, [Got(fetch_ns=ns), Got(fetch_ns=ns)], command=1, pin=8),
    "LCDOUT": lambda p, ns: lcdout(p, text(b"ab", ns), command=1, pin=8),
    "OWIN": lambda p, ns: owin(p, [Got(fetch_ns=ns), Got(fetch_ns=ns)], mode=3, pin=4),
    "OWOUT": lambda p, ns: owout(p, text(b"ab", ns), mode=3, pin=3),
    "SEROUT": lambda p, ns: serout(p, text(b"ab", ns), baud=240, pin=2),
    "SHIFTIN": lambda p, ns: shiftin(
        p, [Got(8, 0, fetch_ns=ns), Got(4, 0, fetch_ns=ns)], mode=0, data_pin=1, clock_pin=2
    ),
    "SHIFTOUT": lambda p, ns: shiftout(
        p, [Sent(8, 99, fetch_ns=ns), Sent(4, 9, fetch_ns=ns)], mode=0, data_pin=3, clock_pin=2
    ),
}


@pytest.mark.parametrize("name", FETCHED)
def test_every_item_takes_the_time_to_fetch_it(name: str) -> None:
    ends = []
    for ns in (0, 123_457):
        port = ToyPort("BS2p")
        for wire in port.pins.wires[:16]:
            wire.pull = wire.level = 1
        ends.append(finished(FETCHED[name](port, ns), port).done_ns)
    assert ends[1] == (ends[0] or 0) + 2 * 123_457


READ_PINS = {
    "COUNT": (1,), "I2CIN": (8, 9), "I2COUT": (8, 9), "OWIN": (4,), "OWOUT": (3,), "PULSIN": (1,),
    "RCTIME": (1,), "SERIN": (1,), "SERIN_FLOW": (1,), "SEROUT_FLOW": (1,), "SHIFTIN": (1,),
    "XOUT": (1,),
}  # fmt: skip
"""Pins that are inputs at some time of those of `RUNS`, all pins having been outputs before."""


@pytest.mark.parametrize("name", READ_PINS)
def test_a_pin_that_is_read_becomes_an_input_and_no_other(name: str) -> None:
    bench, port = Bench(), ToyPort("BS2p")
    let_go = set()

    def heard(pin: int) -> None:
        if not port.pins.directions >> pin & 1:
            let_go.add(pin)

    for pin, wire in enumerate(port.pins.wires[:16]):
        wire.pull = wire.level = 1
        wire.listen(lambda _, pin=pin: heard(pin))  # type: ignore[misc]
    port.pins.set_directions(0xFFFF)
    bench.start(port, RUNS[name](port))
    bench.run(10 * MS)
    assert let_go == {*READ_PINS[name]}


def again(port: ToyPort, start: Start, levels: deque[int], answers: list[int]) -> list[Request]:
    """Repeat an instruction on pins that drive nothing."""
    port.pins.ghost = iter(levels)
    command, requests = start(port), []
    answer: int | None = None
    for following in [*answers, None]:
        try:
            requests.append(command.send(answer))
        except StopIteration:
            break
        answer = following
    return requests


@pytest.mark.parametrize("name", RUNS)
def test_levels_and_answers_are_all_that_it_depends_on(name: str) -> None:
    bench, port = lively_port()
    port.pins.tape = deque()
    command, answers = RUNS[name](port), list[int | None]()

    def watched() -> Command[Result]:
        answer: int | None = None
        while True:
            try:
                request = command.send(answer)
            except StopIteration as end:
                return end.value  # type: ignore[no-any-return]
            answer = yield request
            answers.append(answer)

    task = bench.start(port, watched())
    bench.run(10_000 * MS)
    assert task.done_ns is not None, name
    repeated = ToyPort("BS2p")
    requests = again(repeated, RUNS[name], port.pins.tape, answers)  # type: ignore[arg-type]
    assert requests == task.requests
    assert all(request.ns >= 0 for request in requests if isinstance(request, Delay))
    assert (repeated.pins.latch, repeated.pins.directions) == (
        port.pins.latch,
        port.pins.directions,
    )
    assert repeated.registers.data == port.registers.data
    assert task.result is None or isinstance(task.result, int | Jump)
