"""PBASIC programs whose output is known from the documents: every byte that they send."""

import re
from pathlib import Path

import pytest

from cgagen.emulator.bench import Bench
from cgagen.emulator.bench_file import read_bench
from cgagen.emulator.conversation import Conversation
from cgagen.emulator.programs import bench_of_sources
from cgagen.emulator.session import Outcome, Why, run_session
from cgagen.stamp.chips import CHIPS
from cgagen.stamp.compiled import Compiled
from cgagen.stamp.decode import decode
from cgagen.stamp.opcodes import opcodes_of
from cgagen.tokenizer import Tokenizer
from tests.stamp_programs import FOLDER, StampProgram, programs, sources

PROGRAMS = programs()


@pytest.fixture(scope="module")
def compiled(tokenizer: Tokenizer) -> dict[str, Compiled]:
    """Every source, by file name."""
    return {path.name: tokenizer.compile(path.read_text(), path.name) for path in sources()}


def test_every_source_compiles(compiled: dict[str, Compiled]) -> None:
    assert len(PROGRAMS) >= 60
    assert {one.image.model.name for one in compiled.values()} == {row.name for row in CHIPS}


def test_every_instruction_of_every_chip_is_in_a_program(compiled: dict[str, Compiled]) -> None:
    met = {
        instruction.name
        for one in compiled.values()
        for instruction in decode(one.image.eeprom, one.image.model, one.image.flags).instructions
    }
    known = {opcode.name for row in CHIPS for opcode in opcodes_of(row).values()}
    assert known <= met, f"in no program: {', '.join(sorted(known - met))}"


def test_every_program_says_what_it_shows() -> None:
    for program in PROGRAMS:
        head = program.path.read_text().split("{$STAMP")[0]
        assert head.startswith("' Shows: "), program.name
    cited = [one for one in PROGRAMS if re.search(r"Ref: S\d", one.path.read_text())]
    assert len(cited) >= 100


@pytest.mark.parametrize("program", PROGRAMS, ids=lambda program: program.name)
def test_what_it_sends(program: StampProgram, compiled: dict[str, Compiled]) -> None:
    sent, outcome = run(program, compiled)
    assert sent == program.expected
    assert outcome.ended is program.ends, outcome


def run(program: StampProgram, compiled: dict[str, Compiled]) -> tuple[bytes, Outcome]:
    """Run a program on its bench, and return every byte that it sent."""
    bench = bench_of(program, compiled)
    chip, sent, left = bench.chip("main"), bytearray(), [program.typed]
    conversation = Conversation(bench, chip, sent.append, lambda _: left.pop() if left else None)
    outcome = run_session(bench, chip, conversation, program.limit_ns)
    assert outcome.why in (Why.END, Why.STOP, Why.TIME, Why.LOOP)
    return bytes(sent), outcome


def bench_of(program: StampProgram, compiled: dict[str, Compiled]) -> Bench:
    def already(path: Path) -> Compiled:
        return compiled[path.name]

    if program.bench is not None:
        return read_bench(program.bench, already)
    first = compiled[program.path.name]
    others = enumerate(first.project_files, 1)
    return bench_of_sources({0: first} | {slot: compiled[name] for slot, name in others})


def test_every_other_file_belongs_to_a_program(compiled: dict[str, Compiled]) -> None:
    benches = "".join(one.bench.read_text() for one in PROGRAMS if one.bench)
    slots = {name for one in compiled.values() for name in one.project_files}
    names = {one.name for one in PROGRAMS}
    for path in FOLDER.iterdir():
        used = path.stem in names or path.name in slots or f'"{path.name}"' in benches
        assert used or path.name == "README.md", path.name
