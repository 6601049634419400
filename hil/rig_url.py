"""The name of a target on a CAN bus: `can:INTERFACE:CHANNEL?guard=COUNTS`."""

import os
from typing import NamedTuple

from cgagen.errors import RigError

LIKE = (
    "say can:INTERFACE:CHANNEL, such as can:socketcan:can0 or can:slcan:/dev/ttyACM0, with "
    "?guard=COUNTS behind it where the rig's timers are not exact"
)

MOST_GUARD = 1_000
"""Counts; a wider band leaves nothing between two thresholds. Choice."""


class RigUrl(NamedTuple):
    """Where a rig is.

    Attributes:
        interface: one of python-can's.
        channel: its own, such as a device.
        guard_counts: how far readings are to keep from thresholds; None for what the rig says.
    """

    interface: str
    channel: str
    guard_counts: int | None

    @property
    def lock_name(self) -> str:
        """What nobody else may use: the device of a serial adapter, otherwise the channel."""
        if self.interface == "slcan":
            return self.channel.partition("@")[0]
        whose = f"{os.getpid()}/" if self.interface == "virtual" else ""  # each process has its own
        return f"can://{self.interface}/{whose}{self.channel}"


def rig_url(url: str) -> RigUrl:
    """Return what a URL says.

    Raises:
        RigError: it is malformed.

    >>> rig_url("can:slcan:/dev/ttyACM0@115200?guard=2")
    RigUrl(interface='slcan', channel='/dev/ttyACM0@115200', guard_counts=2)
    >>> rig_url("can:slcan:socket://127.0.0.1:4000").channel
    'socket://127.0.0.1:4000'
    """
    place, mark, option = url.partition("?")
    words = place.split(":", 2)
    if len(words) != 3 or words[0] != "can" or not all(words):
        raise RigError(f"{url}: no name of a rig; {LIKE}")
    guard_counts = None
    if mark:
        key, _, value = option.partition("=")
        if key != "guard" or not (value.isascii() and value.isdigit()) or int(value) > MOST_GUARD:
            raise RigError(
                f"{url}: {option or 'nothing'} behind the question mark; it may be guard=0 to "
                f"guard={MOST_GUARD}, in counts of the chip"
            )
        guard_counts = int(value)
    return RigUrl(words[1], words[2], guard_counts)
