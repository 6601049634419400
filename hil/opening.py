"""A target, made and open: loaded where it holds another program, asked again where it is sick."""

from cgagen.errors import IdentityError, RigError, TargetTimeout
from hil.subject import Subject
from hil.target import Target
from hil.targets import make_target

AUTO, ALWAYS, NEVER = "auto", "always", "never"
SERIAL = "serial:"


def open_target(url: str, subject: Subject, flash: str = NEVER, reruns: int = 0) -> Target:
    """Return a target that is open and holds the subject's programs.

    Args:
        url: see `make_target`.
        subject: what it is to hold.
        flash: for a chip on a port: `auto` loads it where it holds another image, `always` in
            any case, `never` leaves it alone. What is emulated is given its image anyway.
        reruns: how often a sick bench is tried again.

    Raises:
        RigError: the target is sick, or cannot be loaded.
        CgagenError: see `cgagen.flash.flash_image`.
    """
    if flash == ALWAYS and url.startswith(SERIAL):
        load_main(url, subject)
    for left in range(reruns, -1, -1):
        target = make_target(url, subject)
        try:
            target.open()
            return target
        except IdentityError:
            target.close()
            if flash == NEVER or not url.startswith(SERIAL):
                raise
            load_main(url, subject)
            return open_target(url, subject, NEVER, left)
        except TargetTimeout:
            target.close()
            raise
        except RigError:
            target.close()
            if not left:
                raise
    raise AssertionError("unreachable")


def load_main(url: str, subject: Subject) -> None:
    """Put the main controller's image into the chip on a port.

    Raises:
        CgagenError: see `cgagen.flash.flash_image`.
    """
    from cgagen.flash import flash_image

    flash_image(url.removeprefix(SERIAL), subject.images["main"])
