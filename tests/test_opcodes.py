"""The tables of codes: unique, complete in their proofs, equal to what other tables say."""

import json
from pathlib import Path

import pytest

from cgagen.stamp.chips import CHIPS, Chip, chip
from cgagen.stamp.decode import decode
from cgagen.stamp.opcodes import OPCODES, OPERATORS, Opcode, opcodes_of
from cgagen.stamp.program import Instruction, Kind, Program
from cgagen.tokenizer import Tokenizer
from cgagen.tokenizer.files import read_source

HERE = Path(__file__).parent
VECTORS = {v["id"]: v for v in json.loads((HERE / "vectors" / "tokens.json").read_text())}


@pytest.fixture(scope="module")
def proofs(tokenizer: Tokenizer) -> dict[str, Program]:
    """The programs that the tables name, decoded."""
    programs = {}
    for proof in {row.proof for row in OPCODES} | {row.proof for row in OPERATORS}:
        known = proof in VECTORS
        source = VECTORS[proof]["source"] if known else read_source(HERE / proof)
        image = tokenizer.compile(source, proof).image
        programs[proof] = decode(image.eeprom, image.model, image.flags)
    return programs


def operator_codes(instruction: Instruction) -> set[int]:
    """Every operator in an instruction, the comparison of LOOKDOWN included."""
    expressions = [*instruction.operands, instruction.write or ()]
    for item in instruction.items:
        expressions += [*item.values, item.write or ()]
    codes = {
        token.value
        for expression in expressions
        for token in expression
        if token.kind is Kind.OPERATOR
    }
    return codes | ({instruction.comparison} if instruction.comparison else set())


@pytest.mark.parametrize("row", OPCODES, ids=lambda row: f"{row.name} {min(row.models)}")
def test_the_proof_of_an_opcode_contains_it(row: Opcode, proofs: dict[str, Program]) -> None:
    program = proofs[row.proof]
    assert program.model.name in row.models
    assert any(instruction.opcode is row for instruction in program.instructions)


def test_the_proof_of_an_operator_contains_it(proofs: dict[str, Program]) -> None:
    for row in OPERATORS:
        met = set().union(*map(operator_codes, proofs[row.proof].instructions))
        assert row.code in met, row


@pytest.mark.parametrize("model", CHIPS, ids=lambda model: model.name)
def test_codes_and_names_are_unique_on_a_chip(model: Chip) -> None:
    rows = [row for row in OPCODES if model.name in row.models]
    assert len(rows) == len({row.code for row in rows}) == len({row.name for row in rows})
    assert opcodes_of(model) == {row.code: row for row in rows}
    assert all(0 <= row.code < 64 for row in rows)


def test_how_many_instruction_codes_each_chip_has() -> None:
    counts = {model.name: len(opcodes_of(model)) for model in CHIPS}
    assert counts == {"BS2": 39, "BS2e": 42, "BS2sx": 42, "BS2p": 60, "BS2pe": 60}


def test_one_code_is_another_instruction_on_another_chip() -> None:
    names = [opcodes_of(chip(name))[0x1A].name for name in ("BS2", "BS2sx", "BS2p")]
    assert names == ["LET", "GET", "GET"]
    assert [opcodes_of(chip(name))[0x1D].name for name in ("BS2e", "BS2pe")] == ["LET", "MAINIO"]


def test_forms_of_an_instruction_differ_in_length() -> None:
    for row in OPCODES:
        assert len(set(row.operand_counts)) == len(row.forms)
        assert all(len(set(form)) == len(form) for form in row.forms)


def test_operators_fill_their_range() -> None:
    assert [row.code for row in OPERATORS] == list(range(0x20))
    assert [row.operands for row in OPERATORS] == [1] * 8 + [2] * 24
