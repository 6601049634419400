"""FIDELITY.md has a row for every token and every duration, and its numbers are the code's."""

import re
from dataclasses import fields
from pathlib import Path

import pytest

from cgagen.emulator import timing
from cgagen.emulator.timing import INSTRUCTIONS_PER_S, Timing, timing_of
from cgagen.emulator.unknowns import Unknowns
from cgagen.stamp.chips import CHIPS
from cgagen.stamp.opcodes import OPCODES, OPERATORS

TEXT = (Path(__file__).parent.parent / "FIDELITY.md").read_text("utf-8")
_CELL = re.compile(r"(?<!\\)\|")
BUSES = ("ONE_WIRE", "ONE_WIRE_FAST", "LCD", "X10")


def tables(section: str) -> list[list[dict[str, str]]]:
    """Return the tables of a section: rows, by the words above their columns."""
    body = TEXT.split(f"\n## {section}\n", 1)[1].split("\n## ", 1)[0]
    found: list[list[dict[str, str]]] = []
    head: list[str] = []
    for line in body.splitlines():
        cells = [cell.strip().replace("\\|", "|") for cell in _CELL.split(line)[1:-1]]
        if not cells:
            head = []
        elif not head:
            head = cells
            found.append([])
        elif set("".join(cells)) != {"-"}:
            assert len(cells) == len(head), line
            found[-1].append(dict(zip(head, cells, strict=True)))
    return found


def test_every_instruction_code_has_a_row() -> None:
    rows = tables("Every token")[0]
    known: dict[str, list[str]] = {}
    for opcode in OPCODES:
        codes = known.setdefault(opcode.name, [])
        if f"{opcode.code:02X}h" not in codes:
            codes.append(f"{opcode.code:02X}h")
    assert {row["token"].strip("`"): row["code"].split(", ") for row in rows} == known
    assert len(rows) == len(known)


def test_every_operator_has_a_row() -> None:
    rows = tables("Every token")[1]
    assert [(row["code"], row["operator"].strip("`"), row["operands"]) for row in rows] == [
        (f"{one.code:02X}h", one.symbol, str(one.operands)) for one in OPERATORS
    ]


def test_every_duration_has_a_row_with_its_numbers() -> None:
    rows = tables("Every duration")[0]
    assert [row["constant"].strip("`") for row in rows] == [one.name for one in fields(Timing)]
    for row in rows:
        for chip in CHIPS:
            value = getattr(timing_of(chip), row["constant"].strip("`"))
            assert row[chip.name] == f"{value:,}", row["constant"]


def test_every_duration_of_a_bus_has_a_row_with_its_number() -> None:
    rows = tables("Every duration")[1]
    wanted = {"ONE_WIRE_READ_LOW_NS": timing.ONE_WIRE_READ_LOW_NS}
    for bus in BUSES:
        row = getattr(timing, bus)
        wanted |= {f"{bus}.{name}": getattr(row, name) for name in row._fields}
    constants = {name for name in vars(timing) if name.isupper() and name[0] != "_"}
    assert constants == {*BUSES, "ONE_WIRE_READ_LOW_NS", "INSTRUCTIONS_PER_S", "MS", "US"}
    assert {row["constant"].strip("`"): row["value"] for row in rows} == {
        name: f"{value:,}" for name, value in wanted.items()
    }


def test_the_rates_of_the_models_are_the_code_s() -> None:
    rates = [f"{INSTRUCTIONS_PER_S[chip.name]:,}" for chip in CHIPS]
    assert f"({', '.join(rates[:-1])} and {rates[-1]};" in TEXT


@pytest.mark.parametrize("section", ["Every token", "Every duration"])
def test_every_row_says_where_from_and_how_sure(section: str) -> None:
    for table in tables(section):
        for row in table:
            assert re.search(r"\b(S\d+|choice|fit)\b", row["source"]), row
            assert re.match(r"high|medium|low", row["confidence"]), row
            assert row["compared with silicon"] == "no", row


def test_every_choice_is_named() -> None:
    assert [one.name for one in fields(Unknowns) if f"`{one.name}`" not in TEXT] == []


def test_sources_that_are_cited_exist() -> None:
    sources = (Path(__file__).parent.parent / "SOURCES.md").read_text("utf-8")
    known = set(re.findall(r"^\| (S\d+) \|", sources, re.M))
    assert set(re.findall(r"\bS\d+\b", TEXT)) <= known
