"""The same bytes twice, whatever the hash seed: everything that `emulate` and `info` put out."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent

CALL_ALL = """
import contextlib, io, json, sys
from pathlib import Path
from cgagen.cli import main

said = []
for words in json.loads(sys.argv[1]):
    out, err = io.TextIOWrapper(io.BytesIO(), "utf-8"), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main(words)
    out.flush()
    said.append([words, code, out.buffer.getvalue().decode("latin-1"), err.getvalue()])
files = {path.name: path.read_bytes().decode("latin-1") for path in sorted(Path().iterdir())}
json.dump({"said": said, "files": files}, sys.stdout)
"""
"""Calls the command line in a folder; prints all that was said, and the files that are there."""

FAULT = """
[fault.crackle]
kind = "noise"
end = "main.P4"
every_us = 3000
width_us = 20
"""

NEW = {".vcd", ".csv", ".info", ".txt", ".bin"}


def seen(folder: Path, hash_seed: str, calls: list[list[str]]) -> dict[str, object]:
    """Run the calls in a process of its own, in a folder that this call empties first."""
    for path in folder.iterdir():
        if path.name.startswith("new"):
            path.unlink()
    done = subprocess.run(
        [sys.executable, "-c", CALL_ALL, json.dumps(calls)],
        cwd=folder,
        env=os.environ | {"PYTHONHASHSEED": hash_seed, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=True,
        timeout=300,
        stdin=subprocess.DEVNULL,
    )
    found: dict[str, object] = json.loads(done.stdout)
    return found


def twice(folder: Path, calls: list[list[str]]) -> dict[str, object]:
    """Return what both processes agree on."""
    one, other = (seen(folder, seed, calls) for seed in ("1", "31337"))
    assert one == other
    return one


def outputs(name: str) -> list[str]:
    kinds = {"--vcd": "vcd", "--trace": "csv", "--coverage": "info"}
    return [word for option, kind in kinds.items() for word in (option, f"new_{name}.{kind}")]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for path in [*(ROOT / "tests" / "programs").iterdir(), *(ROOT / "firmware/predator").iterdir()]:
        (tmp_path / path.name).write_bytes(path.read_bytes())
    bench = tmp_path / "bench.toml"
    bench.write_text(bench.read_text() + FAULT)
    return tmp_path


def test_a_chip_says_the_same_twice(folder: Path) -> None:
    found = twice(
        folder,
        [
            ["compile", "collatz.bs2", "-o", "new.bin"],
            ["info", "new.bin", "--model", "BS2"],
            ["emulate", "collatz.bs2", *outputs("chip")],
            ["emulate", "random.bs2", "--json", "--durations"],
            ["emulate", "button_once.bs2", "--json"],
        ],
    )
    assert [one[1] for one in found["said"]] == [0] * 5  # type: ignore[attr-defined]
    files: dict[str, str] = found["files"]  # type: ignore[assignment]
    new = [name for name in files if name.startswith("new")]
    assert {Path(name).suffix for name in new} == NEW
    assert all(files[name] for name in new)


def test_a_bench_says_the_same_twice(folder: Path) -> None:
    found = twice(
        folder,
        [
            ["emulate", "bench.toml", "--for", "900ms", *outputs("robot")],
            ["emulate", "bench.toml", "--for", "700ms", "--json", "--durations"],
            ["emulate", "poll_run.toml", "--json"],
        ],
    )
    assert [one[1] for one in found["said"]] == [0] * 3  # type: ignore[attr-defined]
    files: dict[str, str] = found["files"]  # type: ignore[assignment]
    assert files["new_robot.vcd"].count("\n") > 1000
    assert files["new_robot.csv"].count("\n") > 150
