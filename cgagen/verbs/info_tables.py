"""What `cgagen info` says of tables, waveforms and records; and who describes which sort."""

import csv
import re
from collections import Counter
from collections.abc import Callable
from pathlib import Path

from cgagen.errors import StrangerError
from cgagen.inputs import CHECKPOINT, read_bytes
from cgagen.shell import command
from cgagen.verbs import info_papers as papers
from cgagen.verbs.info_sorts import Sort
from cgagen.verbs.info_told import Told, rows_of, text_of


def reports_csv(path: Path) -> Told:
    """Describe 2-fitness.csv and 2-training.csv."""
    rows = rows_of(path, 5)
    first, last = rows[0], rows[-1]
    on = {"2-fitness.csv": "the fixed", "2-training.csv": "its own random"}.get(path.name, "some")
    numbers = dict(zip(("mean", "best", "worst", "captured"), map(float, last[1:]), strict=True))
    lines = [
        f"{path.name}: a population on {on} starts, {len(rows)} generations from {first[0]} to "
        f"{last[0]}",
        "the last: mean {mean:.1f}, best {best:.1f}, worst {worst:.1f}, captured "
        "{captured:.0%}".format(**numbers),
    ]
    data = {"rows": len(rows), "first": first[0], "last": last[0], **numbers}
    return Told(lines, data)


def population(path: Path) -> Told:
    """Describe 2-population-gNNN.csv."""
    rows = rows_of(path, 5)
    fitness = [float(row[2]) for row in rows]
    at = max(range(len(rows)), key=fitness.__getitem__)
    distinct = len({row[4] for row in rows})
    lines = [
        f"{path.name}: a population of {len(rows)}, {distinct} of them different",
        f"the best on the fixed starts is individual {rows[at][0]} with {fitness[at]:.1f}, "
        f"captured {float(rows[at][3]):.0%}",
    ]
    return Told(
        lines,
        {"rows": len(rows), "different": distinct, "best": rows[at][0], "fitness": fitness[at]},
    )


def measurements(path: Path) -> Told:
    """Describe a table for `calibrate`."""
    rows = rows_of(path, None)
    counts = Counter(row[0] for row in rows if row)
    what = ", ".join(f"{name} {count}" for name, count in counts.items())
    lines = [
        f"{path.name}: {len(rows)} measurements ({what})",
        f"for {command('calibrate', path, '--robot')} NAME|FILE",
    ]
    return Told(lines, {"rows": len(rows), "of": dict(counts)})


def instructions(path: Path) -> Told:
    """Describe what `emulate --trace` has written."""
    rows = rows_of(path, 5)
    end_us = float(rows[-1][0])
    lines = [f"{path.name}: {len(rows)} instructions, the last at {end_us / 1000:.3f} ms"]
    return Told(lines, {"instructions": len(rows), "last_us": end_us})


def source_map(path: Path) -> Told:
    """Describe what `compile --map` has written."""
    rows = rows_of(path, 3)
    lines = [f"{path.name}: line, column and first bit of {len(rows)} statements"]
    return Told(lines, {"statements": len(rows)})


def waveform(path: Path) -> Told:
    """Describe a VCD."""
    text = text_of(path)
    signals = re.findall(r"^\$var \S+ \d+ \S+ (\S+)", text, re.MULTILINE)
    times = re.findall(r"^#(\d+)$", text, re.MULTILINE)
    scale = re.search(r"\$timescale\s+(\S+\s*\S+?)\s+\$end", text)
    last = int(times[-1][:30]) if times else 0
    end = f"{last / 1e6:g} ms" if scale and scale[1] == "1 ns" else f"{last} ticks"
    shown = ", ".join(signals[:4]) + (", ..." if len(signals) > 4 else "")
    lines = [f"{path.name}: a waveform of {len(signals)} signals ({shown}), up to {end}"]
    return Told(lines, {"signals": signals, "last": last})


def coverage(path: Path) -> Told:
    """Describe an LCOV tracefile."""
    text = text_of(path)
    files = re.findall(r"^SF:(.*)$", text, re.MULTILINE)
    found, hit = (
        sum(map(int, re.findall(rf"^{key}:(\d{{1,9}})$", text, re.MULTILINE)))
        for key in ("LF", "LH")
    )
    lines = [f"{path.name}: coverage of {', '.join(files) or 'nothing'}: {hit} of {found} lines"]
    return Told(lines, {"files": files, "lines": found, "hit": hit})


def listing(path: Path) -> Told:
    """Describe the listing beside it."""
    titles = re.findall(r"^(coverage of .*)$", text_of(path), re.MULTILINE)
    return Told([f"{path.name}: a listing, {titles[0]}", *titles[1:]], {"titles": titles})


def checkpoint(path: Path) -> Told:
    """Describe a run's state between two generations."""
    from cgagen.checkpoint import from_bytes

    state = from_bytes(read_bytes(path, CHECKPOINT), str(path))
    best = state.best
    lines = [
        f"{path.name}: trial {state.trial} after generation {state.completed}, population "
        f"{state.bits.shape[0]}"
    ]
    if best is not None:
        lines.append(
            f"the best so far: generation {best.generation}, fitness {best.fitness:.1f}, "
            f"{best.captured:.0%} captured"
        )
    data = {"trial": state.trial, "completed": state.completed, "run_digest": state.run_digest}
    return Told(lines, data)


def decisions(path: Path) -> Told:
    """Describe recorded decisions."""
    from hil.decisions import read_decisions

    found = list(read_decisions(path))
    states = {one.observation.state for one in found} - {None}
    lines = [f"{path.name}: {len(found)} decisions in {len(states)} states"]
    return Told(lines, {"decisions": len(found), "states": len(states)})


TABLES: dict[Sort, Callable[[Path], Told]] = {
    Sort.REPORTS: papers.reports,
    Sort.REPORTS_CSV: reports_csv,
    Sort.POPULATION: population,
    Sort.MEASUREMENTS: measurements,
    Sort.INSTRUCTIONS: instructions,
    Sort.SOURCE_MAP: source_map,
    Sort.WAVEFORM: waveform,
    Sort.COVERAGE: coverage,
    Sort.LISTING: listing,
    Sort.CHECKPOINT: checkpoint,
    Sort.DECISIONS: decisions,
    Sort.REPORT: papers.report,
    Sort.PAGE: papers.page,
    Sort.KILLS: papers.kills,
    Sort.SIDECAR: papers.sidecar,
    Sort.FRAMES: papers.frames,
    Sort.MEMORY: papers.memory,
    Sort.WIRING: papers.wiring,
    Sort.TEMPLATE: papers.template,
    Sort.BENCH: papers.bench,
    Sort.BUILD_RECORD: papers.build_record,
    Sort.RECORD: papers.run_record,
}


def describe(sort: Sort, path: Path) -> Told:
    """Return what is said of a file.

    Raises:
        StrangerError: it begins as one of ours and is not.
        CgagenError: of the file's own reader.
    """
    try:
        return TABLES[sort](path)
    except (KeyError, TypeError, ValueError, AttributeError, IndexError, csv.Error) as error:
        raise StrangerError(
            f"{path}: begins as {sort}, and is damaged ({str(error)[:80]}); write it again"
        ) from error
