"""A build into both Stamps of a robot: which port is which is asked before anything is sent."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from cgagen.build.checked import checked_images
from cgagen.errors import CgagenError, FlashError, RigError
from cgagen.flash import FlashReport, Module, Progress, flash_image, identify_port
from cgagen.link.ports import all_ports, choose_port
from cgagen.stamp.chips import Chip
from cgagen.stamp.image import Image

ORDER = ("locomotion", "main")
"""The legs first: without the other's GO they stand. Choice."""

Identify = Callable[[str, tuple[Chip, ...]], Module]

Tell = Callable[[str, Progress], None]
"""Told an image's name and how far its download is."""


def flash_build(
    folder: Path,
    named: Mapping[str, str] | None = None,
    *,
    verify: bool = False,
    progress: Tell | None = None,
) -> dict[str, FlashReport]:
    """Put the images of a build into its chips.

    Args:
        folder: a build.
        named: port by chip, "main" or "locomotion", as `choose_port` has them; a chip that is
            not named is left alone. Empty: the USB adapters are asked.
        verify: read back what was sent; see `cgagen.flash`.
        progress: told of every packet.

    Raises:
        FolderError: something about the folder does not fit; see `checked_images`.
        RigError: a port is sick, or no port has the right module; nothing was sent.
        FlashError: a download had begun and did not end well.
    """
    images = checked_images(folder)
    ports = assign(images, named or {})
    jobs = {chip: (ports[chip], images[chip]) for chip in ORDER if chip in ports}
    return flash_in_turn(jobs, verify=verify, progress=progress)


def flash_in_turn(
    jobs: Mapping[str, tuple[str, Image]], *, verify: bool = False, progress: Tell | None = None
) -> dict[str, FlashReport]:
    """Put several images, which belong together, into their chips or slots.

    Args:
        jobs: port and image, by name, in order.
        verify: see `flash_build`.
        progress: likewise.

    Raises:
        CgagenError: see `flash_image`; a FlashError where only some of them went in, and Ctrl-C
            then, too.
    """
    reports: dict[str, FlashReport] = {}
    for name, (port, image) in jobs.items():
        tell = None if progress is None else _of(name, progress)
        try:
            reports[name] = flash_image(port, image, verify=verify, progress=tell)
        except (CgagenError, KeyboardInterrupt) as error:
            if not reports:
                raise
            why = str(error) or f"{port}: stopped"
            raise FlashError(
                f"{why}; {' and '.join(reports)} went in before: flash all of it again before it "
                "runs"
            ) from error
    return reports


def assign(
    images: Mapping[str, Image],
    named: Mapping[str, str],
    candidates: Sequence[str] | None = None,
    identify: Identify = identify_port,
) -> dict[str, str]:
    """Return the port of each chip, each having told its model.

    Args:
        images: by chip.
        named: ports that the user has named, by chip.
        candidates: ports to ask where none is named; None for the USB adapters.
        identify: what asks.

    Raises:
        RigError: a named port has another model; or not exactly one port has a chip's.
    """
    if named:
        chosen = {chip: choose_port(name) for chip, name in named.items()}
        if len(set(chosen.values())) < len(chosen):
            raise RigError(f"{next(iter(chosen.values()))}: cannot be both chips; name two ports")
        for chip, port in chosen.items():
            _refuse_other(chip, images[chip], port, identify(port, (images[chip].model,)))
        return chosen
    names = candidates if candidates is not None else _on_usb()
    likely = tuple(image.model for image in images.values())
    seen: dict[str, str] = {}
    modules: dict[str, Module] = {}
    for name in names:
        try:
            modules[name] = identify(name, likely)
            seen[name] = modules[name].name
        except CgagenError as error:
            seen[name] = str(error).removeprefix(f"{name}: ")
    return {chip: _only(chip, image, modules, seen) for chip, image in images.items()}


def _on_usb() -> list[str]:
    """Return the ports that are asked without having been named."""
    return [port.device for port in all_ports() if port.vendor is not None]


def _only(chip: str, image: Image, modules: Mapping[str, Module], seen: Mapping[str, str]) -> str:
    found = [name for name, module in modules.items() if module.model == image.model]
    if len(found) == 1:
        return found[0]
    what = "more than one port has" if found else "no port has"
    facts = "; ".join(f"{name}: {text}" for name, text in seen.items()) or "there is no USB adapter"
    raise RigError(
        f"{what} the {image.model.name} of the {chip} controller ({facts}); name both ports with "
        "--main and --locomotion"
    )


def _refuse_other(chip: str, image: Image, port: str, module: Module) -> None:
    if module.model != image.model:
        raise RigError(
            f"{port}: this is a {module.name}, the {chip} controller is a {image.model.name}; "
            "nothing was sent: are the ports the other way round?"
        )


def _of(name: str, progress: Tell) -> Callable[[Progress], None]:
    return lambda step: progress(name, step)
