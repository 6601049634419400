"""What `cgagen emulate` says when a run is over."""

from pathlib import Path
from typing import Any

import click

from cgagen.emulator.durations import durations_text
from cgagen.emulator.parts.fault import Fault, fault_notes
from cgagen.emulator.pins import SIN
from cgagen.emulator.session import Outcome, Why
from cgagen.verbs.console import Console
from cgagen.verbs.emulate_run import EmulateRun

NOT_ENDED = 9
INTERRUPTED = 130


def report(run: EmulateRun, file: Path, outcome: Outcome | None, given: dict[str, Any]) -> int:
    """Say how a run ended; returns the exit code.

    Args:
        run: that is over.
        file: what ran.
        outcome: how it ended; None where the user stopped it.
        given: the options of the verb.
    """
    run.tell_mode()
    now_s = run.bench.clock.now_ns / 1e9
    waits = _waits(run) if outcome is None or not outcome.ended else None
    if run.as_json:
        Console(as_json=True).result(_data(run, file, outcome, waits), "")
    else:
        run.end_line()
        _tell_durations(run)
    notes = [
        *fault_notes(run.bench.parts_of(Fault)),
        *_other_rate(run),
        *([waits] if waits else []),
    ]
    if run.chip.ended is not None and not any(run.chip.eeprom(run.chip.slot)):
        notes.append(
            f"slot {run.chip.slot} of {run.chip.name} holds no program, and the chip has come to "
            "it: name its source in the $STAMP line, or in the bench file"
        )
    if outcome is not None and outcome.why is Why.TIME and given["limit_ns"] is None:
        notes.append(
            f"stopped after {now_s:g} s of the chip's time: --for 1min runs longer, "
            "--until-end goes on until END or STOP"
        )
    for note in notes:
        run.console.note(f"note: {note}")
    if outcome is None:
        click.echo(f"cgagen: stopped by Ctrl-C at {now_s:.3f} s", err=True)
        return INTERRUPTED
    if given["expect_end"] and not outcome.ended:
        click.echo(
            f"cgagen: {file}: no END or STOP in {now_s:g} s of the chip's time: "
            f"{_unended(run, outcome)}",
            err=True,
        )
        return NOT_ENDED
    return 0


def _data(
    run: EmulateRun, file: Path, outcome: Outcome | None, waits: str | None
) -> dict[str, Any]:
    """Return the one result of `--json`."""
    parts = {name: run.bench.parts[name].told() for name in run.parts}
    data: dict[str, Any] = {
        "file": str(file),
        "chip": run.chip.name,
        "model": run.chip.machine.model.name,
        "ended": "INTERRUPTED" if outcome is None else str(outcome.why),
        "time_ns": run.bench.clock.now_ns if outcome is None else outcome.time_ns,
        "instructions": run.chip.instructions,
        "output": run.sent.decode("latin-1"),
        "floating": run.bench.floated,
        "waits": waits,
        "warnings": [
            {"file": one.name, **warning._asdict()}
            for programs in run.bench.programs.values()
            for one in programs.values()
            for warning in one.warnings
        ],
        "baud": None if run.terminal is None else str(run.terminal.mode),
        "baud_fits": None if run.fits is None else str(run.fits),
        "parts": {name: told for name, told in parts.items() if told},
    }
    if run.durations is not None:
        data["durations"] = [row._asdict() for row in run.durations.rows()]
    return data


def _tell_durations(run: EmulateRun) -> None:
    rows = () if run.durations is None else run.durations.rows()
    if rows:
        click.echo(durations_text(rows), err=True)
    elif run.durations is not None:
        run.console.note(
            "note: no labelled routine has come to its end, so none was measured: a routine ends "
            "with RETURN, or where the program reaches a label again"
        )


def _waits(run: EmulateRun) -> str | None:
    """Return what the chip waits for without end, as a sentence."""
    waiting = run.chip.waiting
    if waiting is None or not run.chip.waits_for_ever:
        return None
    if waiting.pin == SIN:
        listened = None if run.terminal is None else run.terminal.listened
        what = "input that does not come (--input)" if listened is None else f"input at {listened}"
        return f"{run.where(run.chip)}: the program waits for {what}"
    return f"{run.where(run.chip)}: the program waits for P{waiting.pin} to become {waiting.level}"


def _other_rate(run: EmulateRun) -> list[str]:
    """Return what to say of input that no SERIN could read as it was typed."""
    terminal = run.terminal
    if terminal is None or terminal.listened is None or run.fits == terminal.listened:
        return []
    return [
        f"the program listens at {terminal.listened}, and what was typed came at {terminal.mode}: "
        f"--baud {terminal.listened} speaks to it"
    ]


def _unended(run: EmulateRun, outcome: Outcome) -> str:
    """Return why there was no end, and what to do."""
    if outcome.why is Why.LOOP:
        return f"it goes round in an empty loop at {run.where(run.chip)}; mend the program"
    if outcome.why is Why.WAITS:
        if run.terminal is not None and run.terminal.listened is not None:
            return f"it listens at another rate; give --baud {run.terminal.listened}"
        return "it waits for what does not come; wire it in a bench file, or give --input"
    return "give it more with --for, or mend the program"
