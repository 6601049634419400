"""Looking on while a chip runs: hooks, conditions, coverage."""

import pytest

from cgagen.emulator.chip import Chip, End
from cgagen.emulator.clock import Clock
from cgagen.errors import BenchError
from cgagen.tokenizer import Tokenizer
from tests.chip_programs import SECOND_NS, chip_of


def test_hooks_stop_where_they_are(tokenizer: Tokenizer) -> None:
    head = "' {$STAMP BS2}\n' {$PBASIC 2.5}\n"
    compiled = tokenizer.compile(head + "w VAR Word\nagain: w = w + 1\nPAUSE 5\nGOTO again\n")
    made = Chip("chip", [compiled], Clock())
    seen: list[int] = []

    def look(chip: Chip) -> None:
        assert chip.local_ns == chip.clock.now_ns
        seen.append(chip.registers["W0"])
        if len(seen) == 4:
            chip.clock.stop()

    remove = made.on_line(5, look)
    made.run(SECOND_NS)
    assert (seen, made.registers["W0"], made.clock.stopped) == ([1, 2, 3, 4], 4, True)
    made.run(made.clock.now_ns + 20_000_000)
    assert seen == [1, 2, 3, 4, 5, 6, 7]
    remove()
    made.run(SECOND_NS)
    assert len(seen) == 7
    with pytest.raises(BenchError, match="line 1"):
        made.on_line(1, look)


def test_hooks_on_addresses_labels_and_pins(tokenizer: Tokenizer) -> None:
    """Led goes on and off twice; each hook sees its own moments, and none after its end."""
    head = "' {$STAMP BS2}\n' {$PBASIC 2.5}\n"
    source = "Led PIN 3\nn VAR Byte\nagain:\nn = n + 1\nHIGH Led\nLOW Led\nIF n < 4 THEN again\n"
    compiled = tokenizer.compile(head + source + "STOP\n")
    made = Chip("chip", [compiled], Clock())
    bits = {one.line: one.bit for one in compiled.source_map.statements}
    at_address, at_label, at_pin, each = [], [], [], []
    ends = [
        made.on_address(bits[7], lambda chip: at_address.append((chip.ram["n"], chip.pc))),
        made.on_label("Again", lambda chip: at_label.append(chip.ram["n"])),
        made.on_pin("led", at_pin.append),
        made.on_instruction(lambda chip: each.append(chip.pc)),
    ]
    assert made.run_until(lambda: made.ram["n"] == 3, SECOND_NS)
    assert at_address == [(1, bits[7]), (2, bits[7]), (3, bits[7])]
    assert at_label == [0, 1, 2]
    assert at_pin == [1, 0, 1, 0]
    assert len(each) == made.instructions + 1
    for end in ends:
        end()
    made.run(SECOND_NS)
    assert made.ended is End.STOP
    assert (len(at_address), len(at_label), len(at_pin)) == (3, 3, 4)


def test_a_hook_that_fails_does_not_end_the_program(tokenizer: Tokenizer) -> None:
    made = chip_of(tokenizer, "w VAR Word\nw = w + 1\nPAUSE 1\nw = w + 1\nSTOP")

    def fail(chip: Chip) -> None:
        if chip.registers["W0"] == 1:
            raise LookupError("a class's own mistake")

    remove = made.on_instruction(fail)
    with pytest.raises(LookupError, match="own mistake"):
        made.run(SECOND_NS)
    remove()
    with pytest.raises(LookupError):
        made.run_until(lambda: bool({}["left"]), SECOND_NS)
    made.run(SECOND_NS)
    assert (made.ended, made.registers["W0"], made.instructions) == (End.STOP, 2, 4)


def test_run_until_looks_before_every_instruction(tokenizer: Tokenizer) -> None:
    made = chip_of(tokenizer, "w VAR Word\nDO\nw = w + 1\nLOOP")
    assert made.run_until(lambda: made.registers["W0"] == 100, 10 * SECOND_NS)
    assert made.registers["W0"] == 100
    assert made.local_ns == made.clock.now_ns
    assert not made.run_until(lambda: made.registers["W0"] == 99, made.clock.now_ns + SECOND_NS)


def test_coverage_counts_instructions_and_both_ways_of_an_if(tokenizer: Tokenizer) -> None:
    made = chip_of(tokenizer, "w VAR Word\nagain: w = w + 1\nIF w < 5 THEN again\nSTOP")
    coverage = made.cover()
    made.run(SECOND_NS)
    assert sorted(coverage.counts.values()) == [1, 5, 5]
    assert [*coverage.branches.values()] == [[1, 4]]
    assert made.instructions == sum(coverage.counts.values())
