"""OWOUT and OWIN: the 1-Wire bus on one pin with a resistor to the supply.

Ref: S2 p. 295 to 308. Least significant bit first.
"""

from cgagen.emulator.commands.levels import LAST_PIN, pull_low, release
from cgagen.emulator.commands.lists import bytes_of, receive
from cgagen.emulator.pins import Pins
from cgagen.emulator.port import Inputs, Items, Port, Result
from cgagen.emulator.requests import Command, Delay
from cgagen.emulator.timing import ONE_WIRE, ONE_WIRE_FAST, ONE_WIRE_READ_LOW_NS, OneWireTiming
from cgagen.errors import ExecutionError

RESET_BEFORE = 1
RESET_AFTER = 2
BIT_MODE = 4
HIGH_SPEED = 8
"""The mode's bits. Ref: S2 p. 297, 305."""


def owout(port: Port, items: Items, *, mode: int, pin: int) -> Command[Result]:
    """Send a list, with resets as the mode says; in bit mode the lowest bit of each byte."""
    bus = _Wire(port, mode, pin)
    yield from bus.reset_if(mode & RESET_BEFORE)
    for item in items:
        yield Delay(item.fetch_ns)
        for byte in bytes_of(port, item.values()):
            yield from bus.write(byte)
    yield from bus.reset_if(mode & RESET_AFTER)
    return None


def owin(port: Port, items: Inputs, *, mode: int, pin: int) -> Command[Result]:
    """Receive a list; in bit mode every byte of it is one bit."""
    bus = _Wire(port, mode, pin)
    yield from bus.reset_if(mode & RESET_BEFORE)
    yield from receive(port, items, bus)
    yield from bus.reset_if(mode & RESET_AFTER)
    return None


class _Wire:
    """The bus of one instruction."""

    __slots__ = ("_bits", "_pin", "_pins", "_read_low_ns", "_timing")

    def __init__(self, port: Port, mode: int, pin: int) -> None:
        if mode & HIGH_SPEED and port.model.name == "BS2pe":
            raise ExecutionError(
                "a BS2pe has no high speed on the 1-Wire bus; take 8 off the mode of OWIN or OWOUT"
            )
        self._pins: Pins = port.pins
        self._pin = pin & LAST_PIN
        self._timing: OneWireTiming = ONE_WIRE_FAST if mode & HIGH_SPEED else ONE_WIRE
        self._read_low_ns = (
            ONE_WIRE_FAST.short_low_ns if mode & HIGH_SPEED else ONE_WIRE_READ_LOW_NS
        )
        self._bits = 1 if mode & BIT_MODE else 8
        release(self._pins, self._pin)

    def reset_if(self, wanted: int) -> Command[None]:
        """Give a reset pulse and let parts answer it; nobody's answer is needed (choice)."""
        if wanted:
            timing = self._timing
            yield from self._low(timing.reset_low_ns)
            yield Delay(timing.presence_ns + timing.reset_rest_ns)

    def write(self, byte: int) -> Command[None]:
        """Send a byte, or the bit."""
        timing = self._timing
        for place in range(self._bits):
            low_ns = timing.short_low_ns if byte >> place & 1 else timing.slot_ns
            yield from self._low(low_ns)
            yield Delay(timing.slot_ns - low_ns + timing.recovery_ns)

    def byte(self) -> Command[int]:
        """Receive a byte, or a bit."""
        timing, byte = self._timing, 0
        for place in range(self._bits):
            yield from self._low(self._read_low_ns)
            yield Delay(timing.sample_ns - self._read_low_ns)
            byte |= self._pins.level(self._pin) << place
            yield Delay(timing.slot_ns - timing.sample_ns + timing.recovery_ns)
        return byte

    def busy(self, ns: int) -> Command[None]:
        """Fetch an item."""
        yield Delay(ns)

    def _low(self, ns: int) -> Command[None]:
        pull_low(self._pins, self._pin, True)
        yield Delay(ns)
        release(self._pins, self._pin)
