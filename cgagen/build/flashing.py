"""A build into both Stamps of a robot: which port is which is asked before anything is sent."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from cgagen.build.checked import checked_images
from cgagen.errors import CgagenError, RigError
from cgagen.flash import FlashReport, Module, Progress, flash_image, identify_port
from cgagen.link.ports import all_ports
from cgagen.stamp.chips import Chip
from cgagen.stamp.image import Image

ORDER = ("locomotion", "main")
"""The legs first: without the other's GO they stand. Choice."""

Identify = Callable[[str, tuple[Chip, ...]], Module]

Tell = Callable[[str, Progress], None]
"""Told a chip's name and how far its download is."""


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
        named: port by chip, "main" or "locomotion"; a chip that is not named is left alone.
            Empty: the ports of this machine are asked.
        verify: read back what was sent; see `cgagen.flash`.
        progress: told of every packet.

    Raises:
        FolderError: something about the folder does not fit; see `checked_images`.
        RigError: a port is sick, or no port has the right module; nothing was sent.
        FlashError: a download had begun and did not end well.
    """
    images = checked_images(folder)
    ports = assign(images, named or {})
    reports = {}
    for chip in ORDER:
        if chip in ports:
            tell = None if progress is None else _of(chip, progress)
            reports[chip] = flash_image(ports[chip], images[chip], verify=verify, progress=tell)
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
        candidates: ports to ask where none is named; None for those of this machine.
        identify: what asks.

    Raises:
        RigError: a named port has another model; or not exactly one port has a chip's.
    """
    if named:
        if len(set(named.values())) < len(named):
            raise RigError(f"{next(iter(named.values()))}: cannot be both chips; name two ports")
        for chip, port in named.items():
            _refuse_other(chip, images[chip], port, identify(port, (images[chip].model,)))
        return dict(named)
    names = candidates if candidates is not None else _usb_first()
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


def _usb_first() -> list[str]:
    ports = all_ports()
    return [port.device for port in ports if port.vendor is not None] or [
        port.device for port in ports
    ]


def _only(chip: str, image: Image, modules: Mapping[str, Module], seen: Mapping[str, str]) -> str:
    found = [name for name, module in modules.items() if module.model == image.model]
    if len(found) == 1:
        return found[0]
    what = "more than one port has" if found else "no port has"
    facts = "; ".join(f"{name}: {text}" for name, text in seen.items()) or "there are no ports"
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


def _of(chip: str, progress: Tell) -> Callable[[Progress], None]:
    return lambda step: progress(chip, step)
