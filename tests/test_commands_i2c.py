"""I2CIN and I2COUT against an EEPROM made here from the rules of the bus."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cgagen.emulator.commands.i2c import i2cin, i2cout
from cgagen.emulator.wires import Wire
from tests.command_bench import Bench, Got, Sent, ToyPort, finished, text


class Eeprom:
    """An I2C memory with one or two address bytes; it logs what a bus analyser would show."""

    def __init__(self, sda: Wire, scl: Wire, *, slave: int = 0xA0, address_bytes: int = 1) -> None:
        self.memory = bytearray(range(256))
        self.log: list[str | int] = []
        self.deaf = 0
        self._sda, self._scl = sda, scl
        self._slave, self._address_bytes = slave, address_bytes
        self._bits: list[int] = []
        self._bytes = 0
        self._selected = self._reading = False
        self._out = 0
        self._address = 0
        self._last_sda = 1
        sda.pull = sda.level = scl.pull = scl.level = 1
        sda.listen(self._data)
        scl.listen(self._clock)

    def _data(self, level: int | None) -> None:
        if self._scl.level and level != self._last_sda:
            self.log.append("P" if level else "S")
            self._bits, self._bytes, self._reading, self._selected = [], 0, False, False
        self._last_sda = level or 0

    def _clock(self, level: int | None) -> None:
        if level:
            self._rise()
        else:
            self._fall()

    def _rise(self) -> None:
        self._bits.append(self._sda.level or 0)
        if len(self._bits) < 9:
            return
        byte = int("".join(map(str, self._bits[:8])), 2)
        self.log.append(byte)
        self.log.append("n" if self._bits[8] else "a")
        if self._reading and self._bytes and self._bits[8]:
            self._selected = False

    def _fall(self) -> None:
        self._sda.drive("slave", None)
        if len(self._bits) == 9:
            self._take(int("".join(map(str, self._bits[:8])), 2))
            self._bits = []
            self._bytes += 1
        if not self._selected and self._bytes:
            return
        if self._reading:
            if len(self._bits) < 8 and not self.memory[self._address] << len(self._bits) & 0x80:
                self._sda.drive("slave", 0)
        elif len(self._bits) == 8:
            byte = int("".join(map(str, self._bits)), 2)
            called = self._bytes or (byte & 0xFE == self._slave and not self.deaf)
            if called:
                self._sda.drive("slave", 0)

    def _take(self, byte: int) -> None:
        if self._bytes == 0:
            self._selected = byte & 0xFE == self._slave and not self.deaf
            self.deaf = max(0, self.deaf - 1)
            self._reading = self._selected and bool(byte & 1)
        elif self._reading:
            self._address = (self._address + 1) % 256
        elif self._bytes <= self._address_bytes:
            self._address = byte
        else:
            self.memory[self._address] = byte
            self._address = (self._address + 1) % 256


def i2c_bench(pin: int = 0, **memory: int) -> tuple[Bench, ToyPort, Eeprom]:
    port = ToyPort("BS2p")
    return Bench(), port, Eeprom(port.pins.wires[pin], port.pins.wires[pin + 1], **memory)


@pytest.mark.parametrize("pin", [0, 8])
def test_i2cout_of_the_manual(pin: int) -> None:
    """S2 p. 226: I2COUT 0, $A0, 5, [100] writes 100 to location 5 of a 24LC16."""
    bench, port, memory = i2c_bench(pin)
    task = bench.start(port, i2cout(port, [Sent(100)], pin=pin, slave=0xA0, address=5))
    bench.run()
    assert memory.log == ["S", 0xA0, "a", 5, "a", 100, "a", "P"]
    assert memory.memory[5] == 100
    assert task.done_ns is not None
    assert port.pins.directions == 0


def test_i2cin_of_the_manual() -> None:
    """S2 p. 218: I2CIN 0, $A1, 0, [result]: first the address is written, then the byte read."""
    bench, port, memory = i2c_bench()
    memory.memory[7:9] = b"\xc3\x55"
    items = [Got(), Got()]
    bench.start(port, i2cin(port, items, pin=0, slave=0xA1, address=7))
    bench.run()
    assert memory.log == [
        "S", 0xA0, "a", 7, "a", "S", 0xA1, "a", 0xC3, "a", 0x55, "n", "P",
    ]  # fmt: skip
    assert [item.taken for item in items] == [[0xC3], [0x55]]
    assert port.pins.directions == 0


def test_long_addresses_go_high_byte_first() -> None:
    """S2 p. 228: address 2050 is 8 and 2."""
    bench, port, memory = i2c_bench(address_bytes=2)
    command = i2cout(port, text(b"hi"), pin=0, slave=0xA0, address=8, low_address=2)
    bench.start(port, command)
    bench.run()
    assert memory.log[:8] == ["S", 0xA0, "a", 8, "a", 2, "a", ord("h")]
    assert bytes(memory.memory[2:4]) == b"hi"


def test_without_an_address_the_slave_stands_in_its_place() -> None:
    """S3: a form without address pushes the slave where the address belongs, and a slave of 0."""
    bench, port, memory = i2c_bench()
    bench.start(port, i2cout(port, [Sent(9)], pin=0, slave=0, address=0xA0))
    bench.run()
    assert memory.log == ["S", 0xA0, "a", 9, "a", "P"]
    item = Got()
    bench.start(port, i2cin(port, [item], pin=0, slave=0, address=0xA1))
    bench.run()
    assert memory.log[6:] == ["S", 0xA1, "a", 9, "n", "P"]
    assert item.taken == [9]


def test_a_slave_is_called_up_to_eight_times() -> None:
    """S2 p. 218."""
    bench, port, memory = i2c_bench()
    memory.deaf = 3
    bench.start(port, i2cout(port, [Sent(1)], pin=0, slave=0xA0, address=2))
    bench.run()
    assert memory.log == [*["S", 0xA0, "n"] * 3, "S", 0xA0, "a", 2, "a", 1, "a", "P"]
    bench, port, memory = i2c_bench(slave=0x40)
    item = Got()
    bench.start(port, i2cin(port, [item], pin=0, slave=0xA1, address=2))
    bench.run()
    assert memory.log.count(0xA0) == memory.log.count(0xA1) == 8
    assert item.taken == [255]


@pytest.mark.parametrize(("model", "rate"), [("BS2p", 81_000), ("BS2pe", 45_000)])
def test_i2c_bit_rate(model: str, rate: int) -> None:
    """S2 p. 218."""
    port = ToyPort(model)
    Eeprom(port.pins.wires[0], port.pins.wires[1])
    short = finished(i2cout(port, text(b"a"), pin=0, slave=0xA0, address=0), port)
    port = ToyPort(model)
    Eeprom(port.pins.wires[0], port.pins.wires[1])
    long = finished(i2cout(port, text(b"a" * 101), pin=0, slave=0xA0, address=0), port)
    assert short.done_ns is not None
    assert long.done_ns is not None
    assert abs(900 * 1e9 / (long.done_ns - short.done_ns) / rate - 1) < 0.001


def test_every_part_of_a_conversation_takes_whole_bits() -> None:
    """Nobody answers: 8 starts with 9 bits each, then 9 a byte (address, data), and the stop."""
    port = ToyPort("BS2p")
    for wire in port.pins.wires[:2]:
        wire.pull = wire.level = 1
    task = finished(i2cout(port, text(b"a"), pin=0, slave=0xA0, address=3), port)
    assert task.done_ns == (8 * (1 + 9) + 2 * 9 + 1) * port.timing.i2c_bit_ns
    # reading: called for its address, called again, 9 bits with their last answer, and the stop
    task = finished(i2cin(port, [Got()], pin=0, slave=0xA1, address=3), port)
    assert task.done_ns == (2 * 8 * (1 + 9) + 2 * 9 + 1) * port.timing.i2c_bit_ns


@given(st.binary(min_size=1, max_size=6), st.integers(0, 255))
def test_what_i2cout_writes_i2cin_reads(data: bytes, address: int) -> None:
    bench, port, _ = i2c_bench()
    bench.start(port, i2cout(port, text(data), pin=0, slave=0xA0, address=address))
    bench.run()
    items = [Got() for _ in data]
    bench.start(port, i2cin(port, items, pin=0, slave=0xA1, address=address))
    bench.run()
    assert bytes(item.taken[0] for item in items) == data
