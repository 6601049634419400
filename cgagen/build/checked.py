"""A build's images, taken out of the folder only where everything about them still fits."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from cgagen.bench_protocol import banner_in
from cgagen.build.record import GENOME_FILE, ROBOT_FILE, read_image, read_record
from cgagen.errors import FolderError, ImageError
from cgagen.files import digest
from cgagen.genome import load
from cgagen.inputs import BUILD_FILE, read_bytes
from cgagen.stamp.image import Image

CHIPS = ("main", "locomotion")


def checked_images(folder: Path) -> dict[str, Image]:
    """Return the images of both chips.

    What is looked at: the images, the sources and the robot by their digests, the genome by the
    table that it holds (its comments may change), and what the images themselves say, at reset,
    of genome and source.

    Raises:
        FolderError: the folder is no build, or a file of it is not the one that was built.
        GenomeError: its genome is none.
        ImageError: an image of another length.
    """
    record = read_record(folder)
    images = {}
    for chip in CHIPS:
        try:
            images[chip] = read_image(folder, chip)
        except ImageError as error:
            name = record["programs"][chip]["image"]
            raise ImageError(f"{folder / name}: {error}") from error
    try:
        _check_files(folder, record)
        _check_genome(folder, record)
        for chip, image in images.items():
            _check_banner(folder, record, chip, image)
    except KeyError as error:
        raise FolderError(
            f"{folder}: build.json and the files do not fit ({error}); build it again"
        ) from error
    return images


def changed_files(folder: Path, record: Mapping[str, Any]) -> list[str]:
    """Return the names of files that are missing, or are not those that build.json speaks of."""
    names = record.get("files", {})
    return [
        name
        for name, wanted in sorted(names.items())
        if not (folder / name).is_file() or digest(read_bytes(folder / name, BUILD_FILE)) != wanted
    ]


def _check_files(folder: Path, record: Mapping[str, Any]) -> None:
    for name in (*(record["programs"][chip]["source"] for chip in CHIPS), ROBOT_FILE):
        if digest(read_bytes(folder / name, BUILD_FILE)) != record["files"][name]:
            raise FolderError(
                f"{folder / name}: is not what the images were made from; build the folder again, "
                "or put the file back"
            )


def _check_genome(folder: Path, record: Mapping[str, Any]) -> None:
    if record["genome"] is None:
        return
    found, wanted = load(folder / GENOME_FILE).digest, record["genome"]["digest"]
    if found != wanted:
        raise FolderError(
            f"{folder / GENOME_FILE}: its table has digest {found[:8]}, the images were built from "
            f"{wanted[:8]}; build the folder again"
        )


def _check_banner(folder: Path, record: Mapping[str, Any], chip: str, image: Image) -> None:
    """Compare what an image says of itself; one that says nothing has templates of the user's."""
    banner = banner_in(image.eeprom)
    if banner is None:
        return
    entry = record["programs"][chip]
    origin = record["genome"] or record["robot"]
    for what, said, wanted in (
        ("genome", banner.genome, origin["digest"]),
        ("source", banner.source, entry["source_digest"]),
    ):
        if not wanted.startswith(said):
            raise FolderError(
                f"{folder / entry['image']}: says of itself that its {what} is {said}, build.json "
                f"says {wanted[:8]}; build the folder again"
            )
