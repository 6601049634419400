"""Traces: the file beside a trace, which says where it comes from."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from cgagen.errors import FolderError, TraceError
from hil.dbc import dbc_text
from hil.traces import Trace, read_trace, write_trace
from tests.trace_cases import PREDATOR, PREY, predator, some


@pytest.fixture
def stored(tmp_path: Path) -> Path:
    path = tmp_path / "a.log"
    write_trace(path, some(predator()), PREDATOR)
    return path


def edit(path: Path, change: Callable[[dict[str, Any]], Any]) -> None:
    row = json.loads(path.read_text())
    change(row)
    path.write_text(json.dumps(row))


SIDECARS: dict[str, tuple[Callable[[dict[str, Any]], Any], str]] = {
    "trace": (lambda r: r.update(trace="00"), "a.log: its content is not what .*a.log.json was"),
    "dbc": (lambda r: r.update(dbc="00"), "a.log: .*a.log.json says that it was recorded by anot"),
    "tick": (lambda r: r.update(tick_ns=100), "a.log.json: tick_ns: is 100"),
    "role": (lambda r: r["robot"].update(role="prey"), "a prey, and servobot-predator is a pred"),
    "robot": (
        lambda r: r["robot"].update(digest="ab" * 32),
        "a.log.json: robot: .* digest abababab",
    ),
    "format": (lambda r: r.update(format="x"), "a.log.json: format: is not cgagen-trace-1"),
    "missing": (lambda r: r.pop("images"), "a.log.json: images: is missing"),
    "kind": (lambda r: r.update(readings="6"), "a.log.json: readings: is missing, or of another"),
    "bool": (lambda r: r.update(seed=True), "a.log.json: seed"),
    "image": (lambda r: r.update(images={"main": 1}), "a.log.json: robot"),
    "target": (lambda r: r.update(target="oracle"), "a.log.json: target"),
    "role word": (lambda r: r["robot"].update(role="cat"), "a.log.json: robot"),
}


@pytest.mark.parametrize("case", SIDECARS)
def test_a_sidecar_that_does_not_fit_is_refused(stored: Path, case: str) -> None:
    change, message = SIDECARS[case]
    edit(stored.with_name("a.log.json"), change)
    with pytest.raises(TraceError, match=message):
        read_trace(stored, PREDATOR)


def test_a_changed_trace_and_another_dbc_are_refused(stored: Path) -> None:
    dbc = stored.with_name("rig.dbc")
    assert dbc.read_text() == dbc_text()
    dbc.write_text(dbc_text().replace("(0.05,0)", "(0.1,0)"))
    with pytest.raises(TraceError, match=r"a\.log: the rig\.dbc beside it is not this rig's"):
        read_trace(stored, PREDATOR)
    dbc.unlink()
    read_trace(stored, PREDATOR)
    stored.write_text("".join(stored.read_text().splitlines(keepends=True)[:-5]))
    with pytest.raises(TraceError, match="its content is not what"):
        read_trace(stored, PREDATOR)
    stored.with_name("a.log.json").write_text("{")
    with pytest.raises(TraceError, match=r"a\.log\.json: is no JSON \(line 1"):
        read_trace(stored, PREDATOR)


def test_a_trace_is_of_one_robot(stored: Path) -> None:
    with pytest.raises(TraceError, match="a predator, and servobot-prey is a prey"):
        read_trace(stored, PREY)
    stored.with_name("a.log.json").unlink()
    with pytest.raises(TraceError, match="line 4: reading 1 has 3 sonars and 2 light sensors"):
        read_trace(stored, PREY)


def test_nothing_is_overwritten_without_a_word(stored: Path) -> None:
    before = stored.read_bytes()
    write_trace(stored, some(predator()), PREDATOR)
    with pytest.raises(FolderError, match=r"a\.log: is there already"):
        write_trace(stored, some(predator(), 3), PREDATOR)
    assert stored.read_bytes() == before
    write_trace(stored, some(predator(), 3), PREDATOR, force=True)
    assert len(read_trace(stored, PREDATOR).samples) == 3
    with pytest.raises(TraceError, match=r"as \.log or \.csv"):
        write_trace(stored.with_name("a.blf"), some(predator()), PREDATOR)
    with pytest.raises(TraceError, match="nothing tells where it comes from"):
        write_trace(stored, Trace("x", some(predator()).samples), PREDATOR)
