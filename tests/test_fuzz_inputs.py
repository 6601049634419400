"""A small sample of damaged files for every reader; `make fuzz-inputs` tries many more."""

import io
import random
import struct
import zlib
from pathlib import Path

import can
import pytest

from cgagen.errors import TraceError
from hil.traces import read_trace
from hil.traces.packed import trouble_of_blf
from tests.fuzz_inputs import fuzz
from tests.fuzz_mutations import CHANGES, mutated
from tests.fuzz_readers import READERS, Reader
from tests.trace_cases import messages, predator, some

COUNT = 25


@pytest.mark.parametrize("name", READERS)
def test_what_is_right_is_read(name: str, tmp_path: Path) -> None:
    """Otherwise nothing would be tried but the first look at a file."""
    read = READERS[name].prepare(tmp_path)
    for sample in READERS[name].samples():
        if name == "source" and b"$STAMP" not in sample.upper():
            continue
        read(sample)


@pytest.mark.parametrize("name", READERS)
def test_damaged_files_are_refused_in_a_sentence(name: str, tmp_path: Path) -> None:
    found = fuzz(READERS[name], COUNT, seed=7, folder=tmp_path)
    assert found.bugs == []
    assert sum(found.codes.values()) == COUNT
    assert set(found.codes) <= {0, 3, 6}


def test_a_reader_with_a_bug_is_found(tmp_path: Path) -> None:
    def broken(data: bytes) -> object:
        return data[7] // (data[7] - data[7])

    one = Reader("broken", lambda: [b"0123456789"], lambda _folder: broken)
    found = fuzz(one, 20, seed=1, folder=tmp_path)
    assert found.codes[1] == 20
    assert "ZeroDivisionError" in "".join(found.bugs) or "IndexError" in "".join(found.bugs)


def test_the_same_seed_gives_the_same_files() -> None:
    def files() -> list[bytes]:
        return [mutated(b"a = 1\nb = 2\n", random.Random(n), [b"other"]) for n in range(200)]

    assert files() == files()
    assert len(set(files())) > 100
    assert len(CHANGES) > 8


def test_lines_that_python_can_leaves_out_are_told(tmp_path: Path, capfd) -> None:
    """It writes them, raw, to the terminal, and goes on: readings would be lost without a word."""
    path = tmp_path / "a.trc"
    with can.Logger(path) as writer:
        for message in messages(some(predator()), 0.0, 0):
            writer.on_message_received(message)
    whole = len(read_trace(path, predator().robot).samples)
    lines = path.read_bytes().splitlines(keepends=True)
    lines[-3] = b"\x1b[31m nonsense\n"
    path.write_bytes(b"".join(lines))
    with pytest.raises(TraceError, match=r"python-can leaves a line out \(.*nonsense"):
        read_trace(path, predator().robot)
    assert whole > 1
    assert capfd.readouterr().err == ""


def test_a_blf_that_unpacks_to_too_much_is_not_unpacked(tmp_path: Path) -> None:
    packed = zlib.compress(bytes(200_000_000))
    body = struct.pack("<H6xL4x", 2, 200_000_000) + packed
    container = struct.pack("<4sHHLL", b"LOBJ", 16, 1, 16 + len(body), 10) + body
    buffer = io.BytesIO()
    head = struct.pack("<4sL", b"LOGG", 144) + bytes(136)
    buffer.write(head + container)
    assert trouble_of_blf(buffer.getvalue()) == "unpacks to more than 8,388,608 bytes"
    path = tmp_path / "a.blf"
    path.write_bytes(buffer.getvalue())
    with pytest.raises(TraceError, match="unpacks to more than"):
        read_trace(path, predator().robot)
