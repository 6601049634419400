"""A target, made and open: loaded where it holds another program, asked again where it is sick."""

from cgagen.errors import CgagenError, IdentityError, RigError, TargetTimeout
from hil.subject import Subject
from hil.target import Target
from hil.targets import make_target
from hil.wired import SERIAL, SERIAL_RESET, OtherChipError

AUTO, ALWAYS, NEVER = "auto", "always", "never"


def open_target(url: str, subject: Subject, flash: str = NEVER, reruns: int = 0) -> Target:
    """Return a target that is open and holds the subject's programs.

    Args:
        url: see `make_target`.
        subject: what it is to hold.
        flash: for a chip on a port: `auto` loads it where it says that it holds another image,
            and where it is silent as an erased one is, if it may be reset (`serial-reset:`);
            `always` in any case, `never` leaves it alone. What is emulated is given its image
            anyway.
        reruns: how often a sick bench is tried again.

    Raises:
        RigError: the target is sick, or cannot be loaded.
        CgagenError: see `cgagen.flash.flash_image`.
    """
    kind = url.partition(":")[0]
    serial = kind in (SERIAL, SERIAL_RESET)
    if flash == ALWAYS and serial:
        load_main(url, subject)
    try:
        return _opened(url, subject, reruns)
    except (TargetTimeout, OtherChipError):
        raise
    except IdentityError:
        if flash != AUTO or not serial:
            raise
        load_main(url, subject)
    except RigError:
        if flash != AUTO or kind != SERIAL_RESET or not _loaded(url, subject):
            raise
    return _opened(url, subject, reruns)


def _opened(url: str, subject: Subject, reruns: int) -> Target:
    """Return an open target; a sick bench is tried again so often."""
    for left in range(reruns, -1, -1):
        target = make_target(url, subject)
        try:
            target.open()
            return target
        except RigError as error:
            target.close()
            if not left or isinstance(error, TargetTimeout | IdentityError):
                raise
    raise ValueError(f"{reruns} reruns; there are none, or more")


def _loaded(url: str, subject: Subject) -> bool:
    """Load a chip that says nothing, as an erased one does; False where there is none."""
    try:
        load_main(url, subject)
    except CgagenError:
        return False
    return True


def load_main(url: str, subject: Subject) -> None:
    """Put the main controller's image into the chip on a port.

    Raises:
        CgagenError: see `cgagen.flash.flash_image`.
    """
    from cgagen.flash import flash_image

    flash_image(url.partition(":")[2], subject.images["main"])
