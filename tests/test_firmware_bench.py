"""Bench mode, telemetry and step line, as the text of the programs has them."""

import tomllib

import pytest

from cgagen.bench_protocol import (
    dump_request,
    parse_answer,
    parse_banner,
    parse_dump,
    reading_text,
)
from tests.firmware_cases import (
    GENOME,
    PREDATOR,
    PREY,
    eeprom,
    split_frames,
    toy,
)
from tests.firmware_oracle import counts_of, predator_state, prey_answer
from tests.toy_pbasic import SilenceError, Toy


def talk(program: Toy, *inbox: str, start: str = "Start") -> str:
    """What a program sends from its start until it has nothing more to hear."""
    program.inbox, program.sent = list(inbox), ""
    with pytest.raises(SilenceError):
        program.run(start)
    return program.sent


@pytest.mark.parametrize("case", ["predator", "prey"])
def test_a_host_is_heard_and_may_take_the_place_of_the_sensors(case: str) -> None:
    program = toy(case, "main")
    sonars = (1900, 0, 700, 65535, 800, 900)[: 3 if case == "predator" else 6]
    counts = (*sonars, *((0, 300) if case == "predator" else ()))
    reading = reading_text(0b11, counts)
    sent = talk(program, "", "?Hz", "?H5A", "?Q7b", reading, "?Q7c", reading.replace("3", "2", 1),
                "?Z12", "junk", "?H5B")  # fmt: skip
    banner, prompts, *lines = sent.split("\r")
    assert parse_banner(banner) is not None
    assert prompts == ">>>!H5A"
    if case == "predator":
        state = predator_state(counts_of(PREDATOR), True, sonars, (0, 300), (False, False))
        command = GENOME.commands()[state]
    else:
        state, movement = prey_answer(PREY, sonars, (False, False))
        command = list(tomllib.loads(PREY)["movement"]).index(movement)
    assert parse_answer(lines[0]) == ("7b", state, command)
    assert lines[1:] == [">>!E7c", ">!E12", ">>!H5B", ">"]
    lamps = ("HIGH LampLeft", "HIGH LampRight")  # charged, to see whether it is dark
    driven = [one for one in program.events if one.startswith(("LOW", "HIGH", "INPUT"))]
    assert [one for one in driven if one not in lamps] == []
    assert program.get("DIRA") == 0


@pytest.mark.parametrize("case", ["predator", "prey"])
@pytest.mark.parametrize("chip", ["main", "locomotion"])
def test_every_byte_can_be_read_back(case: str, chip: str) -> None:
    program, image = toy(case, chip), eeprom(case, chip)
    ranges = ((0, 2047), (40, 95), (2040, 2047))
    requests = [dump_request(*one) for one in ranges]
    for (first, last), part in zip(
        ranges, talk(program, "?H00", *requests).split("!D")[:3], strict=True
    ):
        lines = [parse_dump(line) for line in part.split("\r")]
        found = b"".join(line[1] for line in lines if line)
        start, end = first // 32 * 32, last // 32 * 32 + 32
        assert found == image[start:end]
        assert [line[0] for line in lines if line] == list(range(start, end, 16))
    assert talk(program, "?Do0", "?D/0", "?D0p", start="BenchNext") == ">!Eo0\r>!E/0\r>!E0p\r>"


def test_a_movement_is_made_once_however_often_it_is_asked_for() -> None:
    program = toy("predator", "locomotion")
    talk(program, "?H00")
    for words, answers, frames in (
        (["?M3a"], ">!M3a\r>", 46),
        (["?M3a", "?M3a"], ">!M3a\r>!M3a\r>", 0),
        (["?M3b", "?M1c"], ">!M3b\r>!M1c\r>", 46 + 32),
        (["?M1c", "?H00", "?M1c"], ">!M1c\r>!H00\r>!M1c\r>", 32),
        (["?M8d", "?M/e"], ">!E8d\r>!E/e\r>", 0),
        (["?C00"], ">!C00\r>", 6 * 8),
    ):
        program.frames.clear()
        assert talk(program, *words, start="BenchNext") == answers
        extra = len(split_frames(program.frames)) - frames
        assert 1 <= extra <= 4 * len(words) + 1
    assert program.frames[-1] == dict.fromkeys(program.frames[-1], 188 * 4)
    assert not any("StepLine" in event for event in program.events)


def test_go_is_said_when_the_legs_stand_and_believed_when_the_line_stays_low() -> None:
    program = toy("predator", "main")
    program.set("least", 3)
    answers = iter([0, 0, 1, 0])
    program.level = lambda pin: next(answers)
    program.run("AwaitLegs")
    assert program.events == ["PAUSE PollTime"] * 2
    program.events.clear()
    program.run("Tell")
    assert program.events == ["LOW StepLine", "PAUSE GoTime", "INPUT StepLine"]
    assert (program.get("DIRA"), program.sent) == (0b0111, "")
    assert program.get("least") == program.get("LeastPolls") > 20
    program.level = lambda pin: 1
    program.run("AwaitLegs")  # nobody walks so fast
    assert program.sent == "*CUT\r"
    program.sent = ""
    program.level = lambda pin: 1
    program.run("Tell")
    assert (program.sent, program.get("least")) == ("*REFUSED\r", 0)
    program.sent, looks = "", iter([0] * 521 + [1])
    program.level = lambda pin: next(looks)
    program.run("AwaitLegs")
    assert program.sent == "*BUSY\r"


def test_the_locomotion_controller_lets_go_only_between_movements() -> None:
    program = toy("predator", "locomotion")
    line = iter([0, 1, 1, 0, 0, 1, 0, 0])
    seen: list[str] = []

    def level(pin: str) -> int:
        level = next(line, None)
        if level is None:
            raise SilenceError
        seen.append(f"{level} after {len(split_frames(program.frames))}")
        return level

    program.level = level
    program.set("IND", 0b1010)
    with pytest.raises(SilenceError):
        program.run("Ready")
    assert [event for event in program.events if "StepLine" in event] == [
        "INPUT StepLine", "LOW StepLine", "INPUT StepLine", "LOW StepLine", "INPUT StepLine",
    ]  # fmt: skip
    # Up to the first GO four frames; then one, 46 of RIGHT_FORWARD, and one before the next look.
    # GO is looked at twice: before the lines are read, and behind it.
    assert seen == [
        "0 after 1", "1 after 2", "1 after 3", "0 after 4", "0 after 4",
        "1 after 52", "0 after 53", "0 after 53",
    ]  # fmt: skip


def test_a_go_that_is_taken_back_starts_nothing() -> None:
    """A main controller that resets lets go of the step line and of the command at once."""
    program = toy("predator", "locomotion")
    line = iter([1, 0, 1, 1])
    program.level = lambda pin: next(line)
    program.set("IND", 0b1000)
    with pytest.raises(StopIteration):
        program.run("Ready")
    assert "LOW StepLine" not in program.events


def test_telemetry_is_one_line_that_can_be_parsed() -> None:
    program = toy("predator", "main")
    for index, count in enumerate((1843, 0, 23125)):
        program.set(f"echo({index})", count)
    for name, value in (("lightLeft", 170), ("antennas", 1), ("state", 15), ("command", 3)):
        program.set(name, value)
    program.set("decisions", 255)
    program.run("Report")
    program.run("Report")
    line = "F1843 R0 L23125 LL170 LR0 AL1 AR0 S15 C3"
    assert program.sent == f":255 {line}\r:0 {line}\r"
