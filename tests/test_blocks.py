"""Compiled blocks against the instruction-by-instruction chip; random images, levels and bytes."""

import random
from functools import partial
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cgagen.emulator.block_flow import EXIT, flow_from
from cgagen.emulator.blocks import block_text
from cgagen.emulator.chip import Chip
from cgagen.emulator.clock import Clock
from cgagen.emulator.routine import Routine
from cgagen.emulator.unknowns import CHOICES
from cgagen.emulator.wires import Strength, Wire
from cgagen.errors import CgagenError, SourceError
from cgagen.stamp.chips import CHIPS
from cgagen.stamp.chips import chip as model_of
from cgagen.stamp.image import Image
from cgagen.tokenizer import Tokenizer
from tests.chip_programs import SECOND_NS, chip_of
from tests.pbasic_random import RandomProgram

MODELS = [row.name for row in CHIPS]


def outcome(chip: Chip, until_ns: int) -> tuple[object, ...]:
    """Run a chip; return all that can be seen of it, and first what it refused to do."""
    refused = ""
    try:
        chip.run(until_ns)
    except CgagenError as error:
        refused = str(error)
    machine, registers = chip.machine, tuple(chip.registers.words)
    pins = (chip.pins.latch, chip.pins.directions, machine.pins is machine.aux_pins)
    place = (machine.pc, machine.slot, machine.store_slot, tuple(machine.gosubs))
    rest = (chip.local_ns, chip.ended, chip.instructions, chip.waiting, machine.polling)
    return refused, registers, pins, place, *rest, bytes(chip.scratch), machine.memory.images()


Change = tuple[int, int | None, int]
"""Of a wire: which pin, to what level, when."""


def noisy(chip: Chip, seed: int) -> list[Change]:
    """Put every pin on a wire that changes, behind a resistor, at times that the seed decides.

    Returns a list that is given every change of those wires.
    """
    noise = random.Random(seed)
    changes: list[Change] = []

    def note(pin: int, level: int | None) -> None:
        changes.append((pin, level, chip.clock.now_ns))

    for pin in range(17):
        wire = Wire(f"wire{pin}", pull=noise.randrange(2))
        chip.pins.connect(pin, wire)
        wire.listen(partial(note, pin))
        for _ in range(12 if pin % 3 == 0 else 0):
            level = noise.choice((0, 1, None))
            drive = partial(wire.drive, "noise", level, Strength.RESISTOR)
            chip.clock.at(noise.randrange(SECOND_NS), drive)
    return changes


@pytest.fixture(scope="module")
def random_images(tokenizer: Tokenizer) -> list[Image]:
    images = []
    for seed in range(5):
        for row in CHIPS:
            try:
                images.append(tokenizer.compile(RandomProgram(seed + 900, row).source()).image)
            except SourceError:  # "expression is too complex" now and then
                continue
    assert len(images) > 20
    return images


def test_compiled_or_not_makes_no_difference(random_images: list[Image]) -> None:
    for number, image in enumerate(random_images):
        states = []
        for compile_after in (None, 0, 3):
            chip = Chip("chip", [image], Clock(), compile_after=compile_after)
            changes = noisy(chip, number)
            states.append((outcome(chip, SECOND_NS), changes))
        assert states[0] == states[1] == states[2], f"image {number}"


def test_a_run_in_pieces_is_the_same_run(random_images: list[Image]) -> None:
    for number, image in enumerate(random_images[::3]):
        states = []
        for pieces in (1, 7, 400):
            chip = Chip("chip", [image], Clock())
            changes = noisy(chip, number)
            for piece in range(1, pieces + 1):
                state = outcome(chip, SECOND_NS * piece // pieces)
                if state[0]:
                    break
            states.append((state, changes))
        assert states[0] == states[1] == states[2], f"image {number}"


def test_a_snapshot_in_the_middle_of_anything(random_images: list[Image]) -> None:
    for number, image in enumerate(random_images[1::3]):
        chip = Chip("chip", [image], Clock())
        chip.pins.connect(16, Wire("SIN", pull=0))
        if outcome(chip, 7_654_321 * (number + 1))[0]:
            continue
        clock, state = chip.clock.state(), chip.snapshot()
        once = outcome(chip, SECOND_NS // 4)
        for _ in range(2):
            chip.clock.restore(clock)
            chip.restore(state)
            assert chip.snapshot() == state
            assert outcome(chip, SECOND_NS // 4) == once, f"image {number}"
        other = Chip("chip", [image], Clock())
        other.clock.restore(clock)
        other.restore(state)
        assert outcome(other, SECOND_NS // 4) == once, f"image {number}"


@pytest.mark.parametrize("model", MODELS)
@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 2**32), zeros=st.integers(0, 40))
def test_random_bytes_never_crash_and_never_hang(model: str, seed: int, zeros: int) -> None:
    """Bytes with more or fewer zeros in them; what is no program is refused in a sentence."""
    noise = random.Random(seed)
    body = bytes(0 if noise.randrange(64) < zeros else noise.randrange(256) for _ in range(2046))
    start = 14 % 8 << 11 | 14 // 8
    image = Image(model_of(model), body + (start << 2).to_bytes(2, "little"))
    chip = Chip("chip", [image], Clock(), compile_after=seed % 3)
    noisy(chip, seed)
    refused = outcome(chip, SECOND_NS // 10)[0]
    assert isinstance(refused, str)
    assert not refused or refused.startswith("chip: ")
    assert "\n" not in refused


def test_ways_that_come_together_are_written_once(tokenizer: Tokenizer) -> None:
    tests = "\n".join(f"IF w > {n} THEN w = w - {n} ELSE w = w + {n}" for n in range(12))
    chip = chip_of(tokenizer, f"w VAR Word\n{tests}\nSTOP")
    flow = flow_from(chip.pc, chip.step_at)
    text, _ = block_text(chip.pc, flow, CHOICES)
    assert len(text.split("\n")) < 12 * 8
    forks = [at for at, step in flow.steps.items() if step.instruction.name == "IF"]
    apart = [at for at in forks if flow.joins[at] == EXIT]
    assert len(forks) >= 10
    assert len(apart) <= 2  # where the block is cut off


def test_an_index_that_reaches_a_pin_leaves_the_block(tokenizer: Tokenizer) -> None:
    """The sixteenth word behind W0 is INS, and the next OUTS: both are the pins of then."""
    source = (
        "a VAR Word(2)\nn VAR Nib\nOUTPUT 3\n"
        "FOR n = 0 TO 14\na(1) = 0\nIF n < 13 THEN more\na(n) = 8\na(1) = a(n)\nmore:\nNEXT\nSTOP"
    )
    ends = []
    for compile_after in (None, 0):
        chip = chip_of(tokenizer, source, compile_after=compile_after)
        seen: list[int] = []
        chip.on_pin(3, lambda level, c=chip, s=seen: s.append((level, c.clock.now_ns)))
        chip.run(SECOND_NS)
        ends.append((outcome(chip, SECOND_NS), seen))
    assert ends[0] == ends[1]
    assert ends[0][1][-1][0] == 1


@pytest.mark.parametrize("compile_after", [None, 0])
def test_the_last_number_of_an_index_wraps_too(
    tokenizer: Tokenizer, compile_after: int | None
) -> None:
    """B11 is byte 17 of 32; 15 behind it comes byte 0, INL."""
    source = "n VAR Nib\nn = 15\nB2 = 9\nB3 = B11(n)\nB11(n) = 4\nn = 14\nB4 = B11(n)\nSTOP"
    chip = chip_of(tokenizer, source, compile_after=compile_after)
    chip.pins.connect(5, Wire("high", pull=1))
    chip.registers["B25"] = 77
    chip.run(SECOND_NS)
    assert [chip.registers[name] for name in ("B2", "B3", "B4")] == [9, 32, 77]


@pytest.mark.parametrize("compile_after", [None, 0])
def test_a_nibble_of_outs_is_driven_when_its_time_comes(
    tokenizer: Tokenizer, compile_after: int | None
) -> None:
    source = "n VAR Nib\nDIRB = 15\nDO\nn = n + 1\nOUTA = n\nOUTB = n\nOUTC = n\nLOOP"
    chip = chip_of(tokenizer, source, compile_after=compile_after)
    seen: list[tuple[int | None, int]] = []
    chip.on_pin(4, lambda level: seen.append((level, chip.clock.now_ns)))
    chip.run(SECOND_NS // 10)
    assert [level for level, _ in seen] == [n % 2 for n in range(len(seen))]
    times = [time for _, time in seen[1:]]
    assert len(seen) > 50
    assert len({later - sooner for sooner, later in pairwise(times)}) == 1


def test_a_routine_counts_what_it_carries_out(tokenizer: Tokenizer) -> None:
    source = (
        "w VAR Word\nn VAR Byte\nGOSUB sub\nSTOP\n"
        "sub: FOR n = 1 TO w\nIF n = 3 THEN past\nOUTL = n\npast:\nNEXT\nRETURN"
    )
    made = chip_of(tokenizer, source)
    assert made.run_until(lambda: bool(made.machine.gosubs), SECOND_NS)
    before = made.instructions
    made.registers["W0"] = 5
    stop = made.machine.memory.slots[0].header(1)
    routine = Routine(made, stop)
    took_ns = routine.call(routine.before)
    counted, words = routine.instructions, list(routine.words)
    other = chip_of(tokenizer, source, compile_after=None)
    other.run_until(lambda: bool(other.machine.gosubs), SECOND_NS)
    other.registers["W0"] = 5
    start_ns = other.local_ns
    assert other.run_until(lambda: other.pc == stop, SECOND_NS)
    assert (counted, took_ns) == (other.instructions - before, other.local_ns - start_ns)
    assert words == other.registers.words
