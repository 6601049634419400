"""The image that a file of the command line is: out of a build with all that is known, or bare."""

from pathlib import Path

import click

from cgagen.build import read_record
from cgagen.build.checked import checked_images
from cgagen.build.record import RECORD_FILE
from cgagen.errors import ImageError
from cgagen.stamp.chips import CHIPS, EEPROM_BYTES, chip
from cgagen.stamp.image import Image


def image_at(file: Path, model: str | None, slot: int) -> Image:
    """Return the image in a file.

    Args:
        file: 2,048 bytes.
        model: the chip's name; needed where the file lies in no build.
        slot: program slot of a bare image.

    Raises:
        ImageError: it is no image, or one for another model.
        FolderError: it lies in a build that does not fit together.
        UsageError: nothing tells the model.
    """
    built = _built(file)
    if built is not None:
        if model is not None and chip(model) != built.model:
            raise ImageError(
                f"{file}: was built for a {built.model.name}, not for a {chip(model).name}; leave "
                "--model out, or take the other image"
            )
        if slot != built.slot:
            raise ImageError(f"{file}: was built for slot {built.slot}; leave --slot out")
        return built
    if model is None:
        names = ", ".join(row.name for row in CHIPS)
        raise click.UsageError(
            f"{file} does not tell which chip it is for; add --model with one of {names}"
        )
    try:
        with file.open("rb") as stream:
            eeprom = stream.read(EEPROM_BYTES + 1)
        return Image(chip(model), eeprom, slot=slot)
    except OSError as error:
        raise ImageError(
            f"{file}: cannot be read ({error.strerror or error}); name an image of "
            f"{EEPROM_BYTES:,} bytes"
        ) from error
    except ImageError as error:
        raise ImageError(f"{file}: {error}") from error


def _built(file: Path) -> Image | None:
    folder = file.parent
    if not (folder / RECORD_FILE).is_file():
        return None
    programs = read_record(folder).get("programs", {})
    names = [name for name, entry in programs.items() if entry.get("image") == file.name]
    return checked_images(folder)[names[0]] if names else None
