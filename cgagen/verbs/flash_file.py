"""The images that a file of the command line is: out of a build, a bare one, or from a source."""

from dataclasses import replace
from pathlib import Path

import click

from cgagen.build import read_record
from cgagen.build.checked import checked_images
from cgagen.build.record import RECORD_FILE
from cgagen.errors import ImageError
from cgagen.stamp.chips import chip
from cgagen.stamp.image import Image
from cgagen.tokenizer import Tokenizer
from cgagen.tokenizer.project import ProjectSources
from cgagen.verbs.console import Console
from cgagen.verbs.info_image import SOURCE_SUFFIXES, find_image


def images_at(console: Console, file: Path, model: str | None, slot: int) -> dict[str, Image]:
    """Return the images in a file, by name; the one that runs first comes last.

    Args:
        console: for notes.
        file: 2,048 bytes, or a PBASIC source, whose $STAMP line may name the files of slots 1 to 7.
        model: the chip's name; needed where the file lies in no build, and no source that makes it
            lies beside it.
        slot: program slot of a bare image, or of a source.

    Raises:
        ImageError: it is no image, or one for another model.
        FolderError: it lies in a build that does not fit together.
        SourceError: it is a source that the tokenizer refuses.
        UsageError: nothing tells the model.
    """
    if file.suffix.lower() in SOURCE_SUFFIXES:
        return _compiled(console, file, model, slot)
    built = _built(file)
    if built is None:
        return {file.stem: _bare(console, file, model, slot)}
    _refuse_other(file, model, built)
    if slot != built.slot:
        raise ImageError(f"{file}: was built for slot {built.slot}; leave --slot out")
    return {file.stem: built}


def _bare(console: Console, file: Path, model: str | None, slot: int) -> Image:
    """Return an image as it is: all of it is sent, whatever a source beside it says is used."""
    found = find_image(console, file, model)
    if model is None and found.compiled is not None:
        name = found.image.model.name
        console.note(f"note: {file} is for a {name}, as {found.compiled.name} beside it says")
    return Image(found.image.model, found.image.eeprom, slot=slot)


def _compiled(console: Console, file: Path, model: str | None, slot: int) -> dict[str, Image]:
    with Tokenizer(warn=console.note) as tokenizer:
        sources = ProjectSources(tokenizer, console.note)
        first = sources.compile(file)
        _refuse_other(file, model, first.image)
        images = {file.stem: replace(first.image, slot=slot)}
        if first.project_files and slot:
            raise click.UsageError(
                f"{file}: its $STAMP line names the files of further slots; leave --slot out"
            )
        for number, name in enumerate(first.project_files, start=1):
            other = file.parent / name
            image = sources.compile(other).image
            _refuse_other(other, first.image.model.name, image)
            # Two slots may hold one program.
            key = name if name not in images else f"{name} (slot {number})"
            images[key] = replace(image, slot=number)
    return dict(reversed(images.items()))


def _refuse_other(file: Path, model: str | None, image: Image) -> None:
    if model is not None and chip(model) != image.model:
        raise ImageError(
            f"{file}: is for a {image.model.name}, not for a {chip(model).name}; leave --model "
            "out, or take another file"
        )


def _built(file: Path) -> Image | None:
    folder = file.parent
    if not (folder / RECORD_FILE).is_file():
        return None
    programs = read_record(folder).get("programs", {})
    names = [name for name, entry in programs.items() if entry.get("image") == file.name]
    return checked_images(folder)[names[0]] if names else None
