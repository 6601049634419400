"""From the name of a target to the target."""

from cgagen.errors import RigError
from cgagen.near import did_you_mean
from hil.canbus import CanTarget
from hil.emulated import PinsTarget
from hil.simulated import SimulatedTarget
from hil.subject import Subject
from hil.target import Target
from hil.wired import SERIAL, SERIAL_RESET, WiredTarget

KINDS = ("simulator", "emulator", SERIAL, SERIAL_RESET, "can")
"""What the name of a target begins with."""


def make_target(url: str, subject: Subject) -> Target:
    """Return a target, not yet open.

    Args:
        url: `simulator`, `emulator`, `serial:PORT` with a device, `id:SERIAL` or a URL of
            pyserial's, `serial-reset:PORT` likewise, which is reset by DTR when it is opened, or
            `can:INTERFACE:CHANNEL` with python-can's words, as `hil.rig_url` has it.
        subject: what it is to try.

    Raises:
        RigError: no such kind of target, or a malformed name.
    """
    kind, _, rest = url.partition(":")
    if url == "simulator":
        return SimulatedTarget(subject)
    if url == "emulator":
        return PinsTarget(subject)
    if kind in (SERIAL, SERIAL_RESET) and rest:
        return WiredTarget(rest, subject, reset=kind == SERIAL_RESET)
    if kind == "can":
        return CanTarget(url, subject)
    raise RigError(
        f"{url}: no such target{did_you_mean(kind, KINDS)}; say simulator, emulator, serial:PORT, "
        "serial-reset:PORT or can:INTERFACE:CHANNEL"
    )
