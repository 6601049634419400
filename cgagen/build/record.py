"""`build.json`: what a build folder holds, and what it was made of, by digest."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from cgagen import inputs
from cgagen.bench_protocol import VERSION
from cgagen.build.shape import trouble_of
from cgagen.errors import FolderError
from cgagen.files import digest
from cgagen.firmware import LOCOMOTION_FILE, MAIN_FILE, Firmware, Program
from cgagen.genome import Genome
from cgagen.memory import MemoryReport
from cgagen.notations import parse_json
from cgagen.robot.values import Robot
from cgagen.shown import shown
from cgagen.stamp.chips import chip
from cgagen.stamp.image import SENT, Image
from cgagen.toolchain import TOKENIZER_SHA256
from cgagen.toolchain import VERSION as TOKENIZER_VERSION

FORMAT = "cgagen-build-1"

RECORD_FILE = "build.json"
MEMORY_FILE = "memory.txt"
WIRING_FILE = "wiring.txt"
BENCH_FILE = "bench.toml"
ROBOT_FILE = "robot.toml"
GENOME_FILE = "best.genome"

FILES = frozenset(
    {
        MAIN_FILE,
        LOCOMOTION_FILE,
        "main.bin",
        "locomotion.bin",
        MEMORY_FILE,
        WIRING_FILE,
        BENCH_FILE,
        ROBOT_FILE,
        GENOME_FILE,
        RECORD_FILE,
    }
)
"""Every name that a build folder may hold."""

BLOCK_BYTES = 16
"""Of the EEPROM; a download sends whole blocks. Ref: S3."""


def record_of(
    robot: Robot,
    genome: Genome | None,
    firmware: Firmware,
    files: Mapping[str, bytes],
    compiled: Iterable[tuple[Program, str, Image, MemoryReport]],
) -> dict[str, Any]:
    """Return the content of `build.json`.

    Args:
        robot: whose build it is.
        genome: the predator's; None for a prey.
        firmware: the sources.
        files: all other files of the folder by name.
        compiled: program, name of its image, image and memory report, one after the other.
    """
    return {
        "format": FORMAT,
        "protocol": VERSION,
        "robot": {
            "name": robot.name,
            "role": str(robot.role),
            "digest": robot.digest,
            "interface": robot.interface,
        },
        "genome": {
            "digest": genome.digest,
            "robot": genome.robot,
            "origin": str(genome.standing),
            "edited_from": genome.evolved.edited_from,
        }
        if genome
        else None,
        "programs": {
            program.chip: {
                "source": program.file,
                "source_digest": program.banner.source,
                "image": image_file,
                "image_digest": image.digest,
                "model": image.model.name,
                "slot": image.slot,
                "eeprom_free_bytes": memory.free_bytes,
                "ram_free_bytes": memory.ram_free_bytes,
                "gosub_depth": memory.gosub_depth,
                "blocks": flag_words(image),
            }
            for program, image_file, image, memory in compiled
        },
        "files": {name: digest(content) for name, content in sorted(files.items())},
        "templates": dict(firmware.templates),
        "tokenizer": {"version": TOKENIZER_VERSION, "sha256": TOKENIZER_SHA256},
    }


def flag_words(image: Image) -> list[str]:
    """Return what every 16-byte block holds: 128 words, the first for address 0.

    A digit a byte: 0 empty, 1 reserved by DATA, 2 DATA, 3 program; a `+` before them where the
    block is sent to the chip.
    """
    flags = image.known_flags()
    words = []
    for start in range(0, len(flags), BLOCK_BYTES):
        block = flags[start : start + BLOCK_BYTES]
        sent = "+" if block[0] & SENT else ""
        words.append(sent + "".join(str(flag & ~SENT) for flag in block))
    return words


def flags_of(blocks: Iterable[str]) -> bytes:
    """Return the flags that `flag_words` has written down.

    Raises:
        ValueError: a word is none of its.

    >>> flags_of(["+" + "3" * 16])[0], len(flags_of(["0" * 16] * 128))
    (131, 2048)
    """
    flags = bytearray()
    for word in blocks:
        digits = word.removeprefix("+")
        if len(digits) != BLOCK_BYTES:
            raise ValueError(f"{shown(word)} is not {BLOCK_BYTES} digits")
        sent = SENT if word.startswith("+") else 0
        flags += bytes(int(digit) | sent for digit in digits)
    return bytes(flags)


def read_record(folder: Path) -> dict[str, Any]:
    """Return the content of a build folder's `build.json`.

    Raises:
        FolderError: the folder is no build.
    """
    path = folder / RECORD_FILE
    try:
        content = inputs.read_bytes_if_there(path, inputs.BUILD_RECORD)
        record = None if content is None else parse_json(content)
    except ValueError as error:
        raise _no_build(folder, f"is broken: {error}") from error
    if record is None:
        raise _no_build(folder, "is missing")
    if not isinstance(record, dict) or record.get("format") != FORMAT:
        raise FolderError(
            f"{path}: is not of the format {FORMAT}; build the folder again with this version"
        )
    trouble = trouble_of(record)
    if trouble:
        raise FolderError(f"{path}: is damaged or edited ({trouble}); build the folder again")
    return record


def _no_build(folder: Path, why: str) -> FolderError:
    return FolderError(
        f"{folder}: is no build ({RECORD_FILE} {why}); give a folder that `cgagen build` has "
        "written"
    )


def read_image(folder: Path, chip_name: str) -> Image:
    """Return an image of a build folder with its model, slot and flags.

    Args:
        folder: a build.
        chip_name: "main" or "locomotion".

    Raises:
        FolderError: the folder is no build, or its image is not the one that was built.
    """
    record = read_record(folder)
    try:
        entry = record["programs"][chip_name]
        path = folder / entry["image"]
        eeprom = inputs.read_bytes(path, inputs.BUILD_FILE)
        image = Image(chip(entry["model"]), eeprom, flags_of(entry["blocks"]), entry["slot"])
        wanted = entry["image_digest"]
    except (KeyError, ValueError) as error:
        raise FolderError(
            f"{folder}: {RECORD_FILE} and the files do not fit ({error}); build it again"
        ) from error
    if image.digest != wanted:
        raise FolderError(
            f"{path}: its digest is not the one in {RECORD_FILE}; somebody has changed it, "
            "build it again"
        )
    return image
