"""Polling, and low power, where the program has turned to the auxiliary pins.

Ref: S2 p. 313 to 337 for polling, p. 93 for what the scratch pad shows of it, p. 129 for the
auxiliary pins: not led out on these chips, and pulled up inside.
"""

import pytest

from cgagen.emulator.chip import Chip, End
from cgagen.emulator.wires import Wire
from cgagen.tokenizer import Tokenizer
from tests.chip_programs import SECOND_NS, chip_of

POLLED_RUN = (
    "POLLIN 0, 1\nPOLLRUN 1\nPOLLMODE %d\nDO\nPAUSE 1\nLOOP",
    "w VAR Word\nw = w + 1\nw = w + 1\nSTOP",
)


@pytest.mark.parametrize("mode", [3, 4])
def test_hooks_see_the_first_instruction_of_a_slot_that_polling_runs(
    tokenizer: Tokenizer, mode: int
) -> None:
    made = chip_of(tokenizer, POLLED_RUN[0] % mode, POLLED_RUN[1], model="BS2p")
    key, each, first = Wire("key", pull=0), list[tuple[int, int]](), list[int]()
    made.pins.connect(0, key)
    start = made.machine.memory.slots[1].header(0)
    made.on_instruction(lambda chip: each.append((chip.slot, chip.pc)))
    made.on_address(start, lambda chip: first.append(chip.local_ns - chip.clock.now_ns), slot=1)
    made.run(5_000_000)
    key.drive("hand", 1)
    made.run(SECOND_NS)
    assert (made.ended, made.registers["W0"]) == (End.STOP, 2)
    assert first == [0]
    assert each.count((1, start)) == 1
    assert len(each) == made.instructions


def test_polling_looks_at_the_pins_that_were_chosen_when_it_was_told(
    tokenizer: Tokenizer,
) -> None:
    """P0 of the main port has its level, P0 of the auxiliary one has not, and the other way."""
    source = (
        "b VAR Byte(4)\nn VAR Nib\nPOLLIN 0, 1\nPOLLIN 1, 0\nPOLLOUT 2, 1\nAUXIO\n"
        "POLLIN 0, 0\nPOLLIN 9, 1\nPOLLOUT 3, 1\nMAINIO\nPOLLMODE 2\nPAUSE 1\n"
        "FOR n = 0 TO 3\nGET 128 + n, b(n)\nNEXT\nSTOP"
    )
    made = chip_of(tokenizer, source, model="BS2p")
    for pin in (0, 1):
        made.pins.connect(pin, Wire(f"main{pin}", pull=1))
    made.run(SECOND_NS)
    assert [made.registers[f"B{n}"] for n in range(4)] == [1, 0, 0, 2]
    assert (made.pins.latch, made.pins.directions) == (4, 4)
    aux = made.machine.aux_pins
    assert (aux.latch, aux.directions) == (8, 8)


def test_pollmode_forgets_what_has_been_triggered(tokenizer: Tokenizer) -> None:
    """S2 p. 93, bits 4 to 6 of 135: a pin that is low again has left its mark until POLLMODE."""
    source = (
        "b VAR Byte(4)\nPOLLIN 0, 1\nPOLLOUT 1, 1\nPOLLMODE 10\nPAUSE 10\nGET 128, b(0)\n"
        "GET 135, b(1)\nPOLLMODE 10\nGET 128, b(2)\nGET 135, b(3)\nSTOP"
    )
    made = chip_of(tokenizer, source, model="BS2p")
    key = Wire("key", pull=1)
    made.pins.connect(0, key)
    made.run(5_000_000)
    key.drive("hand", 0)
    made.run(SECOND_NS)
    seen, flags, after, flags_after = (made.registers[f"B{n}"] for n in range(4))
    assert (seen, after) == (1, 0)
    assert (flags & 0b1110_0000, flags_after & 0b1110_0000) == (0b1110_0000, 0b1000_0000)


def test_pollwait_waits_for_an_auxiliary_pin(tokenizer: Tokenizer) -> None:
    """It is high for ever: the first look is enough."""
    source = "AUXIO\nPOLLIN 5, 1\nMAINIO\nPOLLMODE 2\nPOLLWAIT 8\nSTOP"
    made = chip_of(tokenizer, source, model="BS2pe")
    made.pins.connect(5, Wire("low", pull=0))
    made.run(SECOND_NS)
    assert made.ended is End.STOP


@pytest.mark.parametrize(
    "sleep", ["END", "NAP 6", "SLEEP 1", "POLLIN 1, 1\nPOLLMODE 2\nPOLLWAIT 6"]
)
def test_a_wake_up_lets_go_of_all_pins(tokenizer: Tokenizer, sleep: str) -> None:
    """S2 p. 187, 286: all I/O pins are inputs for about 18 ms, those that are not chosen, too."""
    made = chip_of(tokenizer, f"HIGH 0\nAUXIO\n{sleep}\n", model="BS2p")
    wire, seen = Wire("led", pull=0), list[tuple[int | None, int]]()
    made.pins.connect(0, wire)
    made.on_pin(0, lambda level: seen.append((level, made.clock.now_ns)))
    made.run(3 * SECOND_NS)
    assert [level for level, _ in seen[:3]] == [1, 0, 1]
    assert seen[2][1] - seen[1][1] == 18_000_000
    assert (made.pins.directions, made.machine.aux_pins.directions) == (1, 0)


def test_a_snapshot_in_a_wake_up_has_both_ports(tokenizer: Tokenizer) -> None:
    """Main P0 and auxiliary P1 are outputs; polled P2 rises between two looks."""
    source = "HIGH 0\nPOLLIN 2, 1\nPOLLMODE 2\nAUXIO\nHIGH 1\nPOLLWAIT 4\nINPUT 1\nMAINIO\nSTOP"

    def run_on(chip: Chip) -> tuple[object, ...]:
        chip.run(4 * SECOND_NS)
        groups = [(pins.latch, pins.directions) for pins in chip.machine.groups]
        levels = [pins.wires[n].level for n, pins in enumerate(chip.machine.groups)]
        return chip.ended, chip.local_ns, groups, levels

    made = chip_of(tokenizer, source, model="BS2p")
    key = Wire("key", pull=0)
    made.pins.connect(2, key)
    for _ in range(100):  # up to the middle of a wake-up
        made.run(made.clock.now_ns + 5_000_000)
        if not made.pins.directions and made.clock.now_ns > SECOND_NS // 10:
            break
    assert [pins.directions for pins in made.machine.groups] == [0, 0]
    key.drive("hand", 1)
    clock, state = made.clock.state(), made.snapshot()
    once = run_on(made)
    assert once[0] is End.STOP
    made.clock.restore(clock)
    made.restore(state)
    assert made.snapshot() == state
    assert run_on(made) == once


def test_the_programming_port_is_on_its_wire_with_auxiliary_pins_too(
    tokenizer: Tokenizer,
) -> None:
    """AUXIO changes the sixteen pins and nothing else (S2 p. 129)."""
    made = chip_of(
        tokenizer, "b VAR Byte\nAUXIO\nSERIN 16, 240, 10, off, [b]\noff: STOP", model="BS2p"
    )
    made.pins.connect(16, Wire("line", pull=1))  # a space, so eight bits of 0: all read as 0
    made.registers["B0"] = 9
    made.run(5_000_000)
    assert (made.ended, made.registers["B0"]) == (End.STOP, 0)
