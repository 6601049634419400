"""What a chip executes, instruction by instruction, as text."""

import re
from collections.abc import Callable, Mapping
from typing import TextIO

from cgagen.emulator.chip import Chip
from cgagen.errors import ImageError
from cgagen.stamp.compiled import Compiled
from cgagen.stamp.decode import decode
from cgagen.stamp.image import Image
from cgagen.stamp.listing import listing

_LABEL = re.compile(r"^L\d+:")

HEADER = "time_us,slot,bit,line,instruction"


def trace(
    chip: Chip, file: TextIO, images: Mapping[int, Image], programs: Mapping[int, Compiled]
) -> Callable[[], None]:
    """Write a line before every instruction of a chip; returns how to end that.

    The columns are those of `HEADER`. The line is empty where the source is not known. The words
    are those of the program as it was at the start, also where WRITE has changed it. Slower than
    running without.

    Args:
        chip: that is watched.
        file: open for writing.
        images: what each slot held at the start, for the words of instructions.
        programs: sources by slot.
    """
    file.write(HEADER + "\n")
    texts = {slot: _texts(image) for slot, image in images.items()}

    def row(chip: Chip) -> None:
        slot, bit = chip.slot, chip.pc
        line = line_at(programs, slot, bit)
        text = texts.get(slot, {}).get(bit, "")
        quoted = '"' + text.replace('"', '""') + '"'
        time_us = f"{chip.clock.now_ns // 1000}.{chip.clock.now_ns % 1000:03d}"
        file.write(f"{time_us},{slot},{bit},{'' if line is None else line},{quoted}\n")

    return chip.on_instruction(row)


def line_at(programs: Mapping[int, Compiled], slot: int, bit: int) -> int | None:
    """Return the source line of a stream address; None where it is not known."""
    compiled = programs.get(slot)
    statement = None if compiled is None else compiled.source_map.at_bit(bit)
    return None if statement is None else statement.line


def _texts(image: Image) -> dict[int, str]:
    """Return the words of each instruction by its address, as far as they make a program."""
    try:
        program = decode(image.eeprom, image.model, image.flags)
        lines = listing(program, image)
    except ImageError:
        return {}
    # What the tokenizer adds itself, such as the last END, has a name and no line of a listing.
    texts = {instruction.address: instruction.name for instruction in program.instructions}
    for line in lines:
        text = _LABEL.sub("", line.text).strip()
        if line.address is not None and text:
            texts[line.address] = text
    return texts
