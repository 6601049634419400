"""`cgagen compile`: any PBASIC source to the image of its chip."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cgagen.verbs.console import Console, with_console
from cgagen.verbs.environment import TOOLCHAIN
from cgagen.verbs.named_file import source_at
from cgagen.verbs.written import OUTPUT, check, in_folder

if TYPE_CHECKING:
    from cgagen.stamp.compiled import Compiled


@click.command("compile", epilog=TOOLCHAIN)
@click.argument("file", type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--output",
    type=OUTPUT,
    metavar="FILE.bin",
    help="Write the 2,048 bytes of the EEPROM image here.",
)
@click.option(
    "--map",
    "map_file",
    type=OUTPUT,
    metavar="FILE",
    help="Write the source map here: line, column and first bit of every statement.",
)
@click.option("--force", is_flag=True, help="Overwrite what is not an image or map of ours.")
@with_console
def compile_verb(
    console: Console, file: Path, output: Path | None, map_file: Path | None, force: bool
) -> None:
    """Compile a PBASIC source for the BS2, BS2e, BS2sx, BS2p or BS2pe that its $STAMP names.

    Prints what the program takes of its chip. A refused source is one sentence with file, line
    and column, exit code 6. With --json: image, packets, source map and all counts.
    """
    from cgagen.memory import report
    from cgagen.tokenizer import Tokenizer
    from cgagen.tokenizer.files import IMAGE, SOURCE_MAP, read_source, write_image, write_map

    file = source_at(file)
    output = in_folder(output, f"{file.stem}.bin") if output is not None else None
    map_file = in_folder(map_file, f"{file.stem}.map.csv") if map_file is not None else None
    named = ((output, IMAGE), (map_file, SOURCE_MAP))
    check([(path, kind) for path, kind in named if path is not None], [file], force)
    with Tokenizer(warn=console.note) as tokenizer:
        compiled = tokenizer.compile(read_source(file), str(file))
    sizes = report(compiled)
    if output is not None:
        write_image(output, compiled.image)
    if map_file is not None:
        write_map(map_file, compiled)
    for name in compiled.project_files:
        console.note(f"note: $STAMP names {name} for a further slot; compile it by itself")
    console.result(_data(compiled, sizes.to_json()), sizes.to_text().rstrip("\n"))


def _data(compiled: "Compiled", sizes: dict[str, Any]) -> dict[str, Any]:
    from cgagen.stamp.packets import packets_of

    return {
        "name": compiled.name,
        "model": compiled.image.model.name,
        "language": compiled.language,
        "port": compiled.port,
        "project_files": list(compiled.project_files),
        "digest": compiled.image.digest,
        "eeprom": compiled.image.eeprom.hex(),
        "flags": compiled.image.known_flags().hex(),
        "packets": [packet.hex() for packet in packets_of(compiled.image)],
        "start_bit": compiled.start_bit,
        "source_map": [statement._asdict() for statement in compiled.source_map.statements],
        "warnings": [warning._asdict() for warning in compiled.warnings],
        "variables": compiled.variables._asdict(),
        "memory": sizes,
    }
