"""What `cgagen emulate` writes besides the chip's output: waveforms, traces, coverage."""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from cgagen.emulator.bench import Bench, chip_ends
from cgagen.emulator.chip import Chip, Coverage
from cgagen.emulator.coverage_report import (
    LISTING,
    TRACEFILE,
    cover_source,
    coverage_listing,
    lcov,
)
from cgagen.emulator.recording import record_bench
from cgagen.emulator.trace import HEADER, trace
from cgagen.emulator.vcd import WAVEFORM
from cgagen.files import text_stream, write_text
from cgagen.outputs import begins
from cgagen.places import place_of
from cgagen.stamp.image import Image
from cgagen.verbs.written import check

LISTING_SUFFIX = ".txt"

TRACE = begins("a trace of instructions", HEADER + "\n")


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
    listing = _listing_path(path)
    write_text(path, lcov(sources))
    if listing is not None:
        write_text(listing, coverage_listing(sources))


def _listing_path(coverage: Path) -> Path | None:
    """Return where the listing goes: `cover.info` has `cover.info.txt`, and a stream has none."""
    if place_of(coverage).is_stream:
        return None
    return coverage.with_name(coverage.name + LISTING_SUFFIX)


def check_files(
    source: Path | None,
    vcd: Path | None,
    trace_file: Path | None,
    coverage: Path | None,
    force: bool,
) -> None:
    """Refuse outputs that would cost something, before the run.

    Raises:
        CgagenError: see `cgagen.outputs.check_outputs`.
    """
    listing = _listing_path(coverage) if coverage is not None else None
    named = ((vcd, WAVEFORM), (trace_file, TRACE), (coverage, TRACEFILE), (listing, LISTING))
    outputs = [(path, kind) for path, kind in named if path is not None]
    check(outputs, [] if source is None else [source], force)


def _images(bench: Bench, chip: Chip) -> dict[int, Image]:
    """Return what every slot holds now, with what is known of its bytes."""
    programs, model = bench.programs.get(chip.name, {}), chip.machine.model
    return {
        slot: programs[slot].image if slot in programs else Image(model, chip.eeprom(slot))
        for slot in range(model.slots)
        if slot in programs or any(chip.eeprom(slot))
    }
