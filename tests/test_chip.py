"""Programs whose end state follows from the documents, instruction by instruction and compiled."""

from dataclasses import replace

import pytest
from chip_programs import SECOND_NS, chip_of

from cgagen.emulator.chip import Chip, End
from cgagen.emulator.clock import Clock
from cgagen.emulator.pins import Pins
from cgagen.emulator.polling import Polling
from cgagen.emulator.unknowns import CHOICES
from cgagen.emulator.wires import Wire
from cgagen.errors import BenchError, ExecutionError, ImageError
from cgagen.stamp.chips import chip
from cgagen.stamp.image import Image
from cgagen.tokenizer import Tokenizer

BYTE, WORD, NIB = "b VAR Byte\n", "w VAR Word\n", "n VAR Nib\n"

CONFORMANCE = [
    # source, registers expected; words come first in the file, then bytes, then nibbles
    ("passes at least once", WORD + BYTE + "FOR w = 10 TO 10\nb = b + 1\nNEXT",
     {"B2": 1, "W0": 11}),
    ("down", WORD + BYTE + "FOR w = 3 TO 1\nb = b + 1\nNEXT", {"B2": 3, "W0": 0}),
    ("past 0", WORD + BYTE + "FOR w = 2 TO 0\nb = b + 1\nNEXT", {"B2": 3, "W0": 65535}),
    ("step", WORD + BYTE + "FOR w = 1 TO 10 STEP 4\nb = b + 1\nNEXT", {"B2": 3, "W0": 13}),
    ("step down", WORD + BYTE + "FOR w = 9 TO 1 STEP 4\nb = b + 1\nNEXT", {"B2": 3, "W0": 65533}),
    ("minus 1", WORD + BYTE + "FOR w = 5 TO 9 STEP -1\nb = b + 1\nNEXT", {"B2": 1, "W0": 4}),
    ("byte wraps out", BYTE + WORD + "FOR b = 10 TO 300\nw = w + 1\nNEXT", {"B2": 0, "W0": 246}),
    ("nibble", NIB + WORD + "FOR n = 0 TO 14\nw = w + 1\nNEXT", {"W0": 15, "B2": 15}),
    ("end moves", WORD + "e VAR Word\ne = 9\nFOR w = 1 TO e\ne = 4\nNEXT", {"W0": 5}),
    ("step moves", WORD + "e VAR Word\nFOR w = 1 TO 100 STEP e\ne = e + 1\nNEXT", {"W0": 106}),
    ("counter set", WORD + "FOR w = 1 TO 9\nw = 8\nIF w = 8 THEN done\nNEXT\ndone:", {"W0": 8}),
    ("left to right", WORD + "w = 2 + 3 * 4 - 6 / 7", {"W0": 2}),
    ("brackets", WORD + "w = 2 + (3 * (4 - (6 / 3)))", {"W0": 8}),
    ("cut to size", BYTE + NIB + "b = 259\nn = 18", {"B0": 3, "B1": 2}),
    ("negative", WORD + BYTE + "w = -5\nb = -5\nw = ABS w", {"W0": 5, "B2": 251}),
    ("array", "a VAR Byte(4)\n" + NIB + "FOR n = 0 TO 3\na(n) = n * n\nNEXT",
     {"B0": 0, "B1": 1, "B2": 4, "B3": 9}),
    ("array runs on", "a VAR Byte(2)\nc VAR Byte\na(2) = 7", {"B2": 7}),
    ("array wraps", "a VAR Byte(2)\n" + NIB + "a(28) = 9\nn = OUTA", {"OUTS": 9, "B2": 9}),
    ("bits of a word", WORD + "w.LOWBIT(9) = 1\nw.NIB3 = 5", {"W0": 0x5200}),
    ("if and or", WORD + "w = 5\nIF w > 3 AND w < 5 OR NOT w = 6 THEN w = 77", {"W0": 77}),
    ("if a number", WORD + BYTE + "w = 2\nIF w THEN b = 1\nIF NOT w THEN b = b + 2", {"B2": 3}),
    ("unsigned", WORD + BYTE + "w = -1\nIF w > 5 THEN b = 1", {"B2": 1}),
    ("elseif", WORD + "w = 2\nIF w = 1 THEN\nw = 10\nELSEIF w = 2 THEN\nw = 20\nELSE\n"
     "w = 30\nENDIF",
     {"W0": 20}),
    ("select", WORD + BYTE + "w = 7\nSELECT w\nCASE < 5\nb = 1\nCASE 6 TO 8\nb = 2\n"
     "CASE ELSE\nb = 3\n"
     "ENDSELECT", {"B2": 2}),
    ("while", WORD + "DO WHILE w < 7\nw = w + 2\nLOOP", {"W0": 8}),
    ("until", WORD + "DO\nw = w + 1\nLOOP UNTIL w = 3", {"W0": 3}),
    ("exit", WORD + "DO\nw = w + 1\nIF w = 4 THEN EXIT\nLOOP", {"W0": 4}),
    ("branch", WORD + BYTE + "w = 1\nBRANCH w, [x, y]\nb = 1\nx: b = b + 10\ny: b = b + 100",
     {"B2": 100}),
    ("branch past", WORD + BYTE + "w = 2\nBRANCH w, [x, y]\nb = 1\nx: b = b + 10\ny: b = b + 100",
     {"B2": 111}),
    ("lookup", WORD + BYTE + "w = 2\nb = 9\nLOOKUP w, [5, 6, w + 5], b", {"B2": 7}),
    ("lookup past", WORD + BYTE + "w = 3\nb = 9\nLOOKUP w, [5, 6, 7], b", {"B2": 9}),
    ("lookdown", WORD + BYTE + "w = 6\nb = 9\nLOOKDOWN w, [5, 6, 6], b", {"B2": 1}),
    ("lookdown below", WORD + BYTE + "w = 6\nb = 9\nLOOKDOWN w, < [5, 6, 8], b", {"B2": 2}),
    ("lookdown none", WORD + BYTE + "w = 4\nb = 9\nLOOKDOWN w, [5, 6, 6], b", {"B2": 9}),
    ("gosub", WORD + "GOSUB x\nGOSUB x\nSTOP\nx: w = w + 1\nGOSUB y\nRETURN\ny: w = w + 10\nRETURN",
     {"W0": 22}),
    ("on gosub", WORD + BYTE + "b = 1\nON b GOSUB x, y\nw = w + 1\nb = 2\n"
     "ON b GOSUB x, y\nw = w + 1\n"
     "STOP\nx: w = w + 10\nRETURN\ny: w = w + 100\nRETURN", {"W0": 102}),
    ("data", WORD + BYTE + "t DATA 5, Word 1000, 7\nREAD t + 1, Word w\nREAD t + 3, b",
     {"W0": 1000, "B2": 7}),
    ("write", WORD + BYTE + "WRITE 3, 258, 9\nREAD 3, b\nREAD 4, w", {"B2": 2, "W0": 9}),
    ("write a word", WORD + BYTE + "WRITE 3, Word 259\nREAD 3, Word w\nREAD 2048 + 3, b",
     {"W0": 259, "B2": 3}),
    ("random repeats", WORD + "v VAR Word\nRANDOM w\nRANDOM v\nw = w - v", {"W0": 0}),
    ("pins", "HIGH 3\nLOW 4\nTOGGLE 3\nTOGGLE 5\nOUTPUT 6\nINPUT 4\nREVERSE 4\nREVERSE 6",
     {"OUTS": 0b100000, "DIRS": 0b111000}),
    ("pin name", "p PIN 5\n" + WORD + "p = 1\nOUTPUT p\nw = p + 1", {"OUT5": 1, "W0": 2}),
]  # fmt: skip


@pytest.mark.parametrize("compile_after", [None, 0])
@pytest.mark.parametrize(
    ("source", "expected"), [row[1:] for row in CONFORMANCE], ids=[row[0] for row in CONFORMANCE]
)
def test_conformance(
    tokenizer: Tokenizer, source: str, expected: dict[str, int], compile_after: int | None
) -> None:
    made = chip_of(tokenizer, source, compile_after=compile_after)
    made.run(SECOND_NS)
    assert made.ended in (End.END, End.STOP)
    assert {name: made.registers[name] for name in expected} == expected


@pytest.mark.parametrize(
    "source",
    [
        WORD + "FOR w = 0 TO 65535\nNEXT",
        WORD + "FOR w = 0 TO 65535 STEP 3000\nNEXT",
        BYTE + "FOR b = 0 TO 300\nNEXT",
    ],
)
def test_loops_that_never_end(tokenizer: Tokenizer, source: str) -> None:
    """Ref: S2 p. 193 to 196."""
    made = chip_of(tokenizer, source)
    made.run(60 * SECOND_NS)
    assert made.ended is None
    assert made.instructions > 50_000


def test_a_fifth_gosub_loses_the_first(tokenizer: Tokenizer) -> None:
    """Five deep; four returns come back, the fifth finds nothing and begins anew (S2 p. 210)."""
    source = (
        "w VAR Word\nb VAR Byte\n"
        "b = b + 1\nIF b = 2 THEN done\nGOSUB one\nw = w + 1\nSTOP\n"
        "one: GOSUB two\nw = w + 2\nRETURN\ntwo: GOSUB three\nw = w + 4\nRETURN\n"
        "three: GOSUB four\nw = w + 8\nRETURN\nfour: GOSUB five\nw = w + 16\nRETURN\n"
        "five: RETURN\ndone: STOP"
    )
    for compile_after in (None, 0):
        made = chip_of(tokenizer, source, compile_after=compile_after)
        made.run(SECOND_NS)
        assert made.registers["W0"] == 2 + 4 + 8 + 16
        assert made.registers["B2"] == 2


def test_return_with_nothing_to_return_to_keeps_the_variables(tokenizer: Tokenizer) -> None:
    made = chip_of(tokenizer, "w VAR Word\nw = w + 1\nIF w = 3 THEN done\nRETURN\ndone: STOP")
    made.run(SECOND_NS)
    assert (made.ended, made.registers["W0"]) == (End.STOP, 3)


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


def test_end_lets_go_of_the_pins_every_2_3_seconds(tokenizer: Tokenizer) -> None:
    made = chip_of(tokenizer, "HIGH 0\nEND")
    wire, seen = Wire("led", pull=0), []
    made.pins.connect(0, wire)
    made.on_pin(0, lambda level: seen.append((level, made.clock.now_ns)))
    made.run(5 * SECOND_NS)
    assert made.ended is End.END
    assert [level for level, _ in seen] == [1, 0, 1, 0, 1]
    times = [time for _, time in seen]
    assert times[2] - times[1] == 18_000_000
    assert times[3] - times[1] == 2_304_000_000
    assert made.registers["DIRS"] == 1


def test_stop_keeps_the_pins(tokenizer: Tokenizer) -> None:
    made = chip_of(tokenizer, "HIGH 0\nSTOP\nLOW 0")
    made.run(5 * SECOND_NS)
    assert (made.ended, made.pins.latch, made.pins.wires[0].level) == (End.STOP, 1, 1)


@pytest.mark.parametrize(
    ("down", "delay", "rate", "target", "level", "acts"),
    [
        (0, 3, 2, 1, 0, 0b1010_1001),
        (0, 3, 2, 0, 0, 0b0101_0110),
        (0, 0, 2, 1, 0, 0b1111_1111),
        (0, 255, 2, 1, 0, 0b0000_0001),
        (1, 3, 2, 1, 0, 0),
        (1, 3, 2, 0, 0, 0b1111_1111),
    ],
)
def test_button(
    tokenizer: Tokenizer, down: int, delay: int, rate: int, target: int, level: int, acts: int
) -> None:
    """Held: at once, after `delay` looks, then after each `rate` looks. Ref: S2 p. 138."""
    made = chip_of(
        tokenizer,
        "k VAR Byte\nn VAR Byte\nacts VAR Word\nFOR n = 0 TO 7\n"
        f"BUTTON 2, {down}, {delay}, {rate}, k, {target}, acted\nGOTO more\n"
        "acted: acts.LOWBIT(n) = 1\nmore:\nNEXT",
    )
    made.pins.connect(2, Wire("key", pull=level))
    made.run(SECOND_NS)
    assert made.registers["W0"] == acts


def test_button_makes_its_pin_an_input(tokenizer: Tokenizer) -> None:
    made = chip_of(
        tokenizer, "k VAR Byte\nDIRS = $FFFF\nBUTTON 2, 0, 255, 0, k, 1, done\ndone: STOP"
    )
    made.run(SECOND_NS)
    assert made.registers["DIRS"] == 0xFFFB


def test_put_never_reaches_what_shows_the_chip(tokenizer: Tokenizer) -> None:
    """Ref: S2 p. 92: 63 and 127 cannot be written; the bytes behind them stay what they were."""
    for model, last in (("BS2p", 127), ("BS2pe", 127), ("BS2sx", 63), ("BS2e", 63)):
        made = chip_of(tokenizer, f"PUT {last}, 255\nPUT {last - 1}, 7\nSTOP", model=model)
        made.run(SECOND_NS)
        assert made.scratch[last - 1] == 7
        assert not any(made.scratch[last:])


def test_polled_output_follows_its_input(tokenizer: Tokenizer) -> None:
    made = chip_of(
        tokenizer, "POLLIN 0, 0\nPOLLOUT 1, 1\nPOLLMODE 2\nDO\nPAUSE 10\nLOOP", model="BS2p"
    )
    key = Wire("key", pull=1)
    made.pins.connect(0, key)
    made.run(SECOND_NS // 10)
    assert made.pins.wires[1].level == 0
    key.drive("hand", 0)
    made.run(SECOND_NS // 5)
    assert made.pins.wires[1].level == 1
    key.drive("hand", None)
    made.run(SECOND_NS)
    assert made.pins.wires[1].level == 0


def test_polled_run_happens_once(tokenizer: Tokenizer) -> None:
    made = chip_of(
        tokenizer,
        "POLLIN 0, 1\nPOLLRUN 1\nPOLLMODE 3\nDO\nPAUSE 1\nLOOP",
        "w VAR Word\nDO\nw = w + 1\nLOOP",
        model="BS2p",
    )
    key = Wire("key", pull=0)
    made.pins.connect(0, key)
    made.run(SECOND_NS)
    assert made.slot == 0
    key.drive("hand", 1)
    made.run(2 * SECOND_NS)
    assert made.slot == 1
    assert made.registers["W0"] > 100


def test_pollwait_waits_for_its_input(tokenizer: Tokenizer) -> None:
    made = chip_of(tokenizer, "POLLIN 0, 1\nPOLLMODE 2\nPOLLWAIT 8\nHIGH 1\nSTOP", model="BS2p")
    key = Wire("key", pull=0)
    made.pins.connect(0, key)
    made.run(SECOND_NS)
    assert made.ended is None
    key.drive("hand", 1)
    made.run(SECOND_NS + 2_000_000)
    assert made.ended is End.STOP


def test_auxio_has_latches_without_pins(tokenizer: Tokenizer) -> None:
    made = chip_of(
        tokenizer, "w VAR Word\nAUXIO\nHIGH 3\nw = OUTS\nMAINIO\nHIGH 1\nSTOP", model="BS2p"
    )
    made.run(SECOND_NS)
    assert (made.registers["W0"], made.pins.latch, made.pins.directions) == (8, 2, 2)


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


def test_reset_begins_anew_but_for_the_eeprom(tokenizer: Tokenizer) -> None:
    made = chip_of(
        tokenizer, "w VAR Word\nREAD 0, w\nWRITE 0, w + 1\nHIGH 2\nPAUSE 100\nw = 99\nSTOP"
    )
    made.run(50_000_000)
    assert (made.pins.directions, made.eeprom()[0]) == (4, 1)
    made.reset(hold_ns=1_000_000)
    assert (made.pins.directions, made.pins.wires[2].level) == (0, None)
    made.run(made.clock.now_ns + 50_000_000)
    assert (made.registers["W0"], made.eeprom()[0]) == (1, 2)


def test_a_loop_that_does_nothing_is_the_end(tokenizer: Tokenizer) -> None:
    made = chip_of(tokenizer, "HIGH 1\nDO\nLOOP")
    made.run(SECOND_NS)
    assert made.ended is End.LOOP


def test_what_is_no_program_is_refused_with_its_place() -> None:
    image = Image(chip("BS2"), bytes(2046) + b"\xff\xff")
    with pytest.raises(ExecutionError, match="slot 0, stream bit"):
        Chip("chip", [image], Clock()).run(SECOND_NS)


def test_a_chip_wants_one_image_for_each_slot(tokenizer: Tokenizer) -> None:
    one, other = Image(chip("BS2"), bytes(2048)), Image(chip("BS2p"), bytes(2048))
    for images in ([], [one, one], [one, other]):
        with pytest.raises(BenchError, match="one image for each program slot"):
            Chip("chip", images, Clock())
    with pytest.raises(ImageError):
        Image(chip("BS2"), bytes(2048), slot=1)


def test_choices_reach_the_program(tokenizer: Tokenizer) -> None:
    source = "w VAR Word\nv VAR Word\nx VAR Word\nw = 7 / v\nIF NOT v = 0 THEN x = 1\nRANDOM v"
    for compile_after in (None, 0):
        made = chip_of(tokenizer, source, compile_after=compile_after)
        made.run(SECOND_NS)
        assert [made.registers[f"W{n}"] for n in range(3)] == [65535, 1, 0]
        other = replace(CHOICES, quotient_by_zero=3, true_word=1, random_inverts=False)
        made = chip_of(tokenizer, source, unknowns=other, compile_after=compile_after)
        made.run(SECOND_NS)
        assert [made.registers[f"W{n}"] for n in range(3)] == [3, 0, 1]


@pytest.mark.parametrize(
    ("mode", "inputs", "outputs", "active"),
    [
        (0, 0, 0, False),
        (1, 1, 1, False),
        (2, 1, 1, True),
        (3, 1, 1, True),
        (4, 1, 1, True),
        (5, 0, 1, True),
        (6, 1, 0, True),
        (7, 0, 0, True),
    ],
)
def test_what_pollmode_forgets(mode: int, inputs: int, outputs: int, active: bool) -> None:
    """Ref: S2 p. 320; 5 to 7 leave the mode as it is, here 2."""
    groups, polling = (Pins("chip"), Pins("aux")), Polling()
    polling.watch(3, 0, groups)
    polling.drive(4, 1, groups)
    polling.set_mode(2)
    polling.set_mode(mode)
    assert (len(polling.inputs), len(polling.outputs), polling.active) == (inputs, outputs, active)
