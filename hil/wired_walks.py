"""The locomotion controller on a cable: whose bytes are in it, and whether it takes every command.

A cable shows that a movement is begun and comes to its end, and that a repeated sign is not walked
again by the answer alone; it shows no pulse. What the servos do is `hil.walks`' on the emulator.
"""

from cgagen.errors import RigError
from cgagen.words import COMMANDS
from hil.equivalence import Trial, blocked
from hil.subject import Subject
from hil.wired import SERIAL, SERIAL_RESET, WiredLegs


def legs_on(url: str, subject: Subject) -> WiredLegs:
    """Return the locomotion controller on a port, not yet open.

    Args:
        url: `serial:PORT`, or `serial-reset:PORT`, which resets it by DTR when it is opened.
        subject: what is to be in it.

    Raises:
        RigError: the name is not like that.
    """
    kind, _, port = url.partition(":")
    if kind not in (SERIAL, SERIAL_RESET) or not port:
        raise RigError(f"{url}: no such port of legs; say serial:PORT or serial-reset:PORT")
    return WiredLegs(port, subject, reset=kind == SERIAL_RESET)


def try_legs(url: str, subject: Subject) -> Trial:
    """Have each movement walked once. The robot really walks; it stands centred in the end.

    Raises:
        RigError: see `legs_on`.
    """
    chip = legs_on(url, subject)
    trial = Trial(url)
    try:
        with chip as legs:
            for command in range(len(COMMANDS[subject.role])):
                trial.tried[command] = 1
                legs.move(command)
                trial.agreed[command] = 1
            legs.centre()
    except RigError as error:
        failed = blocked(url, error)
        trial.verdict, trial.reason = failed.verdict, failed.reason
    return trial
