"""A computer's side of the loader's dialogue, on the bench's own time."""

from collections.abc import Sequence

from cgagen.emulator.bench import Bench
from cgagen.emulator.host_port import HostPort
from cgagen.emulator.programs import bench_of_image
from cgagen.stamp.chips import EEPROM_BYTES, chip
from cgagen.stamp.image import Image

MS = 1_000_000
ANSWERS = {"BS2": b"BS2\0", "BS2e": b"e", "BS2sx": b"X", "BS2p": b"P", "BS2pe": b"I"}
HELLO = '\' {$STAMP %s}\nDEBUG "hello", CR\nEND\n'


def blank(model: str) -> Bench:
    return bench_of_image(Image(chip(model), bytes(EEPROM_BYTES)))


def enter(port: HostPort, hold_s: float = 0.005, after_s: float = 0.04) -> None:
    """Reset with BREAK, and forget what that brought back."""
    port.break_condition = True
    port.dtr = True
    port.sleep(hold_s)
    port.dtr = False
    port.sleep(after_s)
    port.break_condition = False
    port.sleep(0.02)
    port.reset_input_buffer()


def ask(port: HostPort, data: bytes, answers: int = 1) -> bytes:
    """Send, take the echo off, return what else came."""
    port.write(data)
    found = port.read(len(data) + answers)
    assert found[: len(data)] == data, found
    return found[len(data) :]


def identify(port: HostPort) -> bytes:
    model = port.chip.machine.model.name
    return b"".join(ask(port, bytes([byte])) for byte in ANSWERS[model])


def download(port: HostPort, packets: Sequence[bytes], slot: int = 0) -> None:
    enter(port)
    identify(port)
    if port.chip.machine.model.slots > 1:
        assert ask(port, bytes([slot]), 0) == b""
    for one in packets:
        assert ask(port, one) == b"\0"


def output(port: HostPort, seconds: float = 0.5) -> bytes:
    port.sleep(seconds)
    return port.read(port.in_waiting)
