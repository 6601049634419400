"""XOUT against the codes of X-10."""

import pytest

from cgagen.emulator.commands.xout import frame, xout
from tests.command_bench import MS, US, Bench, Sent, ToyPort


def code(house: int, key: int) -> int:
    """Return what the tokenizer makes of house and key (S3)."""
    return house % 16 + key * 16


def complement(bits: str) -> str:
    return "".join(bit + ("0" if bit == "1" else "1") for bit in bits)


@pytest.mark.parametrize(
    ("key", "bits"),
    [
        # X-10's table of functions, by the values of S2 p. 467
        (0b10010, "00101"),  # UNITON: On
        (0b11010, "00111"),  # UNITOFF: Off
        (0b11100, "00001"),  # UNITSOFF: All Units Off
        (0b10100, "00011"),  # LIGHTSON: All Lights On
        (0b11110, "01001"),  # DIM
        (0b10110, "01011"),  # BRIGHT
        (0, "01100"),  # unit 1
        (1, "11100"),  # unit 2
        (15, "11000"),  # unit 16
    ],
)
def test_codes_of_x10(key: int, bits: str) -> None:
    sent = "".join(map(str, frame(code(2, key))))
    assert sent == "1110" + complement("0010") + complement(bits)


def test_xout_is_in_step_with_the_mains() -> None:
    """S2 p. 465: [house\\key\\2, house\\command]; a burst of 1 ms at each crossing that has a 1."""
    bench, port = Bench(), ToyPort()
    half = 8_333 * US
    zero, out = port.pins.wires[1], bench.trace(port.pins.wires[0])
    bench.play(zero, [(index * half, index & 1) for index in range(400)])
    items = [Sent(code(0, 0), ~2 & 0xFFFF), Sent(code(0, 0b10010), ~2 & 0xFFFF)]
    task = bench.start(port, xout(port, items, pin=0, zero_pin=1))
    bench.run(400 * half)
    assert task.done_ns is not None
    gap = (0,) * 6
    expected = [*frame(code(0, 0)) * 2, *gap, *frame(code(0, 0b10010)) * 2, *gap]
    assert task.done_ns == len(expected) * half
    for index, bit in enumerate(expected, start=1):
        for third in range(3):
            begin = index * half + third * 2_778 * US
            assert out.at(begin + MS // 2) == bit
            assert out.at(begin + 3 * MS // 2) == 0
    assert port.pins.directions == 1


def test_xout_begins_low_and_looks_for_crossings_when_it_has_its_command() -> None:
    """A crossing meanwhile is a change all the same, so the first bit goes out at once."""
    bench, port = Bench(), ToyPort()
    line = port.pins.wires[0]
    line.pull = line.level = 1
    out = bench.trace(line)
    bench.play(port.pins.wires[1], [(0, 0), (3 * MS, 1)])
    command = xout(port, [Sent(code(0, 0), ~1 & 0xFFFF, fetch_ns=5 * MS)], pin=0, zero_pin=1)
    bench.start(port, command)
    bench.run(100 * MS)
    assert out.changes[:3] == [(0, 0), (5 * MS, 1), (6 * MS, 0)]


def test_xout_without_mains_waits_for_ever() -> None:
    """S2 p. 465."""
    bench, port = Bench(), ToyPort()
    task = bench.start(port, xout(port, [Sent(0, 0xFFFD)], pin=0, zero_pin=1))
    bench.run(10**15)
    assert task.done_ns is None
