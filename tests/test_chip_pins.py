"""What a chip does to its pins by itself: END, BUTTON, polling, AUXIO."""

import pytest

from cgagen.emulator.chip import End
from cgagen.emulator.pins import Pins
from cgagen.emulator.polling import Polling
from cgagen.emulator.wires import Wire
from cgagen.tokenizer import Tokenizer
from tests.chip_programs import SECOND_NS, chip_of


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
