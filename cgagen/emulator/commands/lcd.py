"""LCDCMD, LCDOUT and LCDIN: a display with an HD44780 on a bus of four bits.

Ref: S2 p. 249 to 266. The high half of a byte goes first. The display's busy flag is not read
(choice): the manual has programs wait after the slow commands.
"""

from typing import NamedTuple

from cgagen.emulator.commands.levels import drive
from cgagen.emulator.commands.lists import bytes_of, receive
from cgagen.emulator.pins import Pins
from cgagen.emulator.port import Inputs, Items, Port, Result
from cgagen.emulator.requests import Command, Delay
from cgagen.emulator.timing import LCD


class LcdPins(NamedTuple):
    """Pins 0 to 7 or 8 to 15: E on 0 or 1, R/W on 2, RS on 3, DB4 to DB7 on 4 to 7."""

    enable: int
    read: int
    data_register: int
    first_data: int


def lcd_pins(pin: int) -> LcdPins:
    """Return the pins that go with E. Ref: S2 p. 249.

    Other pins than 0, 1, 8 and 9 mean one of them by bits 0 and 3 (choice).

    >>> lcd_pins(9)
    LcdPins(enable=9, read=10, data_register=11, first_data=12)
    """
    group = pin & 8
    return LcdPins(pin & 9, group + 2, group + 3, group + 4)


def lcdcmd(port: Port, *, command: int, pin: int) -> Command[Result]:
    """Send a command."""
    yield from _Display(port, pin).write(command, data=0)
    return None


def lcdout(port: Port, items: Items, *, command: int, pin: int) -> Command[Result]:
    """Send a command, then data. Command 0 is sent like any other; displays ignore it."""
    display = _Display(port, pin)
    yield from display.write(command, data=0)
    for item in items:
        yield Delay(item.fetch_ns)
        for byte in bytes_of(port, item.values()):
            yield from display.write(byte, data=1)
    return None


def lcdin(port: Port, items: Inputs, *, command: int, pin: int) -> Command[Result]:
    """Send a command, then read data; the data pins end as inputs. Ref: S2 p. 257."""
    display = _Display(port, pin)
    yield from display.write(command, data=0)
    display.turn()
    yield from receive(port, items, display)
    display.turn_back()
    return None


class _Display:
    """The bus of one instruction; all seven pins begin as outputs, E low."""

    __slots__ = ("_lines", "_pins")

    def __init__(self, port: Port, pin: int) -> None:
        self._pins: Pins = port.pins
        self._lines = lcd_pins(pin)
        for line in (self._lines.enable, self._lines.read):
            drive(self._pins, line, 0)

    def write(self, byte: int, data: int) -> Command[None]:
        """Send a byte to the command register, or the data register."""
        drive(self._pins, self._lines.data_register, data)
        for half in (byte >> 4 & 15, byte & 15):
            self._set_data(half)
            yield Delay(LCD.setup_ns)
            drive(self._pins, self._lines.enable, 1)
            yield Delay(LCD.enable_ns)
            drive(self._pins, self._lines.enable, 0)
            yield Delay(LCD.setup_ns)
        yield Delay(LCD.busy_ns)

    def turn(self) -> None:
        """Let the display drive the data lines: ours first let go."""
        self._pins.set_directions(self._pins.directions & ~(15 << self._lines.first_data))
        drive(self._pins, self._lines.data_register, 1)
        drive(self._pins, self._lines.read, 1)

    def turn_back(self) -> None:
        """Take R/W back, so that nobody drives the data lines."""
        drive(self._pins, self._lines.read, 0)

    def byte(self) -> Command[int]:
        """Read a byte of data, each half at the end of E."""
        byte = 0
        for place in (4, 0):
            yield Delay(LCD.setup_ns)
            drive(self._pins, self._lines.enable, 1)
            yield Delay(LCD.enable_ns)
            for bit in range(4):
                level = self._pins.level(self._lines.first_data + bit)
                byte |= level << place + bit
            drive(self._pins, self._lines.enable, 0)
            yield Delay(LCD.setup_ns)
        yield Delay(LCD.busy_ns)
        return byte

    def busy(self, ns: int) -> Command[None]:
        """Fetch an item."""
        yield Delay(ns)

    def _set_data(self, half: int) -> None:
        """Put four bits on the bus at once."""
        pins, first = self._pins, self._lines.first_data
        pins.set_latch(pins.latch & ~(15 << first) | half << first)
        pins.set_directions(pins.directions | 15 << first)
