"""From an image to a chip, over a port by its name: the whole way, lock to report."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace

from cgagen.errors import CgagenError, FlashError, RigError
from cgagen.flash.diagnoses import HALF, UNREAD, UNSTARTED, sentence_of
from cgagen.flash.download import Done, State, download
from cgagen.flash.identify import OURS, identify
from cgagen.flash.line import Clock, Line, WallClock
from cgagen.flash.modules import Module
from cgagen.flash.plan import Plan, plan_of
from cgagen.flash.requests import Progress, Restart, TroubleError
from cgagen.flash.verify import read_back, refuse_mute
from cgagen.link.port import locked_port
from cgagen.link.steered import SIGN, has_lines, split_control
from cgagen.link.why import LINELESS, LOST
from cgagen.stamp.chips import Chip
from cgagen.stamp.image import Image

REMOTE_LATENCY_S = 0.2
"""What is added to every wait where the port is on another machine. Choice."""

Tell = Callable[[Progress], None]


@dataclass(frozen=True, slots=True)
class FlashReport:
    """A chip that holds an image: every packet has been acknowledged.

    Attributes:
        port: where.
        module: what was found there.
        slot: program slot.
        blocks: the 16-byte blocks that were sent.
        attempts: how often the download began, 1 on a good line.
        image_digest: of all 2,048 bytes.
        talks: the program was heard afterwards; False where it was started by a reset.
        verified: blocks that were read back and are equal; None where nobody looked.
    """

    port: str
    module: Module
    slot: int
    blocks: tuple[int, ...]
    attempts: int
    image_digest: str
    talks: bool
    verified: int | None = None


def flash_image(
    port_name: str,
    image: Image,
    *,
    verify: bool = False,
    progress: Tell | None = None,
) -> FlashReport:
    """Identify the module on a port, put an image into it, and start the program.

    Args:
        port_name: device path or URL of pyserial's.
        image: model, slot and bytes; the blocks that its flags mark are sent, all where it has
            no flags.
        verify: read every block that was sent back through the bench hook, and compare.
        progress: told of every packet that the chip has taken.

    Raises:
        ImageError: the image is not fit to be sent.
        RigError: the port or what hangs on it is sick, or it is another model; nothing was sent.
        FlashError: the download had begun and did not end well.
    """
    plan = plan_of(image)
    if verify:
        refuse_mute(image)
    with opened(port_name) as line:
        report = program(line, port_name, plan, progress)
    if not verify:
        return report
    try:
        return replace(report, verified=read_back(port_name, plan))
    except RigError as error:
        raise FlashError(UNREAD.format(error=error)) from error


def identify_port(port_name: str, likely: Iterable[Chip] = OURS) -> Module:
    """Return the module on a port. It is reset, and its program starts anew.

    Args:
        port_name: device path or URL of pyserial's.
        likely: models that are asked before the others, each of which takes a third of a second.

    Raises:
        RigError: the port or what hangs on it is sick.
    """
    with opened(port_name) as line:
        return ask(line, port_name, likely)


def program(line: Line, port_name: str, plan: Plan, progress: Tell | None = None) -> FlashReport:
    """Do what `flash_image` does, on a line that is open.

    Raises:
        RigError: see `flash_image`.
        FlashError: likewise.
    """
    state = State()
    wanted = plan.image.model.name
    try:
        done: Done = line.converse(download(plan, state), progress)
    except TroubleError as trouble:
        if not state.begun:
            restart(line)
        half = state.begun and not state.complete
        raise _error(state)(sentence_of(trouble, port_name, wanted, half)) from trouble
    except LOST as error:
        raise _lost(port_name, state, error) from error
    except KeyboardInterrupt as stop:
        if state.begun and not state.complete:
            raise FlashError(f"{port_name}: stopped in the middle{HALF}") from stop
        restart(line)
        raise
    return FlashReport(
        port_name,
        done.module,
        plan.image.slot,
        plan.blocks,
        state.attempt,
        plan.image.digest,
        done.talks,
    )


def ask(line: Line, port_name: str, likely: Iterable[Chip] = OURS) -> Module:
    """Do what `identify_port` does, on a line that is open.

    Raises:
        RigError: see `identify_port`.
    """
    try:
        return line.converse(identify(likely))
    except TroubleError as trouble:
        raise RigError(sentence_of(trouble, port_name, "", False)) from trouble
    except LOST as error:
        raise _lost(port_name, State(), error) from error
    finally:
        restart(line)


def restart(line: Line) -> None:
    """Start whatever program is in the chip; a port that is gone cannot, and that is known."""
    with suppress(*LOST):
        line.perform(Restart())


@contextmanager
def opened(port_name: str, clock: Clock | None = None) -> Iterator[Line]:
    """Lock and open a port, and close it whatever happens.

    Raises:
        RigError: it cannot be opened, or carries neither BREAK nor DTR.
    """
    if not has_lines(port_name):
        raise RigError(
            f"{port_name}: carries neither BREAK nor DTR, so nothing can be reset for a "
            f"download; use rfc2217://, which does, or say {SIGN}HOST:PORT behind it"
        )
    base, control = split_control(port_name)
    remote = "://" in base or bool(control)
    with locked_port(port_name) as port:
        yield Line(port, clock or WallClock(), REMOTE_LATENCY_S * remote)


def _error(state: State) -> type[CgagenError]:
    return FlashError if state.begun else RigError


def _lost(port_name: str, state: State, error: BaseException) -> CgagenError:
    if getattr(error, "errno", None) in LINELESS and not state.begun:
        return RigError(
            f"{port_name}: has no DTR or no BREAK ({error}), so no Stamp can be reset for a "
            f"download; use an adapter that has both, or say {SIGN}HOST:PORT behind it"
        )
    if state.complete:
        return FlashError(UNSTARTED.format(port=port_name, error=error))
    if state.begun:
        return FlashError(f"{port_name}: lost in the middle of the download ({error}){HALF}")
    return RigError(f"{port_name}: lost ({error}) before anything was sent; look at the cable")
