"""LCDCMD, LCDIN and LCDOUT against a display made here from its data sheet's rules."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cgagen.emulator.commands.lcd import lcdcmd, lcdin, lcdout
from cgagen.emulator.timing import LCD
from tests.command_bench import Got, Sent, ToyPort, finished, text


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
            assert self._rs.level == 1  # its memory is read, not the busy flag
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


def test_every_byte_takes_two_halves_and_the_time_it_is_worked_on() -> None:
    byte_ns = 2 * (2 * LCD.setup_ns + LCD.enable_ns) + LCD.busy_ns
    for command, count in ((lcdout, 4), (lcdin, 3)):
        port = ToyPort("BS2p")
        Lcd(port, 0, b"ab")
        items = text(b"abc") if command is lcdout else [Got(), Got()]
        task = finished(command(port, items, command=1, pin=0), port)  # type: ignore[operator]
        assert task.done_ns == count * byte_ns
