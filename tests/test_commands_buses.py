"""I2C, 1-Wire, LCD and X-10: against parts written here from the buses' own rules."""

import pytest
from command_bench import MS, US, Bench, Got, Sent, Task, ToyPort, finished, text
from hypothesis import given
from hypothesis import strategies as st

from cgagen.emulator.clock import Clock
from cgagen.emulator.commands.i2c import i2cin, i2cout
from cgagen.emulator.commands.lcd import lcdcmd, lcdin, lcdout
from cgagen.emulator.commands.onewire import owin, owout
from cgagen.emulator.commands.xout import frame, xout
from cgagen.emulator.wires import Wire
from cgagen.errors import ExecutionError


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


@given(st.binary(min_size=1, max_size=6), st.integers(0, 255))
def test_what_i2cout_writes_i2cin_reads(data: bytes, address: int) -> None:
    bench, port, _ = i2c_bench()
    bench.start(port, i2cout(port, text(data), pin=0, slave=0xA0, address=address))
    bench.run()
    items = [Got() for _ in data]
    bench.start(port, i2cin(port, items, pin=0, slave=0xA1, address=address))
    bench.run()
    assert bytes(item.taken[0] for item in items) == data


# -- 1-Wire ---------------------------------------------------------------------------------------


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


# -- LCD ------------------------------------------------------------------------------------------


class Lcd:
    """A display in 4-bit mode: it logs (RS, byte), and answers reads from `answer`."""

    def __init__(self, port: ToyPort, enable: int, answer: bytes = b"") -> None:
        group = enable & 8
        wires = port.pins.wires
        self._read, self._rs = wires[group + 2], wires[group + 3]
        self._data = wires[group + 4 : group + 8]
        self._halves: list[int] = []
        self._answer = [half for byte in answer for half in (byte >> 4, byte & 15)]
        self.log: list[tuple[int, int]] = []
        wires[enable].listen(self._enable)

    def _enable(self, level: int | None) -> None:
        if self._read.level:
            half = self._answer[0] if level and self._answer else None
            for bit, wire in enumerate(self._data):
                wire.drive("lcd", None if half is None else half >> bit & 1)
            if level and self._answer:
                del self._answer[0]
        elif level == 0:
            self._halves.append(sum((wire.level or 0) << n for n, wire in enumerate(self._data)))
            if len(self._halves) == 2:
                self.log.append((self._rs.level or 0, self._halves[0] << 4 | self._halves[1]))
                self._halves = []


@pytest.mark.parametrize("pin", [0, 1, 8, 9])
def test_lcdcmd_and_lcdout(pin: int) -> None:
    """S2 p. 249, 263: E on the pin, R/W, RS and DB4 to DB7 on the group's other pins."""
    port = ToyPort("BS2p")
    port.pins.set_latch(0xFFFF)
    port.pins.set_directions(1 << pin | 1 << ((pin & 8) + 2))
    port.pins.set_latch(0)
    lcd = Lcd(port, pin)
    finished(lcdcmd(port, command=24, pin=pin), port)
    finished(lcdout(port, [*text(b"Hi"), Sent(0x01C0, 0xA5)], command=1, pin=pin), port)
    assert lcd.log == [(0, 24), (0, 1), *[(1, byte) for byte in b"HiA5"]]
    others = 0b11111100 << (pin & 8)
    assert port.pins.directions == others | 1 << pin


@given(st.binary(min_size=1, max_size=4))
def test_lcdin(data: bytes) -> None:
    """S2 p. 257: the command first; the data pins end as inputs, and nobody fights for them."""
    port = ToyPort("BS2p")
    port.pins.set_directions(0b101)
    lcd = Lcd(port, 0, data)
    items = [Got() for _ in data]
    finished(lcdin(port, items, command=128, pin=0), port)
    assert lcd.log == [(0, 128)]
    assert bytes(item.taken[0] for item in items) == data
    assert port.pins.directions == 0b1101
    assert not port.pins.latch & 0b101
    finished(lcdout(port, [Sent(65)], command=0, pin=0), port)
    assert lcd.log[1:] == [(0, 0), (1, 65)]


# -- X-10 -----------------------------------------------------------------------------------------


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


def test_xout_without_mains_waits_for_ever() -> None:
    """S2 p. 465."""
    bench, port = Bench(), ToyPort()
    task = bench.start(port, xout(port, [Sent(0, 0xFFFD)], pin=0, zero_pin=1))
    bench.run(10**15)
    assert task.done_ns is None
