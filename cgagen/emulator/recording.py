"""A bench recorded as a waveform, with the line of PBASIC that every chip is at.

::

    with record_bench(Path("hunt.vcd"), bench):
        bench.run(until_ns=5_000_000_000)
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

from cgagen.emulator.bench import Bench, chip_ends
from cgagen.emulator.chip import Chip
from cgagen.emulator.vcd import Waveform, waveform_file
from cgagen.stamp.compiled import Compiled


@contextmanager
def record_bench(
    path: Path, bench: Bench, wires: Sequence[str] | None = None, lines: bool = True
) -> Iterator[Waveform]:
    """Write what happens on a bench to a VCD file.

    Args:
        path: of the file; it takes its name at the end.
        bench: that runs inside the `with`.
        wires: names of wires, or of ends such as "main.P3"; None for all wires with a name and
            the programming ports.
        lines: also write `main.line` and the like, for chips whose source is known. Slower.

    Raises:
        BenchError: there is no such wire, or the bench went back in time.
        StorageError: the disk is full, read-only or gone.
    """
    names = _default_names(bench) if wires is None else wires
    programs = bench.programs if lines else {}
    numbers = {chip: f"{chip}.line" for chip, known in programs.items() if known}
    with (
        waveform_file(
            path, bench.clock, {name: bench.wire(name) for name in names}, list(numbers.values())
        ) as waveform,
        ExitStack() as stack,
    ):
        for chip, number in numbers.items():
            hook = _line_hook(waveform, number, programs[chip])
            stack.callback(bench.chip(chip).on_instruction(hook))
        yield waveform


def _line_hook(
    waveform: Waveform, number: str, programs: dict[int, Compiled]
) -> Callable[[Chip], None]:
    """Return what tells the waveform a chip's line; 0 where no source is known."""
    lines: dict[tuple[int, int], int] = {}

    def hook(chip: Chip) -> None:
        place = (chip.slot, chip.pc)
        line = lines.get(place)
        if line is None:
            program = programs.get(chip.slot)
            statement = program.source_map.at_bit(chip.pc) if program else None
            line = lines[place] = statement.line if statement else 0
        waveform.set(number, line)

    return hook


def _default_names(bench: Bench) -> list[str]:
    ports = [end for chip in bench.chips for end in chip_ends(chip)[-2:]]
    on_ports = {bench.wire_of(end) for end in ports}
    return [*(name for name in bench.wires if name not in on_ports), *ports]
