"""The bench that `cgagen emulate FILE` runs: from a source, an image or a bench file."""

from pathlib import Path

import click

from cgagen.emulator.bench import Bench
from cgagen.emulator.bench_file import read_bench
from cgagen.emulator.chip import Chip
from cgagen.emulator.parts.signal import Signal
from cgagen.emulator.pins import PINS
from cgagen.emulator.programs import MAIN, bench_of_image, bench_of_sources
from cgagen.emulator.wires import Strength
from cgagen.inputs import start_of
from cgagen.notations import small_number
from cgagen.stamp.chips import EEPROM_BYTES
from cgagen.stamp.chips import chip as chip_row
from cgagen.tokenizer import Tokenizer
from cgagen.tokenizer.project import ProjectSources
from cgagen.verbs.console import Console


def load_bench(console: Console, file: Path, model: str | None) -> Bench:
    """Set up what a file says.

    Args:
        console: for notes.
        file: a bench file, an image, or a PBASIC source.
        model: the chip's name; None where the file says it.

    Raises:
        SourceError: a source is refused.
        BenchError: a bench file says something that cannot be.
        ImageError: an image that is none, or for another model.
        UsageError: nothing tells the model, or the file says another one.
    """
    if file.suffix == ".toml":
        if model is not None:
            raise click.UsageError(f"{file} says its models itself; leave --model out")
        with Tokenizer(warn=console.note) as tokenizer:
            return read_bench(file, ProjectSources(tokenizer, console.note).compile)
    if _is_image(file):
        from cgagen.verbs.info_image import find_image

        found = find_image(console, file, model)
        return bench_of_image(found.image, found.compiled)
    return _bench_of_source(console, file, model)


def chip_of(bench: Bench, file: Path, name: str | None) -> Chip:
    """Return the chip whose port and end are meant: the named one, `main`, or the first.

    Raises:
        BenchError: there is none of that name.
        UsageError: the bench has no chip.
    """
    if name is not None:
        return bench.chip(name)
    if not bench.chips:
        raise click.UsageError(f"{file} has no chip; add one: [chip.main] with a source")
    return bench.chips.get(MAIN) or next(iter(bench.chips.values()))


def hold_pin(bench: Bench, chip: Chip, word: str) -> None:
    """Hold a pin through a resistor, as `--pin 3=1` or `--pin legs.P3=0` says.

    The program wins where it drives the pin itself.

    Raises:
        UsageError: the word says something else.
        BenchError: there is no such chip.
    """
    where, _, level = word.replace(" ", "").rpartition("=")
    owner, dot, pin = where.rpartition(".")
    number = small_number(pin.upper().removeprefix("P"))
    if number is None or number >= PINS or level not in {"0", "1"}:
        raise click.UsageError(f"--pin {word}: say which pin has which level, for example 3=1")
    name = (bench.chip(owner) if dot else chip).name
    end, part = f"{name}.P{number}", f"pin_{name}_P{number}"
    if part in bench.parts:
        raise click.UsageError(f"--pin {word}: {end} is held already; name each pin once")
    bench.connect(bench.wire_of(end) or part, end, f"{part}.output")
    wire = bench.end(f"{part}.output")
    bench.add_part(Signal(part, bench.clock, wire, int(level), strength=Strength.RESISTOR))


def _is_image(file: Path) -> bool:
    if file.suffix == ".bin":
        return True
    data = start_of(file, EEPROM_BYTES + 1)
    return data is not None and len(data) == EEPROM_BYTES and b"\0" in data


def _bench_of_source(console: Console, file: Path, model: str | None) -> Bench:
    with Tokenizer(warn=console.note) as tokenizer:
        compiled = ProjectSources(tokenizer, console.note).compile_all(file)
    said = compiled[0].image.model
    if model is not None and chip_row(model) != said:
        raise click.UsageError(
            f"{file} is for a {said.name}, as its $STAMP line says; change that line or --model"
        )
    return bench_of_sources(dict(enumerate(compiled)))
