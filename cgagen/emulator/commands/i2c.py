"""I2CIN and I2COUT: the chip as the only master of an I2C bus.

Ref: S2 p. 217 to 232. SDA and SCL are pulled up by resistors and never driven high. A slave that
holds SCL low is not waited for (choice). Data come and go most significant bit first.
"""

from cgagen.emulator.commands.levels import pull_low, release
from cgagen.emulator.commands.lists import bytes_of, receive
from cgagen.emulator.pins import Pins
from cgagen.emulator.port import Inputs, Items, Port, Result
from cgagen.emulator.requests import Command, Delay

ATTEMPTS = 8
"""How often a slave that does not answer is called. Ref: S2 p. 218."""

READ = 1
_SECOND_BUS = 8
"""The bus is on pins 0 and 1, or on 8 and 9. Ref: S2 p. 218; other pins mean one of them by this
bit (choice)."""


def i2cout(
    port: Port, items: Items, *, pin: int, slave: int, address: int, low_address: int | None = None
) -> Command[Result]:
    """Call the slave to write, send its address and then the list.

    The lowest bit of the slave's identifier is set as the direction wants it (choice). A byte that
    is not acknowledged is followed by the next (choice).
    """
    bus = _Bus(port, pin)
    slave, inner = _called(slave, address, low_address)
    yield from bus.call(slave & ~READ)
    for byte in inner:
        yield from bus.write(byte)
    for item in items:
        yield Delay(item.fetch_ns)
        for byte in bytes_of(port, item.values()):
            yield from bus.write(byte)
    yield from bus.stop()
    return None


def i2cin(
    port: Port, items: Inputs, *, pin: int, slave: int, address: int, low_address: int | None = None
) -> Command[Result]:
    """Tell the slave its address, call it again to read, and read the list.

    A slave that is not there reads as 255, as the resistors have it.
    """
    bus = _Bus(port, pin)
    slave, inner = _called(slave, address, low_address)
    if inner:
        yield from bus.call(slave & ~READ)
        for byte in inner:
            yield from bus.write(byte)
    yield from bus.call(slave | READ)
    yield from receive(port, items, bus)
    yield from bus.end_reading()
    yield from bus.stop()
    return None


def _called(slave: int, address: int, low_address: int | None) -> tuple[int, list[int]]:
    """Return slave and address bytes: without an address the slave stands in its place. Ref: S3."""
    if low_address is not None:
        return slave & 0xFF, [address & 0xFF, low_address & 0xFF]
    if slave:
        return slave & 0xFF, [address & 0xFF]
    return address & 0xFF, []


class _Bus:
    """Both wires; between two calls of a method SCL is low, or the bus is idle."""

    __slots__ = ("_half_ns", "_pins", "_quarter_ns", "_reading", "_scl", "_sda")

    def __init__(self, port: Port, pin: int) -> None:
        self._pins: Pins = port.pins
        self._sda = pin & _SECOND_BUS
        self._scl = self._sda + 1
        self._quarter_ns = port.timing.i2c_bit_ns // 4
        self._half_ns = port.timing.i2c_bit_ns - 2 * self._quarter_ns
        self._reading = False
        release(self._pins, self._sda)
        release(self._pins, self._scl)

    def call(self, slave: int) -> Command[None]:
        """Start, or start again, and call until the slave answers; go on where it does not."""
        for _ in range(ATTEMPTS):
            yield from self._start()
            if (yield from self.write(slave)):
                return

    def write(self, byte: int) -> Command[bool]:
        """Send a byte; whether it was acknowledged."""
        for place in range(7, -1, -1):
            yield from self._clock(byte >> place & 1)
        return (yield from self._clock(1)) == 0

    def byte(self) -> Command[int]:
        """Read a byte; it is acknowledged only when the next is wanted, as it may be the last."""
        if self._reading:
            yield from self._clock(0)
        self._reading = True
        byte = 0
        for _ in range(8):
            byte = byte << 1 | (yield from self._clock(1))
        return byte

    def busy(self, ns: int) -> Command[None]:
        """Fetch an item."""
        yield Delay(ns)

    def end_reading(self) -> Command[None]:
        """Answer the last byte with no acknowledgement, which ends the slave's sending."""
        if self._reading:
            yield from self._clock(1)

    def stop(self) -> Command[None]:
        """Let SDA rise while SCL is high; both pins end as inputs."""
        pull_low(self._pins, self._sda, True)
        yield Delay(self._quarter_ns)
        release(self._pins, self._scl)
        yield Delay(self._half_ns)
        release(self._pins, self._sda)
        yield Delay(self._quarter_ns)

    def _start(self) -> Command[None]:
        """Let SDA fall while SCL is high."""
        release(self._pins, self._sda)
        yield Delay(self._quarter_ns)
        release(self._pins, self._scl)
        yield Delay(self._half_ns)
        pull_low(self._pins, self._sda, True)
        yield Delay(self._quarter_ns)
        pull_low(self._pins, self._scl, True)

    def _clock(self, bit: int) -> Command[int]:
        """Send a bit and read the line: a 1 is how the other side's bit is read."""
        pull_low(self._pins, self._sda, not bit)
        yield Delay(self._quarter_ns)
        release(self._pins, self._scl)
        yield Delay(self._half_ns)
        level = self._pins.level(self._sda)
        pull_low(self._pins, self._scl, True)
        yield Delay(self._quarter_ns)
        return level
