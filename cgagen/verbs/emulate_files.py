"""What `cgagen emulate` writes besides the chip's output: waveforms, traces, coverage."""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import click

from cgagen.emulator.bench import Bench, chip_ends
from cgagen.emulator.chip import Chip, Coverage
from cgagen.emulator.coverage_report import LISTING_TITLE, cover_source, coverage_listing, lcov
from cgagen.emulator.recording import record_bench
from cgagen.emulator.trace import HEADER, trace
from cgagen.errors import FolderError
from cgagen.files import text_stream, write_text
from cgagen.stamp.image import Image

LISTING_SUFFIX = ".txt"


@contextmanager
def recorded(
    bench: Bench, chip: Chip, vcd: Path | None, trace_file: Path | None, coverage: Path | None
) -> Iterator[None]:
    """Write the files that are wanted while a block runs; they are whole when it ends.

    Args:
        bench: all of it goes into the waveform.
        chip: whose instructions are traced and covered.
        vcd: the waveform; None for none.
        trace_file: likewise.
        coverage: likewise; the listing goes beside it.

    Raises:
        StorageError: a file cannot be written.
    """
    counted = chip.cover() if coverage is not None else None
    with ExitStack() as stack:
        if vcd is not None:
            ends = [end for name in bench.chips for end in chip_ends(name)]
            stack.enter_context(record_bench(vcd, bench, [*bench.wires, *ends]))
        if trace_file is not None:
            file = stack.enter_context(text_stream(trace_file))
            stack.callback(
                trace(chip, file, _images(bench, chip), bench.programs.get(chip.name, {}))
            )
        yield
    if coverage is not None and counted is not None:
        write_coverage(bench, chip, coverage, counted)


def write_coverage(bench: Bench, chip: Chip, path: Path, counted: Coverage) -> None:
    """Write LCOV's tracefile, and the listing beside it."""
    programs = bench.programs[chip.name]
    sources = [cover_source(one, counted, slot) for slot, one in sorted(programs.items())]
    write_text(path, lcov(sources))
    write_text(listing_path(path), coverage_listing(sources))


def listing_path(coverage: Path) -> Path:
    """Return where the listing goes: `cover.info` has `cover.info.txt`."""
    return coverage.with_name(coverage.name + LISTING_SUFFIX)


def refuse_strangers(
    source: Path, vcd: Path | None, trace_file: Path | None, coverage: Path | None, force: bool
) -> None:
    """Refuse to write over a file that is none of these, or two of them to one place.

    Raises:
        FolderError: it is there, and is something else; or its folder is not there.
        UsageError: two files have one name.
    """
    listing = None if coverage is None else listing_path(coverage)
    titles = ((vcd, "$"), (trace_file, HEADER), (coverage, "TN:"), (listing, LISTING_TITLE))
    targets = [(path, title) for path, title in titles if path is not None]
    taken = {source.resolve()}
    for path, _ in targets:
        if path.resolve() in taken:
            raise click.UsageError(f"{path} is named twice; choose another name")
        taken.add(path.resolve())
    for path, title in targets:
        if not path.parent.is_dir():
            raise FolderError(f"{path}: there is no folder {path.parent}; make it, or name another")
        if not force and path.exists() and not _starts_with(path, title):
            raise FolderError(
                f"{path}: is there and is nothing that emulate has written; "
                "choose another name, or overwrite it with --force"
            )


def _images(bench: Bench, chip: Chip) -> dict[int, Image]:
    """Return what every slot holds now, with what is known of its bytes."""
    programs, model = bench.programs.get(chip.name, {}), chip.machine.model
    return {
        slot: programs[slot].image if slot in programs else Image(model, chip.eeprom(slot))
        for slot in range(model.slots)
        if slot in programs or any(chip.eeprom(slot))
    }


def _starts_with(path: Path, title: str) -> bool:
    try:
        with path.open("rb") as file:
            start = file.read(len(title))
    except OSError:
        return False
    return start in {b"", title.encode()}
