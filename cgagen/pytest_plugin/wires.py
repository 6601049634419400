"""Targets on a wire: what they are called in a report, and the chips beside them."""

from dataclasses import replace
from typing import TYPE_CHECKING

import pytest

from cgagen.pytest_plugin.options import HilConfig
from cgagen.pytest_plugin.ours import load
from cgagen.pytest_plugin.session import SESSION

if TYPE_CHECKING:
    from hil.subject import Subject
    from hil.target import Target


def shown(url: str, named: tuple[str, ...]) -> str:
    """Return what a report calls a target: a port that a test has made is another every time.

    >>> shown("serial:socket://127.0.0.1:3333", ()), shown("can:slcan:/dev/pts/0", ())
    ('serial', 'can:slcan')
    >>> shown("serial:/dev/ttyUSB0", ("serial:/dev/ttyUSB0",)), shown("emulator:registers", ())
    ('serial:/dev/ttyUSB0', 'emulator:registers')
    """
    kind, _, rest = url.partition(":")
    if url in named or kind not in ("serial", "serial-reset", "can"):
        return url
    return f"can:{rest.partition(':')[0]}" if kind == "can" else kind


def note_left_open(
    request: pytest.FixtureRequest, subject: "Subject", target: "Target", wanted: HilConfig
) -> None:
    """Note the chips beside a wire that it does not show; with `--hil-require`, an error."""
    evidence = request.config.stash[SESSION].evidence(subject)
    beside = load("hil.beside")
    rows = dict(beside.left_open(target, wanted.targets, wanted.legs))
    if wanted.legs is not None and beside.LEGS not in evidence.beside:
        why = "no test has given hil_stimuli to hil_check, which has the legs walk"
        evidence.trial(beside.LEGS, load("hil.equivalence").not_tried(wanted.legs, why))
    for name, row in rows.items():
        reason = row.reason.replace("--legs", "--hil-legs").replace("--target", "--hil-target")
        evidence.trial(name, replace(row, reason=reason))
        if wanted.require:
            pytest.fail(f"{name}: {reason}", pytrace=False)
