"""Reading back: the firmware itself dumps what was sent, and it is compared byte by byte.

What it proves: the program that runs after a reset reads from its own EEPROM what the image has,
in every block that was sent. What it does not: blocks that were not sent keep what the chip held;
and the bytes come by way of the program that was sent, not past it, for no command of the loader
reads them.
"""

from cgagen.bench_protocol import banner_in
from cgagen.errors import FlashError, ImageError
from cgagen.flash.plan import Plan, runs
from cgagen.link.bench_hook import BenchHook
from cgagen.stamp.image import Image
from cgagen.stamp.packets import BLOCK_BYTES


def refuse_mute(image: Image) -> None:
    """Refuse an image that could not be read back, before anything is sent.

    Raises:
        ImageError: it has no bench hook, or does not run after a reset.
    """
    if banner_in(image.eeprom) is None:
        raise ImageError(
            "--verify asks this project's firmware for its bytes, and this image is another "
            "program; leave --verify out"
        )
    if image.slot:
        raise ImageError(
            f"--verify reads the slot that runs after a reset, which is 0 and not {image.slot}; "
            "leave --verify out"
        )


def read_back(port_name: str, plan: Plan) -> int:
    """Reset the chip, compare every block that was sent, and let the program go its way.

    Returns:
        How many blocks were compared.

    Raises:
        RigError: the chip does not answer.
        FlashError: a byte is another.
    """
    with BenchHook(port_name) as hook:
        hook.enter()
        found = read_sent(hook, plan)
        hook.leave()
    refuse_difference(port_name, 0, plan.image.eeprom, found)
    return len(plan.blocks)


def read_sent(hook: BenchHook, plan: Plan) -> bytes:
    """Return the EEPROM of a chip in bench mode, what is never sent taken as the image has it.

    A download leaves those blocks as they were, so on a chip with a past they hold anything.

    Raises:
        RigError: the chip does not answer.
    """
    eeprom = bytearray(plan.image.eeprom)
    for first, last in runs(plan.blocks):
        start, end = first * BLOCK_BYTES, (last + 1) * BLOCK_BYTES
        eeprom[start:end] = hook.dump(start, end - 1)
    return bytes(eeprom)


def refuse_difference(port_name: str, start: int, wanted: bytes, found: bytes) -> None:
    """Compare a range.

    Raises:
        FlashError: a byte is another, or one is missing.

    >>> refuse_difference("/dev/ttyUSB0", 16, b"abc", b"abd")
    Traceback (most recent call last):
    cgagen.errors.FlashError: /dev/ttyUSB0: byte 18 of the EEPROM reads 64h and 63h was sent and \
acknowledged; flash it again, and look at the supply voltage
    """
    for place, (sent, read) in enumerate(zip(wanted, found, strict=True), start):
        if sent != read:
            raise FlashError(
                f"{port_name}: byte {place} of the EEPROM reads {read:02X}h and {sent:02X}h was "
                "sent and acknowledged; flash it again, and look at the supply voltage"
            )
