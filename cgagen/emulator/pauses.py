"""The instructions that let time go by: PAUSE, NAP, SLEEP, END, POLLWAIT, and WRITE's burning.

In a low-power state the watchdog wakes the chip every now and then; each time all pins are
inputs for a moment, and DIRS comes back. Ref: S2 p. 187, 286, 441.
"""

from cgagen.emulator.commands import CommandFunction
from cgagen.emulator.machine import Machine
from cgagen.emulator.port import Result
from cgagen.emulator.requests import Command, Delay

_NO_POWER_DOWN = 8


def pause(machine: Machine, *, period: int) -> Command[Result]:
    """Wait for some milliseconds."""
    yield Delay(period * machine.timing.pause_ns)
    return None


def nap(machine: Machine, *, period: int) -> Command[Result]:
    """Sleep for 18 ms times a power of two; the low three bits count (choice)."""
    yield Delay(machine.timing.nap_ns << (period & 7))
    yield from _wake(machine)
    return None


def sleep(machine: Machine, *, seconds: int) -> Command[Result]:
    """Sleep for some seconds, rounded up to periods of 2.304 s. 0 is one period (choice)."""
    period_ns = machine.timing.slow_clock_ns
    for _ in range(max(1, -(-seconds * 1_000_000_000 // period_ns))):
        yield Delay(period_ns - machine.timing.glitch_ns)
        yield from _wake(machine)
    return None


def end(machine: Machine) -> Command[Result]:
    """Sleep for ever. With no output there is nothing to see of it."""
    while any(pins.directions for pins in machine.groups):
        yield Delay(machine.timing.slow_clock_ns - machine.timing.glitch_ns)
        yield from _wake(machine)
    return None


def pollwait(machine: Machine, *, period: int) -> Command[Result]:
    """Sleep until a polled input has its level; 8 and more (choice) stay awake.

    Without a polled input, or in another mode than 2 or 4, nothing happens. Ref: S2 p. 335.
    """
    polling, timing = machine.polling, machine.timing
    if not polling.waits:
        return None
    while True:
        if period >= _NO_POWER_DOWN:
            yield Delay(timing.pollwait_ns)
        else:
            yield Delay(timing.nap_ns << period)
            yield from _wake(machine)
        if polling.hits(machine.groups):
            return None


def write(machine: Machine, *, value: int, location: int) -> Command[Result]:
    """Burn a byte of the slot that STORE chose; it is there when the time is over (choice)."""
    yield Delay(machine.timing.write_ns)
    machine.memory.write(machine.store_slot, location, value)
    return None


PAUSES: dict[str, CommandFunction] = {
    "PAUSE": pause,
    "NAP": nap,
    "SLEEP": sleep,
    "END": end,
    "POLLWAIT": pollwait,
    "WRITE": write,
}


def _wake(machine: Machine) -> Command[None]:
    before = [pins.directions for pins in machine.groups]
    for pins in machine.groups:
        pins.set_directions(0)
    yield Delay(machine.timing.glitch_ns)
    for pins, directions in zip(machine.groups, before, strict=True):
        pins.set_directions(directions)
