"""A chip's slots, scratch pad and EEPROM: RUN, STORE, READ, WRITE and PUT."""

from dataclasses import replace

import pytest

from cgagen.emulator.chip import Chip, End
from cgagen.emulator.clock import Clock
from cgagen.emulator.unknowns import CHOICES
from cgagen.errors import BenchError, ImageError
from cgagen.stamp.chips import chip
from cgagen.stamp.image import Image
from cgagen.tokenizer import Tokenizer
from tests.chip_programs import SECOND_NS, chip_of


def test_run_changes_the_slot_and_keeps_ram_and_pins(tokenizer: Tokenizer) -> None:
    made = chip_of(
        tokenizer,
        "w VAR Word\nw = w + 1\nHIGH 2\nPUT 9, 33\nRUN 1",
        "w VAR Word\nb VAR Byte\nw = w + 10\nGET 9, b\nIF w > 20 THEN done\nRUN 0\ndone: STOP",
        model="BS2p",
    )
    made.run(SECOND_NS)
    assert (made.ended, made.slot) == (End.STOP, 1)
    assert (made.registers["W0"], made.registers["B2"], made.pins.latch) == (22, 33, 4)


def test_run_forgets_gosubs_unless_it_is_chosen_otherwise(tokenizer: Tokenizer) -> None:
    """A RETURN in the new slot then starts that slot anew; otherwise it takes the slot's GOSUB."""
    sources = (
        "GOSUB away\nSTOP\naway: RUN 1",
        "w VAR Word\nw = w + 1\nIF w = 2 THEN done\nRETURN\n"
        "GOSUB there\nw = 9\ndone: STOP\nthere: RETURN",
    )
    for clears, left in ((True, 2), (False, 9)):
        choices = replace(CHOICES, run_clears_gosubs=clears)
        made = chip_of(tokenizer, *sources, model="BS2p", unknowns=choices)
        made.run(SECOND_NS)
        assert (made.ended, made.slot, made.registers["W0"]) == (End.STOP, 1, left)


@pytest.mark.parametrize(("slot", "runs"), [("1", 1), ("9", 1), ("15", 7), ("8", 0)])
def test_run_past_the_last_slot_wraps(tokenizer: Tokenizer, slot: str, runs: int) -> None:
    """Slot 7 is erased, and its zeros are an END."""
    sources = ("b VAR Byte\nb = b + 1\nIF b = 2 THEN done\nRUN %s\ndone: STOP", "STOP")
    made = chip_of(tokenizer, sources[0] % slot, sources[1], model="BS2pe")
    made.run(SECOND_NS)
    assert made.slot == runs
    assert made.ended is (End.END if runs == 7 else End.STOP)
    assert made.registers["B0"] == (2 if runs == 0 else 1)


def test_the_scratch_pad_shows_the_slots(tokenizer: Tokenizer) -> None:
    source = (
        "b VAR Byte(3)\nSTORE 5\nGET 127, b(0)\nPUT 127, 1\nGET 127, b(1)\n"
        "PUT 126, 300\nGET 126, b(2)"
    )
    made = chip_of(tokenizer, source, model="BS2p")
    made.run(SECOND_NS)
    assert [made.registers[f"B{n}"] for n in range(3)] == [0x50, 0x50, 44]
    small = chip_of(tokenizer, "RUN 1", "b VAR Byte\nPUT 63, 9\nGET 63, b", model="BS2sx")
    small.run(SECOND_NS)
    assert small.registers["B0"] == 1


def test_read_and_write_use_the_slot_that_store_chose(tokenizer: Tokenizer) -> None:
    made = chip_of(
        tokenizer,
        "b VAR Byte(2)\nSTORE 3\nWRITE 10, 77\nREAD 10, b(0)\nSTORE 0\nREAD 10, b(1)",
        model="BS2p",
    )
    made.run(SECOND_NS)
    assert (made.registers["B0"], made.registers["B1"]) == (77, 0)
    assert made.eeprom(3)[10] == 77


@pytest.mark.parametrize("compile_after", [None, 0])
def test_write_over_the_program_changes_the_program(
    tokenizer: Tokenizer, compile_after: int | None
) -> None:
    """The loop's `b = b + 4` becomes `b = b + 6` after three passes: one bit of the constant."""
    source = (
        "b VAR Byte\nc VAR Byte\n"
        "again: b = b + %d\nc = c + 1\nIF c = 3 THEN patch\nIF c = 5 THEN done\nGOTO again\n"
        "patch: %s\nGOTO again\ndone: STOP"
    )

    def image(step: int, patch: str) -> bytes:
        return chip_of(tokenizer, source % (step, patch)).eeprom()

    plain, other = image(5, "WRITE 2000, 100"), image(7, "WRITE 2000, 100")
    places = [n for n in range(2048) if plain[n] != other[n]]
    assert len(places) == 1
    patch = f"WRITE {places[0]}, {other[places[0]]}"
    # the write's own constants may be longer than those of the probe; they come behind
    made = chip_of(tokenizer, source % (5, patch), compile_after=compile_after)
    made.run(SECOND_NS)
    assert (made.ended, made.registers["B0"]) == (End.STOP, 3 * 5 + 2 * 7)


def test_put_never_reaches_what_shows_the_chip(tokenizer: Tokenizer) -> None:
    """Ref: S2 p. 92: 63 and 127 cannot be written; the bytes behind them stay what they were."""
    for model, last in (("BS2p", 127), ("BS2pe", 127), ("BS2sx", 63), ("BS2e", 63)):
        made = chip_of(tokenizer, f"PUT {last}, 255\nPUT {last - 1}, 7\nSTOP", model=model)
        made.run(SECOND_NS)
        assert made.scratch[last - 1] == 7
        assert not any(made.scratch[last:])


def test_a_chip_wants_one_image_for_each_slot(tokenizer: Tokenizer) -> None:
    one, other = Image(chip("BS2"), bytes(2048)), Image(chip("BS2p"), bytes(2048))
    for images in ([], [one, one], [one, other]):
        with pytest.raises(BenchError, match="one image for each program slot"):
            Chip("chip", images, Clock())
    with pytest.raises(ImageError):
        Image(chip("BS2"), bytes(2048), slot=1)
