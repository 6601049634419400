"""The fake Stamp of these tests and the emulator's loader, written apart from the documents.

Where they part, one of them is wrong, or the documents say nothing: then no rule hangs on it.
"""

from collections.abc import Callable

import pytest

from cgagen.emulator.host_port import HostPort
from cgagen.emulator.loader import Phase
from cgagen.emulator.programs import bench_of_image
from cgagen.flash.line import Line
from cgagen.flash.plan import plan_of
from cgagen.flash.programmer import program
from cgagen.flash.requests import Enter, Say
from cgagen.stamp.chips import chip
from cgagen.stamp.image import SENT, Image, Use
from tests.fake_stamp import MODELS, FakeChip, FakePort, SimClock

GOOD = plan_of(Image(chip("BS2"), bytes(range(256)) * 8)).packets[126]
BAD = GOOD[:-1] + bytes((GOOD[-1] ^ 1,))

OLDEST = {"BS2": 0x10, "BS2e": 0x65, "BS2sx": 0x58, "BS2p24": 0x70, "BS2p40": 0x50, "BS2pe24": 0x69}
"""What version 1.0 answers."""

SCRIPTS: dict[str, list[bytes]] = {
    "bytes that are nobody's": [b"\xff", b"?", b"U"],
    "other models' bytes": [b"e", b"X", b"T", b"I"],
    "a broken packet, then a good one": [b"\0", BAD, GOOD],
    "the same packet twice": [b"\0", GOOD, GOOD],
    "an end without a packet": [b"\0", b"\0", b"\0"],
    "half a packet and its rest": [b"\0", GOOD[:5], GOOD[5:]],
    "slot 7": [b"\7", GOOD],
}


def spoken(port: FakePort | HostPort, script: list[bytes]) -> list[bytes]:
    """What comes back to each piece."""
    line = Line(port, port if isinstance(port, HostPort) else port.clock)
    line.perform(Enter())
    return [line.perform(Say(piece, 2, 200)).after for piece in script]


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("greeted", [False, True])
@pytest.mark.parametrize("script", SCRIPTS)
def test_they_answer_alike(name: str, greeted: bool, script: str) -> None:
    steps, challenge, answer, _ = MODELS[name]
    blank = Image(chip(name.removesuffix("24").removesuffix("40")), bytes(2048))
    emulated = HostPort(
        bench_of_image(blank),
        timeout=0.05,
        legs=40 if name.endswith("40") else 24,
        version=answer - OLDEST[name],
    )
    words = [bytes((byte,)) for byte, _ in steps] + [bytes((challenge,))] if greeted else []
    fake = FakePort(FakeChip(name), SimClock())
    assert spoken(emulated, words + SCRIPTS[script]) == spoken(fake, words + SCRIPTS[script])


class Spoiled(HostPort):
    """The emulated chip's port with one byte on its way to the chip spoiled."""

    position = -1
    change = staticmethod(lambda byte: b"")
    said = 0

    def write(self, data: bytes) -> int:
        for byte in data:
            piece = self.change(byte) if self.said == self.position else bytes((byte,))
            self.said += 1
            super().write(piece)
        return len(data)


@pytest.mark.parametrize(
    "change", [lambda byte: b"", lambda byte: bytes((byte, byte)), lambda byte: bytes((byte ^ 4,))]
)
def test_the_emulated_chip_with_a_byte_spoiled(change: Callable[[int], bytes]) -> None:
    """Every byte that is said, lost, doubled and flipped: mended by trying again."""
    flags = bytes((Use.DATA | SENT,)) * 16 + bytes(2016) + bytes((Use.PROGRAM | SENT,)) * 16
    image = Image(chip("BS2p"), b"sixteen bytes, 0" + bytes(2032), flags)
    plan = plan_of(image)
    for position in range(2 + 2 * 18 + 1):
        port = Spoiled(bench_of_image(Image(chip("BS2p"), bytes(2048))), timeout=0.01)
        port.position, port.change = position, change
        report = program(Line(port, port), "emulated", plan)
        assert report.attempts <= 2
        assert port.bench.chip("main").machine.memory.slots[0].frozen() == image.eeprom
        assert port.loader.phase is Phase.RUNNING
