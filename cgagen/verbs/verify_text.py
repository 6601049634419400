"""What `cgagen verify` prints: a table and a verdict, or the same as JSON."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hil.equivalence import Trial
    from hil.outcome import Report


def text_of(report: "Report", repeat: str) -> str:
    """Return the table, what is wrong, and the verdict in the last line."""
    from hil.outcome import finding_lines

    subject = report.subject
    widest = max(len(name) for name in report.trials)
    row = f"{{:<{max(widest + 2, 18)}}}{{:<10}}{{:>10}}{{:>8}}{{:>7}}{{:>10}}"
    heads = ("trial", "verdict", "decisions", "agreed", "stale", "left out")
    lines = [f"{subject.robot.name}: {subject.where}", "", row.format(*heads)]
    for name, trial in report.trials.items():
        agreed = sum(trial.agreed.values())
        cells = (trial.verdict, trial.decisions, agreed, trial.stale, trial.left_out)
        lines.append(row.format(name, *cells))
    reasons = [_told(name, trial.reason) for name, trial in report.trials.items() if trial.reason]
    lines += ["", *reasons] if reasons else []
    notes = [f"{name}: {trial.note}" for name, trial in report.trials.items() if trial.note]
    lines += ["", *notes] if notes else []
    if report.smallest is not None:
        lines += ["", *finding_lines(report.smallest, subject)]
    lines += [
        "",
        f"genome {subject.genome_digest}, robot {subject.robot.digest[:8]}, "
        + ", ".join(f"{name} {image.digest[:8]}" for name, image in subject.images.items())
        + f", level {report.level}, seed {report.seed}",
        f"again: {repeat}",
        str(report.verdict),
    ]
    return "\n".join(lines)


def _told(name: str, reason: str) -> str:
    """Return why a trial is not PASS; a target's sentence names it already.

    >>> _told("serial:/dev/x", "/dev/x: lost"), _told("can:a:b", "can:a:b: lost")
    ('/dev/x: lost', 'can:a:b: lost')
    >>> _told("legs", "/dev/x: lost"), _told("table", "state 8 is wrong")
    ('legs: /dev/x: lost', 'table: state 8 is wrong')
    """
    place = name.partition(":")[2] or name
    return reason if reason.startswith((f"{name}: ", f"{place}: ")) else f"{name}: {reason}"


def data_of(report: "Report", repeat: str) -> dict[str, Any]:
    """Return the same as JSON has it."""
    subject, small, shown = report.subject, report.smallest, report.evidence.data()
    return {
        "verdict": str(report.verdict),
        "robot": {"name": subject.robot.name, "digest": subject.robot.digest},
        "genome": subject.genome.digest if subject.genome else None,
        "origin": shown["origin"],
        "images": {name: image.digest for name, image in subject.images.items()},
        "level": str(report.level),
        "seed": report.seed,
        "trials": {name: _trial(trial) for name, trial in report.trials.items()},
        "proof": shown["proof"],
        "timing": shown["timing"],
        "smallest": {
            "reading": small.stimulus.text() if small.stimulus else None,
            "why": small.why,
            "expected": {"state": small.expected.state, "command": small.expected.command},
            "observed": {"state": small.observed.state, "command": small.observed.command}
            if small.observed
            else None,
            "lines": [line._asdict() for line in small.lines],
        }
        if small
        else None,
        "again": repeat,
    }


def _trial(trial: "Trial") -> dict[str, Any]:
    return {
        "target": trial.target,
        "verdict": str(trial.verdict),
        "reason": trial.reason,
        "tried": trial.tried,
        "agreed": trial.agreed,
        "stale": trial.stale,
        "left_out": trial.left_out,
        "note": trial.note,
    }
