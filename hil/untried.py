"""What a run leaves out of all that can be tried: rows of their own, so that nothing vanishes.

What is tried of the images on the emulator is tried of a chip on a wire, too, whose bytes have
been compared with them. So what a wire leaves open is whose bytes are in a chip.
"""

from collections.abc import Iterator, Sequence

from hil.equivalence import Trial, not_tried
from hil.subject import Subject
from hil.target import IMAGE, Target
from hil.wired import SERIAL, SERIAL_RESET

CAN = "can"
WIRES = (SERIAL, SERIAL_RESET, CAN)

ALL_OF_A_ROBOT = {
    "cells": "emulator:cells",
    "movements": "emulator:locomotion",
    "timing": "emulator:timing",
    "conduct": "emulator:conduct",
}
"""What a whole run tries besides decisions, and on what."""


def beside_readings() -> Iterator[tuple[str, Trial]]:
    """Return the rows of a run in which readings were named."""
    for name, target in ALL_OF_A_ROBOT.items():
        yield name, not_tried(target, "the readings that were named are tried alone; name none")


def of_build(subject: Subject) -> Iterator[tuple[str, Trial]]:
    """Return the row of a build whose robot has been edited since it was made.

    What the edit would have made is not in the images: a trim of a few microseconds more is within
    what a servo does not notice, and no check of its pulses sees that.
    """
    if subject.robot_edited:
        yield (
            "robot file",
            not_tried(
                "robot.toml",
                f"{subject.where}: robot.toml has been edited since the programs were built; build "
                "them again",
            ),
        )


def table_behind(reason: str) -> Trial:
    """Return the row of a table that could not be looked up, because Decide was not reached."""
    return not_tried("emulator:table", f"the registers could not be used: {reason}")


def of_wires(others: Sequence[Target], legs: str | None) -> Iterator[tuple[str, Trial]]:
    """Return the rows of chips that are on a wire, or beside one that is, and were not read.

    Args:
        others: the targets of the run besides the emulator, after they were tried.
        legs: the locomotion controller's port; None where none was named.
    """
    wired = [one for one in others if kind_of(one.url) in WIRES]
    if wired and legs is None:
        yield (
            "legs",
            not_tried(
                "locomotion controller",
                "whose bytes are in the locomotion controller's chip was not asked; name its "
                "port with --legs serial:PORT",
            ),
        )
    beside = [one.url for one in wired] or ([] if legs is None else [legs])
    if beside and not any(IMAGE in one.caps for one in wired):
        yield (
            "main bytes",
            not_tried(
                "main controller",
                f"{', '.join(beside)} does not show whose bytes are in the main controller's "
                "chip; name its port with --target serial:PORT",
            ),
        )


def kind_of(url: str) -> str:
    """Return the first word of a target's name.

    >>> kind_of("serial-reset:/dev/ttyUSB0")
    'serial-reset'
    """
    return url.partition(":")[0]
