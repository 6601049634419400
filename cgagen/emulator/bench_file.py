"""Benches as data: a TOML file names chips, wires, parts and faults.

::

    format = "cgagen-bench-1"

    [chip.main]
    model = "BS2p"
    image = "main.bin"              # or source = "main.bsp", or both: the image runs then,
                                    # and the source says which line is which
    [wire.sonar]
    ends = ["main.P4", "front.signal"]

    [wire.step]
    ends = ["main.P3", "main.P5"]
    pull = "up"                     # or "down"

    [part.front]
    kind = "ping"
    distance_in = 40

    [fault.silence]
    kind = "no_echo"
    part = "front"
    from_ms = 1000

Every pin and every lead is on one wire at most. An image for another program slot is a
`[[chip.main.also]]` with `image` or `source` and `slot`; without any, the further sources that the
`$STAMP` line of a source names have slots 1 and up. `[chip.main.timing]` replaces durations
of `cgagen.emulator.timing`. Names of files ignore case, and a backslash parts
folders. A chip's ends are P0 to P15, SIN and SOUT. Times begin with the bench.

The kinds of parts, with their ends and their settings::

    ping       signal            distance_in or echo_us; without, nothing is heard, for
                                 silence_us (20000), up to drift_us (0) longer
    srf04      trigger echo      likewise: distance_in, echo_us; mode_grounded (false)
    air                          sonars (their names; they hear one another's bursts)
                                 late_in (inches at which walls send them back, too)
    whisker    signal            touched (false); a push-button to ground is the same
    photocell  signal            capacitor_uf; resistance_ohm or drain_us, without, it is dark
    servo      signal            centre_us (1500) us_per_deg (10) deg_per_s (300) angle_deg (0)
                                 mirrored (false)
    uart       transmit receive  baud (9600) inverted seven_even echo (false)
                                 send (a text) send_ms (0)
    probe      signal            limit_edges (100000)
    signal     output            level changes ([[ms, level], ...]; -1 lets go) resistor (false)

The kinds of faults; each comes at from_ms (0) and goes at until_ms (never)::

    no_echo    part              a sonar stays silent
    late_echo  part late_us      its echo begins later
    stuck_echo part echo_us      farther things are heard at echo_us (850)
    stuck      end level         a pin reads one level, and nothing comes out of it
    open       end               the wire is broken there
    short      wire level        to ground or to the supply
    bridge     wires             two of them touch
    noise      end every_us width_us seed (0)
    brown_out  chips             their supply breaks down; they start anew
"""

import re
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path

from cgagen.emulator.bench import Bench, chip_ends
from cgagen.emulator.bench_table import BenchTable
from cgagen.emulator.chip import Chip
from cgagen.emulator.fault_kinds import FAULTS, make_fault
from cgagen.emulator.part_kinds import PARTS
from cgagen.emulator.timing import Timing, timing_of
from cgagen.errors import BenchError, ContentionError, ImageError
from cgagen.inputs import BENCH, IMAGE, alike, read_bytes, read_text
from cgagen.stamp import chips
from cgagen.stamp.compiled import Compiled
from cgagen.stamp.image import Image

FORMAT = "cgagen-bench-1"

MODELS = tuple(row.name for row in chips.CHIPS)

PULLS = {"up": 1, "down": 0}

Compile = Callable[[Path], Compiled]
"""Turns a source into an image; `cgagen.tokenizer` has one. The emulator takes no sources."""

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


def read_bench(path: Path, compile_source: Compile | None = None) -> Bench:
    """Set a bench up as its file says.

    Args:
        path: of the file; images and sources are named from its folder.
        compile_source: called for every source, before any chip is made.

    Raises:
        BenchError: the file says something that cannot be: file, key and what is allowed.
        SourceError: a source is refused.
    """
    return parse_bench(read_text(path, BENCH), str(path), path.parent, compile_source)


def parse_bench(text: str, file: str, folder: Path, compile_source: Compile | None = None) -> Bench:
    """Set a bench up from the text of its file.

    Args:
        text: TOML.
        file: what the file is called in errors.
        folder: where images and sources are.
        compile_source: see `read_bench`.

    Raises:
        BenchError: see `read_bench`.
        SourceError: likewise.
    """
    top = BenchTable.parse(file, text)
    top.text("format", (FORMAT,))
    sections = {key: _section(top, key) for key in ("chip", "wire", "part", "fault")}
    top.done()
    _refuse_twins(sections["chip"], sections["part"], sections["fault"])
    bench = Bench()
    try:
        for name, table in sections["chip"].items():
            _put_chip(bench, name, table, folder, compile_source)
        kinds = {name: one.text("kind", tuple(PARTS)) for name, one in sections["part"].items()}
        for name, table in sections["wire"].items():
            _put_wire(bench, name, table, kinds)
        for name, table in sections["part"].items():
            _put_part(bench, name, table, kinds[name])
        for name, table in sections["fault"].items():
            bench.add_part(make_fault(bench, name, table.text("kind", tuple(FAULTS)), table))
            table.done()
    except ContentionError as error:
        raise ContentionError(f"{file}: [wire] {error}") from error
    return bench


def _section(top: BenchTable, key: str) -> dict[str, BenchTable]:
    """Return the tables [key.NAME], in the order of the file."""
    if not top.offers(key):
        return {}
    section = top.table(key)
    for name in section.keys():
        if not _NAME.fullmatch(name):
            raise section.error(name, "is no name; use letters, digits and _, no digit first")
    return {name: section.table(name) for name in section.keys()}


def _refuse_twins(*sections: dict[str, BenchTable]) -> None:
    seen: dict[str, BenchTable] = {}
    for section in sections:
        for name, table in section.items():
            if name in seen:
                raise BenchError(
                    f"{table.file}: [{table.path}] has the name of [{seen[name].path}]; "
                    "choose another"
                )
            seen[name] = table


# -- Chips ------------------------------------------------------------------------------------


def _put_chip(
    bench: Bench, name: str, table: BenchTable, folder: Path, compile_source: Compile | None
) -> None:
    model = table.text("model", MODELS) if table.offers("model") else None
    also = table.tables("also") if table.offers("also") else []
    programs = [_program(one, model, folder, compile_source) for one in (table, *also)]
    if compile_source is not None and not (also or table.offers("image")):
        programs += _further(table, folder, compile_source, *programs[0])
    images = [image for image, _ in programs]
    timing = _timing(table.table("timing"), images[0]) if table.offers("timing") else None
    table.done()
    try:
        chip = Chip(
            name,
            images,
            bench.clock,
            timing=timing,
            floated=lambda pin: bench.floats(f"{name}.P{pin}"),
        )
    except (BenchError, ImageError) as error:
        raise table.error("also" if also else "image", str(error)) from error
    bench.add_chip(chip)
    chip.programs.update({image.slot: compiled for image, compiled in programs if compiled})


def _program(
    table: BenchTable, model: str | None, folder: Path, compile_source: Compile | None
) -> tuple[Image, Compiled | None]:
    """Return one image, and what its source says where there is one."""
    slot = table.integer_or("slot", 0, 15, 0)
    has_image, compiled = table.offers("image"), None
    if table.offers("source") or not has_image:
        source = table.text("source")
        if compile_source is not None:
            compiled = compile_source(_file(folder, source))
        elif not has_image:
            raise table.error("source", f"{source} is no image; compile it, and name its image")
    if compiled is not None and model not in {None, compiled.image.model.name}:
        raise table.error(
            "model", f"{model}, but the source is for a {compiled.image.model.name}; agree on one"
        )
    try:
        if not has_image and compiled is not None:
            return replace(compiled.image, slot=slot), compiled
        image = _image(table, model, folder, slot)
    except ImageError as error:
        raise table.error("image" if has_image else "slot", str(error)) from error
    if compiled is not None and compiled.image.eeprom != image.eeprom:
        raise table.error("source", "compiles to other bytes than the image; build both again")
    return image, compiled


def _further(
    table: BenchTable, folder: Path, compile_source: Compile, image: Image, first: Compiled | None
) -> list[tuple[Image, Compiled | None]]:
    """Return the programs that the source in slot 0 names for those behind it."""
    if first is None or image.slot:
        return []
    home = _file(folder, table.text("source")).parent
    further = [compile_source(home / name) for name in first.project_files]
    return [(replace(one.image, slot=slot), one) for slot, one in enumerate(further, 1)]


def _image(table: BenchTable, model: str | None, folder: Path, slot: int) -> Image:
    file = table.text("image")
    if model is None:
        raise table.error("model", f"missing; bytes alone do not say it: {', '.join(MODELS)}")
    data = read_bytes(_file(folder, file), IMAGE)
    return Image(chips.chip(model), data, None, slot)


def _file(folder: Path, name: str) -> Path:
    """Return the file that a bench names; what is not there is refused where it is read."""
    return alike(folder / name) or folder / name


def _timing(table: BenchTable, image: Image) -> Timing:
    standard = timing_of(image.model)
    known = [one.name for one in fields(Timing) if isinstance(getattr(standard, one.name), int)]
    changed = {name: table.integer(name, 1, 1 << 40) for name in known if table.offers(name)}
    table.done()
    return replace(standard, **changed)


# -- Wires and parts --------------------------------------------------------------------------


def _put_wire(bench: Bench, name: str, table: BenchTable, kinds: dict[str, str]) -> None:
    wanted = "a list of ends, such as main.P3 or front.signal"
    ends = table.texts("ends", wanted)
    pull = PULLS[table.text("pull", tuple(PULLS))] if table.offers("pull") else None
    table.done()
    for end in ends:
        known = _ends_of(end.partition(".")[0], bench, kinds)
        if not known:
            owners = ", ".join([*bench.chips, *kinds]) or "none"
            raise table.error("ends", f"{end} leads nowhere; chips and parts are {owners}")
        if end not in known:
            raise table.error("ends", f"{end}: no such end; there are {', '.join(known)}")
        if bench.wire_of(end) is not None:
            raise table.error("ends", f"{end} is on the wire {bench.wire_of(end)} already")
        bench.connect(name, end, pull=pull)
    if not ends:
        raise table.error("ends", f"[] is not {wanted}")


def _ends_of(owner: str, bench: Bench, kinds: dict[str, str]) -> tuple[str, ...]:
    if owner in bench.chips:
        return chip_ends(owner)
    if owner in kinds:
        kind = PARTS[kinds[owner]]
        return tuple(f"{owner}.{lead}" for lead in kind.leads + kind.optional)
    return ()


def _put_part(bench: Bench, name: str, table: BenchTable, word: str) -> None:
    kind = PARTS[word]
    for lead in kind.leads:
        if bench.wire_of(f"{name}.{lead}") is None:
            raise table.error("kind", f"{word}, but {name}.{lead} is on no wire; connect it")
    leads = {
        lead: bench.end(f"{name}.{lead}")
        for lead in kind.leads + kind.optional
        if bench.wire_of(f"{name}.{lead}") is not None
    }
    bench.add_part(kind.make(bench, name, leads, table))
    table.done()
