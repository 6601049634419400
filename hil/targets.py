"""From the name of a target to the target."""

from cgagen.errors import RigError
from hil.emulated import PinsTarget
from hil.simulated import SimulatedTarget
from hil.subject import Subject
from hil.target import Target
from hil.wired import WiredTarget


def make_target(url: str, subject: Subject) -> Target:
    """Return a target, not yet open.

    Args:
        url: `simulator`, `emulator`, or `serial:PORT` with a device or a URL of pyserial's.
        subject: what it is to try.

    Raises:
        RigError: no such kind of target.
    """
    kind, _, rest = url.partition(":")
    if url == "simulator":
        return SimulatedTarget(subject)
    if url == "emulator":
        return PinsTarget(subject)
    if kind == "serial" and rest:
        return WiredTarget(rest, subject)
    raise RigError(f"{url}: no such target; say simulator, emulator or serial:PORT")
