"""`cgagen info IMAGE.bin`: an EEPROM image as the program that it is.

What is printed is PBASIC itself, facts as comments, so that it can be compiled again.
"""

from dataclasses import dataclass
from pathlib import Path

import click

from cgagen.build import read_image, read_record
from cgagen.errors import CgagenError, ImageError
from cgagen.inputs import IMAGE, read_bytes
from cgagen.stamp.chips import CHIPS, EEPROM_BYTES, chip
from cgagen.stamp.compiled import Compiled
from cgagen.stamp.decode import decode
from cgagen.stamp.image import Image, Use
from cgagen.stamp.listing import Line, listing
from cgagen.stamp.program import Program
from cgagen.stamp.scan import lines_of
from cgagen.tokenizer import Tokenizer
from cgagen.tokenizer.files import read_source
from cgagen.verbs.console import Console

SOURCE_SUFFIXES = (".bs2", ".bse", ".bsx", ".bsp", ".bpe")
"""What Parallax's editor calls the sources of the five models. Ref: S4."""


@dataclass(frozen=True, slots=True)
class Found:
    """An image with what is known of it.

    Attributes:
        image: bytes and model, flags too where somebody knows them.
        compiled: the source beside it, where it makes the same bytes.
    """

    image: Image
    compiled: Compiled | None


def describe_image(console: Console, file: Path, model: str | None) -> None:
    """Print what an image is.

    Args:
        console: where to.
        file: 2,048 bytes.
        model: the chip's name; None to take it from the build, or from the source beside it.

    Raises:
        ImageError: it is no image, or holds no program of this model.
        FolderError: it lies in a build and has been changed since.
        UsageError: nothing tells the model.
    """
    found = find_image(console, file, model)
    image = found.image
    program = decode(image.eeprom, image.model, image.flags)
    lines = listing(program, image, _notes(found.compiled))
    facts = _facts(file, image, program, found.compiled)
    text = "\n".join([line.text for line in lines[:2]] + [f"' {fact}" for fact in facts])
    body = "\n".join(line.text for line in lines[2:])
    console.result(_data(image, program, lines), f"{text}\n\n{body}")


def find_image(console: Console, file: Path, model: str | None) -> Found:
    """Return an image with its model, its flags and its source, as far as they are known.

    Raises:
        ImageError: see `describe_image`.
        FolderError: likewise.
        UsageError: likewise.
    """
    eeprom = _read(file)
    built = _built(file) if model is None else None
    sources = _sources_of(console, file, eeprom)
    models = {one.image.model.name for one in sources}
    if model is None and built is None and len(models) > 1:
        raise click.UsageError(
            f"{' and '.join(one.name for one in sources)} both make {file}; add --model with one "
            f"of {', '.join(sorted(models))}"
        )
    wanted = chip(model) if model is not None else built.model if built is not None else None
    fitting = [one for one in sources if wanted is None or one.image.model == wanted]
    compiled = fitting[0] if fitting else None
    if model is not None:
        try:
            image = Image(chip(model), eeprom)
        except ImageError as error:
            raise ImageError(f"{file}: {error}") from error
    elif built is not None:
        image = built
    elif compiled is not None:
        image = compiled.image
    else:
        names = ", ".join(row.name for row in CHIPS)
        raise click.UsageError(
            f"{file} does not tell which chip it is for; add --model with one of {names}"
        )
    if compiled is not None and image.flags is None:
        image = compiled.image
    return Found(image, compiled)


def _read(file: Path) -> bytes:
    return read_bytes(file, IMAGE)


def _built(file: Path) -> Image | None:
    """Return the image out of the build that it lies in; None where it lies in none."""
    folder = file.parent
    if not (folder / "build.json").is_file():
        return None
    programs = read_record(folder).get("programs", {})
    names = [name for name, entry in programs.items() if entry.get("image") == file.name]
    return read_image(folder, names[0]) if names else None


def _sources_of(console: Console, file: Path, eeprom: bytes) -> list[Compiled]:
    """Return the sources of the same name beside an image that make the same bytes."""
    found = []
    for suffix in (*SOURCE_SUFFIXES, *map(str.upper, SOURCE_SUFFIXES)):
        path = file.with_suffix(suffix)
        if not path.is_file():
            continue
        try:
            with Tokenizer(warn=console.note) as tokenizer:
                compiled = tokenizer.compile(read_source(path), path.name)
        except CgagenError as error:
            console.note(f"note: without the lines of {path.name}: {error}")
            continue
        if compiled.image.eeprom == eeprom:
            found.append(compiled)
        else:
            console.note(f"note: {path.name} makes another image than {file.name}")
    return found


def _notes(compiled: Compiled | None) -> dict[int, list[str]]:
    """Return the source lines by the stream bit that they begin at, each line once."""
    notes: dict[int, list[str]] = {}
    if compiled is None:
        return notes
    lines = lines_of(compiled.source)
    seen = set()
    for statement in compiled.source_map.statements:
        if statement.line not in seen:
            seen.add(statement.line)
            # "{$" would be a directive in a comment, too.
            text = lines[statement.line - 1].strip().replace("{$", "{ $")
            notes.setdefault(statement.bit, []).append(f"{statement.line}: {text}")
    return notes


def _facts(file: Path, image: Image, program: Program, compiled: Compiled | None) -> list[str]:
    data = _data_bytes(image, program)
    slots = ", ".join(map(str, program.gosub_slots))
    facts = [
        f"{file.name}: an image for a {image.model.name}, digest {image.digest[:8]}",
        f"program {program.program_bytes} bytes, DATA {data} bytes"
        f"{'' if image.flags else ' that are not 0'}, "
        f"free {EEPROM_BYTES - program.program_bytes - data} bytes",
        f"{len(program.instructions)} instructions, {len(program.gosub_slots)} GOSUBs"
        + (f" that return to stream bits {slots}" if slots else ""),
    ]
    if compiled is not None:
        facts.append(f"comments with a number are the lines of {compiled.name}")
    return facts


def _data_bytes(image: Image, program: Program) -> int:
    if image.flags is not None:
        return image.count(Use.DATA) + image.count(Use.RESERVED)
    below = image.eeprom[: EEPROM_BYTES - program.program_bytes]
    return len(below) - below.count(0)


def _data(image: Image, program: Program, lines: tuple[Line, ...]) -> dict[str, object]:
    return {
        "kind": "image",
        "model": image.model.name,
        "digest": image.digest,
        "program_bytes": program.program_bytes,
        "data_bytes": _data_bytes(image, program),
        "start_bit": program.start_bit,
        "gosub_slots": list(program.gosub_slots),
        "instructions": len(program.instructions),
        "listing": [{"bit": line.address, "text": line.text} for line in lines],
    }
