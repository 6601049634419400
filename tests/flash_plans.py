"""Images and plans for a fake Stamp, and how a programmer fares with them."""

import random
from functools import cache

from cgagen.errors import FlashError, RigError
from cgagen.flash.line import Line
from cgagen.flash.plan import plan_of
from cgagen.flash.programmer import FlashReport, program
from cgagen.stamp.chips import chip
from cgagen.stamp.image import SENT, Image, Use
from tests.fake_stamp import FakeChip, FakePort

LONGEST_S = 30.0
"""No try may take longer, in the line's own time."""


@cache
def image_of(model: str, blocks: tuple[int, ...] = (0, 126, 127), slot: int = 0) -> Image:
    """An image whose marked blocks hold chance; a packet with checksum 00 is among them."""
    chance = random.Random(model)
    eeprom, flags = bytearray(2048), bytearray(2048)
    for block in blocks:
        span = slice(block * 16, block * 16 + 16)
        eeprom[span] = chance.randbytes(16)
        flags[span] = bytes((Use.PROGRAM | SENT,)) * 16
    last = blocks[-1] * 16
    eeprom[last + 13 : last + 15] = b"\0\0"
    eeprom[last + 15] = 0
    eeprom[last] = -(0x80 + blocks[-1] + sum(eeprom[last + 1 : last + 16])) & 0xFF
    return Image(chip(model), bytes(eeprom), bytes(flags), slot)


planned = cache(plan_of)


def of(name: str) -> str:
    """The model of a module."""
    return name.removesuffix("24").removesuffix("40")


def flash(port: FakePort, image: Image) -> FlashReport:
    return program(Line(port, port.clock), "/dev/fake", planned(image))


def holds(stamp: FakeChip, image: Image) -> bool:
    plan = planned(image)
    eeprom = stamp.slots[image.slot]
    return all(
        eeprom[n * 16 : n * 16 + 16] == image.eeprom[n * 16 : n * 16 + 16] for n in plan.blocks
    )


def attempt(port: FakePort, image: Image) -> FlashReport | RigError | FlashError:
    started_s = port.clock.now_s()
    try:
        return flash(port, image)
    except (RigError, FlashError) as error:
        return error
    finally:
        assert port.clock.now_s() - started_s < LONGEST_S
