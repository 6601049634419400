"""`cgagen emulate`: any PBASIC program on an emulated chip, its DEBUG text on stdout."""

import re
from pathlib import Path
from typing import Any

import click

from cgagen.verbs.baud import BaudType
from cgagen.verbs.console import Console, with_console
from cgagen.verbs.environment import TOOLCHAIN
from cgagen.verbs.named_file import bench_at
from cgagen.verbs.words import Words
from cgagen.verbs.written import OUTPUT, in_folder

_UNITS_NS = {"us": 1_000, "ms": 1_000_000, "s": 1_000_000_000, "min": 60_000_000_000}


class TimeType(click.ParamType[int]):
    """A time of the chip: 2s, 500ms, 1.5s, 20us, 3min; seconds where no unit is named."""

    name = "TIME"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:
        """Return nanoseconds, or a usage error."""
        if isinstance(value, int):
            return value
        found = re.fullmatch(r"(\d{1,9}(?:\.\d{1,9})?)\s*(us|ms|s|min)?", str(value).strip())
        time_ns = round(float(found[1]) * _UNITS_NS[found[2] or "s"]) if found else 0
        if not time_ns:
            self.fail(f"{value!r} is no time; say for example 2s, 500ms or 3min", param, ctx)
        return time_ns


_PORT = "Serve the programming port instead: rfc2217:0, tcp:0, pty; of a bench CHIP=tcp:0."


@click.command("emulate", epilog=TOOLCHAIN)
@click.argument("file", metavar="[FILE|BUILD]", type=click.Path(path_type=Path), required=False)
@click.option("--model", metavar="MODEL", help="The chip of an image that does not say it.")
@click.option("--chip", "chip_name", metavar="NAME", help="Of a bench: whose text and end.")
@click.option("--for", "limit_ns", type=TimeType(), help="Stop after this time.  [default: 10s]")
@click.option("--until-end", is_flag=True, help="Run until END or STOP, however long.")
@click.option("--input", "text", metavar="TEXT", help="What a user types; - for stdin.")
@click.option("--baud", type=BaudType(), metavar="MODE", help="Of the terminal.  [default: 9600]")
@click.option("--pin", "pins", metavar="3=1", multiple=True, help="Hold a pin; repeatable.")
@click.option("--port", "ports", metavar="PLACE", multiple=True, help=_PORT)
@click.option(
    "--atn",
    type=Words(["direct", "capacitor"]),
    default="capacitor",
    help="With --port: what makes a reset of DTR.  [default: capacitor]",
)
@click.option("--vcd", type=OUTPUT, metavar="FILE", help="Write all wires as a waveform.")
@click.option("--trace", type=OUTPUT, metavar="FILE", help="Write every instruction as CSV.")
@click.option("--coverage", type=OUTPUT, metavar="FILE", help="Write LCOV, and FILE.txt to read.")
@click.option(
    "--durations",
    is_flag=False,
    flag_value="",
    metavar="[LABELS]",
    help="Say how long routines take: all, or A,B.  (behind FILE)",
)
@click.option("--json", "as_json", is_flag=True, help="One JSON result: text, pins, parts, faults.")
@click.option("--realtime", is_flag=True, help="As fast as the chip; input is not held back.")
@click.option("--echo", is_flag=True, help="Show input as the board's wiring echoes it.")
@click.option("--expect-end", is_flag=True, help="Exit code 9 if there is no END or STOP.")
@click.option("--force", is_flag=True, help="Write over files that are not emulate's.")
@with_console
def emulate_verb(console: Console, /, file: Path | None, **given: Any) -> int:
    """Run a PBASIC source, an EEPROM image or a bench file, or a BUILD's, on emulated chips.

    What the program sends with DEBUG comes on stdout: control codes rendered on a terminal, raw
    bytes otherwise. Pins that nothing drives read 0, which is said once for each.

    What it reads with DEBUGIN is --input, or stdin with --input -. A program alone reads stdin
    unasked, too, if that is a terminal, a pipe, or a file from its beginning (with --realtime a
    terminal): no more of it than the program takes, so a shell's loop keeps its list. A bench
    file's programs read it only if asked. Text waits until it is taken; the end of a line is CR.
    --baud 2400, or 2400-7E1, is for programs with other words than DEBUG's in SERIN and SEROUT 16.

    Exit code 0 at END or STOP and when the time is over.

    A bench file wires chips, parts and faults; what can be in it says: python -m pydoc
    cgagen.emulator.bench_file

    With --port, other programs talk to the chip as to a Stamp on a serial port: they load programs
    and see what DEBUG says. Without FILE it is an erased chip of that --model.
    """
    file = bench_at(file) if file is not None else None
    for name, suffix in (("vcd", ".vcd"), ("trace", ".csv"), ("coverage", ".info")):
        if given[name] is not None:
            given[name] = in_folder(given[name], (file.stem if file else "chip") + suffix)
    if given["ports"]:
        from cgagen.verbs.emulate_serve import serve_ports

        return serve_ports(console, file, given)
    if file is None:
        taken = "; --durations took it for labels, so put that behind FILE"
        raise click.UsageError(f"Missing argument 'FILE'{taken if given['durations'] else ''}.")
    from cgagen.verbs.emulate_bench import chip_of, hold_pin, load_bench
    from cgagen.verbs.emulate_files import check_files, recorded
    from cgagen.verbs.emulate_report import report
    from cgagen.verbs.emulate_run import EmulateRun

    outputs = (given["vcd"], given["trace"], given["coverage"])
    check_files(file, *outputs, given["force"])
    bench = load_bench(console, file, given["model"])
    chip = chip_of(bench, file, given["chip_name"])
    if given["coverage"] is not None and chip.name not in bench.programs:
        raise click.UsageError(f"--coverage wants the source of {chip.name}; {file} has only bytes")
    as_json = given["as_json"] or console.as_json
    run = EmulateRun(console, bench, chip, as_json, single=file.suffix != ".toml")
    if given["durations"] is not None:
        labels = map(str.strip, given["durations"].split(","))
        run.durations = chip.durations(*filter(None, labels))
    bench.on_floating = run.note_floating
    with recorded(bench, chip, *outputs):
        for word in given["pins"]:
            hold_pin(bench, chip, word)
        outcome = run.go(given)
    return report(run, file, outcome, given)
