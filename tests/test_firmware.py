"""What all programs have in common: sizes, banner, text, time."""

import itertools
import re

import pytest

from cgagen.bench_protocol import (
    FRAME_LIMIT_MS,
    LOCOMOTION_SLICE_MS,
    REQUEST_BYTES,
    parse_banner,
)
from cgagen.errors import GenomeError, RobotError
from cgagen.firmware import generate, source_digest
from cgagen.firmware.timing import (
    CHARACTER_MS,
    DUMP_CODE_MS,
    FRAME_CODE_MS,
    LISTEN_CODE_MS,
    POSE_CODE_MS,
    frame_times,
)
from cgagen.robot.reader import LEAST_GAP_MS, parse_robot
from cgagen.robot.values import SONARS
from cgagen.words import Role
from tests.firmware_cases import (
    CASES,
    GENOME,
    PREDATOR,
    PREDATORS,
    PREY,
    TOKENIZER,
    built,
    changed,
    eeprom,
    genome_of,
    labels,
    robot_of,
    source,
)


@pytest.mark.parametrize("case", CASES)
def test_every_program_compiles_and_leaves_its_reserve(case: str) -> None:
    for program in built(case).programs:
        memory = program.memory
        assert memory.program_bytes + memory.data_bytes <= 1638
        assert memory.ram_free_bytes >= 2
        assert memory.gosub_depth is not None
        assert memory.gosub_depth <= 4
        assert program.image.model.name == program.program.model


@pytest.mark.parametrize("case", CASES)
def test_the_text_is_plain_and_never_sleeps(case: str) -> None:
    for chip in ("main", "locomotion"):
        text = source(case, chip)
        assert text.isascii()
        assert max(map(len, text.splitlines())) <= 100
        assert not any(line != line.rstrip() for line in text.splitlines())
        assert not re.search(r"\b(END|SLEEP|NAP|STOP|POLLWAIT)\b", text)
        assert "{$PBASIC 2.5}" in text


@pytest.mark.parametrize("case", CASES)
def test_the_banner_names_the_source_and_the_source_verifies(case: str) -> None:
    for chip in ("main", "locomotion"):
        text, image = source(case, chip), eeprom(case, chip)
        start = labels(case, chip)["Banner"]
        banner = parse_banner(image[start:].split(b"\r")[0].decode("ascii"))
        assert banner is not None
        assert (banner.chip, banner.robot) == (chip, robot_of(case).name)
        assert source_digest(text, banner.source) == banner.source
        assert f"Source:  {banner.source}," in text
        digest = GENOME.digest if case in PREDATORS else robot_of(case).digest
        assert banner.genome == digest[:8]
        changed_text = text.replace("FOR ", "FOR  ", 1)
        assert source_digest(changed_text, banner.source) != banner.source


def test_generation_repeats_itself() -> None:
    for case in ("predator", "prey"):
        first, second = (generate(robot_of(case), genome_of(case)) for _ in range(2))
        assert first == second
        assert first.digest == second.digest


def test_the_header_lists_every_pin_once() -> None:
    for case, chip in itertools.product(("predator", "prey-free-running"), ("main", "locomotion")):
        head = source(case, chip).split("Pins\n")[1].split("\n\n")[0]
        pins = re.findall(r"^'     P(\d+) ", head, re.MULTILINE)
        assert pins == sorted(set(pins), key=int)
        declared = re.findall(r"^\w+ +PIN +(\d+)", source(case, chip), re.MULTILINE)
        assert set(declared) <= set(pins)


def test_a_predator_wants_a_genome_and_a_prey_none() -> None:
    with pytest.raises(GenomeError, match=r"servobot-predator: a predator hunts by a genome; give"):
        generate(robot_of("predator"))
    with pytest.raises(GenomeError, match=r"servobot-prey: a prey acts by the reflex"):
        generate(robot_of("prey"), GENOME)


def costs_us(case: str) -> dict[str, list[int]]:
    """Model time of every statement of a locomotion program by label, without pulses and pauses."""
    compiled = TOKENIZER.compile(source(case, "locomotion"), case)
    lines = compiled.source.splitlines()
    statements = compiled.source_map.statements
    ends = [statement.bit for statement in statements[1:]] + [compiled.program_bytes * 8]
    costs: dict[str, list[int]] = {}
    for statement, end in zip(statements, ends, strict=True):
        label = next(
            lines[number].split(":")[0]
            for number in range(statement.line - 1, -1, -1)
            if re.match(r"\w+:", lines[number])
        )
        text = lines[statement.line - 1]
        reads = text.count(",") if "READ " in text else 0
        cost = 22 * max(1, reads) + 8 * (end - statement.bit) + 100 * reads
        cost += 50 * ("* PulseStep" in text)
        costs.setdefault(label, []).append(cost)
    return costs


def test_the_times_that_robots_are_judged_by_are_those_of_the_program() -> None:
    costs = costs_us("predator")
    call, back, jump = 100 + 254, 100 + 22 + 8 * 21, 100
    parts = [costs[label] for label in costs if label == "Pulses" or label.startswith("From")]
    pulses = sum(map(sum, parts)) - parts[-1][-1]
    assert pulses / 1000 == pytest.approx(FRAME_CODE_MS, abs=0.05)
    prompt, serin = costs["Listen"][1:3]
    listen = back + prompt + serin + jump + call
    assert LISTEN_CODE_MS - 0.2 < listen / 1000 < LISTEN_CODE_MS + 0.05
    dump = costs["BenchDump"]
    loop = dump[-10:]
    read, send, again, after = (loop[index] for index in (3, 4, 5, 6))
    four = 4 * (read + send + again) + 3 * jump
    assert (back + four + after + jump + dump[2] + call) / 1000 < DUMP_CODE_MS + 0.15
    move = costs["Move"]
    first_pose = back + call + sum(move[:7]) + 2 * call + 100
    assert first_pose / 1000 < POSE_CODE_MS + 0.05


@pytest.mark.parametrize("case", CASES)
def test_no_servo_waits_longer_than_45_ms(case: str) -> None:
    assert frame_times(robot_of(case)).longest_ms < 42


def test_servos_that_would_go_limp_are_refused() -> None:
    text = changed(
        PREDATOR, ("centre_counts = 750", "centre_counts = 1100"),
        ("max_counts = 1000", "max_counts = 1300"),
    )  # fmt: skip
    with pytest.raises(RobotError, match=r"a servo would wait 5\d ms .* 45 ms is allowed; use"):
        generate(parse_robot(text, "slow.toml"), GENOME)


def test_a_movement_shorter_than_go_is_refused() -> None:
    text = changed(PREY, ("hold_frames = 32", "hold_frames = 3"))
    with pytest.raises(RobotError, match=r"movement.WAIT\] hold_frames: .* at least 13 frames"):
        generate(parse_robot(text, "hasty.toml"))


@pytest.mark.parametrize("role", list(Role))
def test_no_decision_is_made_within_one_frame_of_the_legs(role: Role) -> None:
    """Or a GO comes before the locomotion controller has seen that its line is up, and is missed.

    A reading of echoes that all come at once took 22.5 ms with rests of 5 ms, a frame some 25.
    """
    quickest_ms = (len(SONARS[role]) - 1) * LEAST_GAP_MS
    others_ms = LISTEN_CODE_MS + LOCOMOTION_SLICE_MS + (1 + REQUEST_BYTES) * CHARACTER_MS
    assert quickest_ms > FRAME_LIMIT_MS - others_ms  # the longest frame that `check_timing` allows


def test_a_robot_with_any_name_gets_a_banner() -> None:
    text = changed(PREY, ('name = "servobot-prey"', 'name = "K\u00e4fer \\"2\\"  {{x}}"'))
    program = generate(parse_robot(text, "beetle.toml")).programs[0]
    assert program.banner.robot == "K_fer_2_x"
    assert f"#1 M K_fer_2_x {program.banner.genome} {program.banner.source}" in program.source
