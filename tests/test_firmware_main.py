"""The main controllers: thresholds, tables, sensors, and what they decide."""

import random
import re
import tomllib

import pytest

from tests.firmware_cases import (
    CASES,
    GENOME,
    PREDATORS,
    PREYS,
    code,
    eeprom,
    labels,
    source,
    toy,
)
from tests.firmware_oracle import counts_of, edges, predator_state, prey_alarm, prey_answer


@pytest.mark.parametrize("case", PREDATORS)
def test_every_threshold_is_a_named_constant(case: str) -> None:
    for name, count in counts_of(CASES[case]).items():
        assert re.search(rf"^{name} +CON +{count} +' [\d.]+ in", source(case, "main"), re.MULTILINE)


@pytest.mark.parametrize("case", PREDATORS)
def test_the_table_in_the_image_is_the_genome(case: str) -> None:
    start = labels(case, "main")["Genes"]
    assert tuple(eeprom(case, "main")[start : start + 64]) == GENOME.commands()


@pytest.mark.parametrize("case", ["predator", "predator-unmasked", "predator-ambient",
                                  "predator-bs2e", "predator-other-pins"])  # fmt: skip
def test_the_predator_decides_as_specified(case: str) -> None:
    limits, program = counts_of(CASES[case]), toy(case, "main")
    masking = tomllib.loads(CASES[case])["situation"]["masking"]
    echoes = edges(*(limits[name] for name in limits if name.startswith("Echo")))
    lights = edges(*(limits[name] for name in limits if "Lamp" in name))
    dice, states = random.Random(4), set()
    latch = re.search(r"commandLatch +VAR +(OUT[A-D])", source(case, "main"))[1]
    for _ in range(1500 if case == "predator" else 1000):
        common = dice.choice(echoes)
        sonars = tuple(dice.choice((common, *dice.choices(echoes, k=2))) for _ in range(3))
        light = (dice.choice((0, 0, *lights)), dice.choice((0, 0, *lights)))
        levels = dice.choice((0b11, 0b11, 0b11, 0b11, 0b10, 0b01, 0b00))
        for index, count in enumerate(sonars):
            program.set(f"echo({index})", count)
        program.set("lightLeft", light[0])
        program.set("lightRight", light[1])
        program.set("antennas", levels)
        program.run("Decide")
        touched = (not levels & 1, not levels & 2)
        state = predator_state(limits, masking, sonars, light, touched)
        got = (program.get("state"), program.get("command"), program.get(latch))
        command = GENOME.commands()[state]
        assert got == (state, command, command), (sonars, light, levels)
        states.add(state)
    assert len(states) >= (26 if case == "predator-ambient" else 40)


@pytest.mark.parametrize("case", PREYS)
def test_the_prey_decides_as_specified(case: str) -> None:
    text, program = CASES[case], toy(case, "main")
    alarm = prey_alarm(text)
    assert re.search(rf"^Alarm +CON +{alarm} +' \d+ in", source(case, "main"), re.MULTILINE)
    moves = list(tomllib.loads(text)["movement"])
    dice, states = random.Random(5), set()
    for _ in range(400 if case == "prey" else 150):
        common = dice.choice(edges(alarm))
        sonars = tuple(dice.choice((common, *dice.choices(edges(alarm), k=2))) for _ in range(6))
        levels = dice.choice((0b11, 0b11, 0b11, 0b10, 0b01, 0b00))
        for index, count in enumerate(sonars):
            program.set(f"echo({index})", count)
        program.set("antennas", levels)
        program.run("Decide")
        state, movement = prey_answer(text, sonars, (not levels & 1, not levels & 2))
        command = moves.index(movement)
        assert (program.get("state"), program.get("command")) == (state, command), sonars
        assert program.get("OUTA") == command
        states.add(state)
    assert states == set(range(11))


def test_sensors_are_read_as_their_data_sheets_want() -> None:
    sense = re.search(r"^Sense:\n(.*?)RETURN", code("predator", "main"), re.S | re.M)[1]
    steps = [line.strip() for line in sense.splitlines() if line.strip()]
    ping = [f"{step} Sonar{{0}}{rest}" for step, rest in
            (("LOW", ""), ("PULSOUT", ", Trigger"), ("PULSIN", ", 1, echo({0})"))]  # fmt: skip
    expected = []
    for name in ("Front", "Right", "Left"):
        expected += [step.format(name) for step in ping]
        expected.append(f"PAUSE EchoGap - (echo({name}) / EchoMs MAX EchoGap)")
    expected.pop()
    for side in ("Left", "Right"):
        expected += [f"HIGH Lamp{side}", "PAUSE ChargeTime", f"RCTIME Lamp{side}, 1, light{side}"]
    assert steps == [*expected, "antennas.BIT0 = AntennaLeft", "antennas.BIT1 = AntennaRight"]
    for case in ("predator-srf04", "predator-srf04-bs2"):
        text = code(case, "main")
        assert "PULSOUT TriggerFront, Trigger\n  PULSIN EchoFront, 1, echo(Front)" in text
        assert text.count("RCTIME") == 4  # the light sensors, before the first look too


def test_the_command_lines_change_at_once_and_the_latch_comes_first() -> None:
    for case, nibble in (("predator", "A"), ("predator-other-pins", "D"), ("prey", "A")):
        text = code(case, "main")
        assert re.search(rf"commandLatch +VAR +OUT{nibble}\b", text)
        assert re.search(rf"commandDirs +VAR +DIR{nibble}\b", text)
        assert text.count("commandLatch = ") == 1
        assert text.count("commandDirs = ") == 1
        decide = text.index("commandLatch = command")
        assert text.index("Decide:") < decide < text.index("Tell:") < text.index("commandDirs =")
        bench = text[text.index("Bench:") :]
        assert "Tell" not in bench
        assert "GOSUB Decide" in bench


def test_no_step_line_leaves_no_trace_of_it() -> None:
    for case in ("predator-free-running", "prey-free-running"):
        for chip in ("main", "locomotion"):
            assert "StepLine" not in code(case, chip)
            assert "BUSY" not in source(case, chip)
    text = code("predator", "main")
    assert re.search(r"LOW StepLine\s+PAUSE GoTime\s+INPUT StepLine\s+IF StepLine = 0", text)
    assert re.search(r"^StepPolls +CON +520", text, re.M)  # 46 frames, 45 ms, a quarter, 5 ms
