"""What the four programs are: their sizes, their tables, and what their text decides."""

import itertools
import math
import random
import re
import tomllib
from functools import cache

import pytest

from cgagen.bench_protocol import (
    dump_request,
    parse_answer,
    parse_banner,
    parse_dump,
    reading_text,
)
from cgagen.build import Build, make_build
from cgagen.errors import GenomeError, RobotError
from cgagen.firmware import generate, source_digest
from cgagen.firmware.timing import (
    DUMP_CODE_MS,
    FRAME_CODE_MS,
    LISTEN_CODE_MS,
    POSE_CODE_MS,
    frame_times,
)
from cgagen.memory import report
from cgagen.robot.reader import parse_robot
from cgagen.tokenizer import Tokenizer
from tests.firmware_cases import (
    CASES,
    GENOME,
    PREDATOR,
    PREY,
    changed,
    genome_of,
    robot_of,
    with_model,
)
from tests.toy_pbasic import SilenceError, Toy

PREDATORS = [case for case in CASES if case.startswith("predator")]
PREYS = [case for case in CASES if case.startswith("prey")]
TOKENIZER = Tokenizer()
LEGS = ("LF", "LM", "LR", "RF", "RM", "RR")


@cache
def built(case: str) -> Build:
    return make_build(robot_of(case), genome_of(case), TOKENIZER)


def source(case: str, chip: str) -> str:
    return built(case).programs[chip == "locomotion"].program.source


def code(case: str, chip: str) -> str:
    """The source without comments and texts."""
    return re.sub(r"\"[^\"\n]*\"|'[^\n]*", "", source(case, chip))


@cache
def labels(case: str, chip: str) -> dict[str, int]:
    text = source(case, chip)
    data = report(TOKENIZER.compile(text, chip)).data
    assert data is not None
    return {block.name: block.address for block in data}


def eeprom(case: str, chip: str) -> bytes:
    return built(case).programs[chip == "locomotion"].image.eeprom


def toy(case: str, chip: str) -> Toy:
    return Toy(source(case, chip), eeprom(case, chip), labels(case, chip))


# --- all programs


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


# --- the main controllers


def counts_of(text: str) -> dict[str, int]:
    """The thresholds of a robot file as counts, by the formulas alone."""
    data = tomllib.loads(text)
    per_in = 2 * data["echo"]["us_per_in"] * 1000 / data["main"]["pulsin_unit_ns"]
    limits = data["situation"]

    def light(inches: float) -> int:
        rows = data["light"]["curve"]
        for (near, less), (far, more) in itertools.pairwise(rows):
            if near <= inches <= far:
                return math.floor(less + (more - less) * (inches - near) / (far - near) + 1e-9)
        raise AssertionError(inches)

    return {
        "EchoFrontNear": math.floor(limits["front_near_in"] * per_in),
        "EchoFrontMiddle": math.floor(limits["front_middle_in"] * per_in),
        "EchoFrontFar": math.floor(limits["front_far_in"] * per_in),
        "EchoSideNear": math.floor(limits["side_near_in"] * per_in),
        "EchoSideFar": math.floor(limits["side_far_in"] * per_in),
        "LampFrontNear": light(limits["target_front_near_in"]),
        "LampFrontMiddle": light(limits["target_front_middle_in"]),
        "LampSideNear": light(limits["target_side_near_in"]),
        "LampRange": light(data["light"][data["light"]["condition"] + "_range_in"]),
    }


@pytest.mark.parametrize("case", PREDATORS)
def test_every_threshold_is_a_named_constant(case: str) -> None:
    for name, count in counts_of(CASES[case]).items():
        assert re.search(rf"^{name} +CON +{count} +' [\d.]+ in", source(case, "main"), re.MULTILINE)


@pytest.mark.parametrize("case", PREDATORS)
def test_the_table_in_the_image_is_the_genome(case: str) -> None:
    start = labels(case, "main")["Genes"]
    assert tuple(eeprom(case, "main")[start : start + 64]) == GENOME.commands()


NO, NEAR_RIGHT, FAR_RIGHT, NEAR_LEFT, FAR_LEFT, NEAR_FRONT, MIDDLE_FRONT, FAR_FRONT = range(8)


def predator_state(
    limits: dict[str, int],
    masking: bool,
    sonars: tuple[int, ...],
    light: tuple[int, int],
    touched: tuple[bool, bool],
) -> int:
    """The state as the paper and the robot's file have it, written for this test."""
    lit_left, lit_right = (1 <= count < limits["LampRange"] for count in light)
    if lit_left and lit_right:
        least = min(light)
        target = (
            NEAR_FRONT
            if least < limits["LampFrontNear"]
            else MIDDLE_FRONT
            if least < limits["LampFrontMiddle"]
            else FAR_FRONT
        )
        hidden = {"front", "right", "left"}
    elif lit_right:
        target = NEAR_RIGHT if light[1] < limits["LampSideNear"] else FAR_RIGHT
        hidden = {"front", "right"}
    elif lit_left:
        target = NEAR_LEFT if light[0] < limits["LampSideNear"] else FAR_LEFT
        hidden = {"front", "left"}
    else:
        target, hidden = NO, set()
    seen = {
        name: 65535 if count == 0 or (masking and name in hidden) else count
        for name, count in zip(("front", "right", "left"), sonars, strict=True)
    }
    nearest = min(seen, key=lambda name: seen[name])  # the first of equals
    count = seen[nearest]
    if all(touched):
        obstacle = NEAR_FRONT
    elif touched[0]:
        obstacle = NEAR_LEFT
    elif touched[1]:
        obstacle = NEAR_RIGHT
    elif nearest == "front":
        obstacle = (
            NEAR_FRONT
            if count < limits["EchoFrontNear"]
            else MIDDLE_FRONT
            if count < limits["EchoFrontMiddle"]
            else FAR_FRONT
            if count < limits["EchoFrontFar"]
            else NO
        )
    else:
        near, far = (NEAR_RIGHT, FAR_RIGHT) if nearest == "right" else (NEAR_LEFT, FAR_LEFT)
        obstacle = (
            near if count < limits["EchoSideNear"] else far if count < limits["EchoSideFar"] else NO
        )
    return 8 * obstacle + target


def edges(*limits: int) -> list[int]:
    near = [limit + offset for limit in limits for offset in (-1, 0, 1)]
    return [0, 1, *near, 23125, 65534, 65535]


@pytest.mark.parametrize("case", ["predator", "predator-unmasked", "predator-ambient",
                                  "predator-bs2e", "predator-other-pins"])  # fmt: skip
def test_the_predator_decides_as_specified(case: str) -> None:
    limits, program = counts_of(CASES[case]), toy(case, "main")
    masking = tomllib.loads(CASES[case])["situation"]["masking"]
    echoes = edges(*(limits[name] for name in limits if name.startswith("Echo")))
    lights = edges(*(limits[name] for name in limits if name.startswith("Lamp")))
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


def prey_answer(text: str, sonars: tuple[int, ...], touched: tuple[bool, bool]) -> tuple[int, str]:
    """State and movement of the prey, written for this test."""
    data = tomllib.loads(text)
    reflex = data["reflex"]
    policy = reflex["policies"][reflex["policy"]]
    names = ("front_left", "front_right", "left", "right", "rear_left", "rear_right")
    seen = {name: count or 65535 for name, count in zip(names, sonars, strict=True)}
    if all(touched):
        side = "both_left_open" if seen["left"] > seen["right"] else "both_right_open"
        return (9 if side == "both_left_open" else 10), reflex[side]
    if touched[0]:
        return 7, reflex["antenna_left"]
    if touched[1]:
        return 8, reflex["antenna_right"]
    nearest = min(names, key=lambda name: seen[name])
    if seen[nearest] < prey_alarm(text):
        return 1 + names.index(nearest), policy[nearest]
    return 0, "WAIT"


def prey_alarm(text: str) -> int:
    data = tomllib.loads(text)
    per_in = 2 * data["echo"]["us_per_in"] * 1000 / data["main"]["pulsin_unit_ns"]
    return math.floor(data["reflex"]["policies"][data["reflex"]["policy"]]["alarm_in"] * per_in)


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
        expected += [step.format(name) for step in ping] + ["PAUSE EchoRest"]
    expected.pop()
    for side in ("Left", "Right"):
        expected += [f"HIGH Lamp{side}", "PAUSE ChargeTime", f"RCTIME Lamp{side}, 1, light{side}"]
    assert steps == [*expected, "antennas.BIT0 = AntennaLeft", "antennas.BIT1 = AntennaRight"]
    fast, slow = code("predator-srf04", "main"), code("predator-srf04-bs2", "main")
    assert "PULSOUT TriggerFront, Trigger\n  PULSIN EchoFront, 1, echo(Front)" in fast
    assert "PULSOUT TriggerFront, Trigger\n  RCTIME EchoFront, 1, echo(Front)" in slow
    assert "PULSIN" not in slow


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


# --- the bench mode and the step line


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
    assert not any(event.startswith(("LOW", "HIGH", "INPUT")) for event in program.events)
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
        (["?M8d", "?M/e"], ">!E8d\r>!E/e\r>", 0),
        (["?C00"], ">!C00\r>", 0),
    ):
        program.frames.clear()
        assert talk(program, *words, start="BenchNext") == answers
        extra = len(split_frames(program.frames)) - frames
        assert 1 <= extra <= 4 * len(words) + 1
    assert program.frames[-1] == dict.fromkeys(program.frames[-1], 188 * 4)
    assert not any("StepLine" in event for event in program.events)


def test_go_is_said_when_the_legs_stand_and_believed_when_the_line_stays_low() -> None:
    program = toy("predator", "main")
    answers = iter([0, 0, 1, 0])
    program.level = lambda pin: next(answers)
    program.run("AwaitLegs")
    assert program.events == ["PAUSE PollTime"] * 2
    program.events.clear()
    program.run("Tell")
    assert program.events == ["LOW StepLine", "PAUSE GoTime", "INPUT StepLine"]
    assert (program.get("DIRA"), program.sent) == (0b0111, "")
    program.level = lambda pin: 1
    program.run("Tell")
    assert program.sent == "*REFUSED\r"
    program.sent, looks = "", iter([0] * 521 + [1])
    program.level = lambda pin: next(looks)
    program.run("AwaitLegs")
    assert program.sent == "*BUSY\r"


def test_the_locomotion_controller_lets_go_only_between_movements() -> None:
    program = toy("predator", "locomotion")
    line = iter([0, 1, 1, 0, 1, 0])
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
    assert seen == ["0 after 1", "1 after 2", "1 after 3", "0 after 4", "1 after 52", "0 after 53"]


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


# --- the locomotion controllers


def wanted_frames(text: str, movement: str) -> list[tuple[dict[str, float], int]]:
    """The phases of a movement: pulse in counts by leg and joint, and its frames; from the file."""
    data = tomllib.loads(text)
    move, gait, servo = data["movement"][movement], data["gait"], data["servo"]
    order = [0, 1, 2, 3, 4, 5]
    first = move["first_phase"] - 1
    walk = order[first:] + order[:first]
    if move["order"] == "reverse":
        walk = [walk[4], walk[3], walk[2], walk[1], walk[0], walk[5]]
    frames = [gait["lift_frames"], move["push_frames"], gait["lower_frames"]] * 2
    phases = []
    for row, count in zip(walk, frames, strict=True):
        pulses = {}
        for index, leg in enumerate(LEGS):
            swing = move["left_deg" if leg[0] == "L" else "right_deg"]
            forward = gait["phase"][row]["forward"][index] == "1"
            up = gait["phase"][row]["up"][index] == "1"
            angles = (swing if forward else -swing, gait["lift_deg"] if up else 0)
            for joint, angle in enumerate(angles):
                trim, way = (servo[key][leg][joint] for key in ("trim_counts", "direction"))
                offset = way * angle * servo["counts_per_deg"]
                name = f"Pin{('Swing', 'Lift')[joint]}{leg}"
                pulses[name] = servo["centre_counts"] + trim + offset
        phases.append((pulses, count))
    return phases


@pytest.mark.parametrize(
    "case",
    ["predator", "predator-trimmed", "predator-bs2sx", "predator-other-pins", "prey"],
)
def test_every_movement_is_walked_as_the_file_has_it(case: str) -> None:
    text, program = CASES[case], toy(case, "locomotion")
    data = tomllib.loads(text)
    step = program.get("PulseStep")
    low, high = data["servo"]["min_counts"], data["servo"]["max_counts"]
    for command, movement in enumerate(data["movement"]):
        if data["movement"][movement]["order"] == "hold":
            continue
        program.frames.clear()
        program.set("command", command)
        program.run("Move")
        frames = split_frames(program.frames)
        for pulses, count in wanted_frames(text, movement):
            for _ in range(count):
                frame = frames.pop(0)
                assert frame.keys() == pulses.keys()
                for servo, wanted in pulses.items():
                    assert low <= frame[servo] <= high
                    assert abs(frame[servo] - wanted) <= step / 2, (movement, servo)
        assert not frames


def split_frames(frames: list[dict[str, int]]) -> list[dict[str, int]]:
    """The toy begins a frame at pin 0; with other pins the pulses come as one long list."""
    flat = [item for frame in frames for item in frame.items()]
    return [dict(flat[start : start + 12]) for start in range(0, len(flat), 12)]


def test_waiting_holds_the_last_pose() -> None:
    program = toy("prey", "locomotion")
    program.run("Centre")
    program.set("command", 2)
    program.run("Move")
    last = program.frames[-1]
    program.frames.clear()
    program.set("command", 1)
    program.run("Move")
    assert program.frames == [last] * 32


def test_it_stands_before_it_does_anything_else() -> None:
    program = toy("predator-trimmed", "locomotion")
    program.run("Centre")
    program.run("Pulses")
    trims = tomllib.loads(CASES["predator-trimmed"])["servo"]["trim_counts"]
    for leg in LEGS:
        for joint, name in enumerate(("Swing", "Lift")):
            assert abs(program.frames[0][f"Pin{name}{leg}"] - 750 - trims[leg][joint]) <= 2
    start = [line.strip() for line in code("predator", "locomotion").split("Start:")[1].split("\n")]
    assert start[1:4] == ["DIRS = %1000111111111111", "GOSUB Centre", "GOSUB SayWho"]
    text = code("predator", "locomotion")
    assert text.index("GOSUB Centre") < text.index("INPUT StepLine")
    assert text.count("INPUT StepLine") == 1


def test_equal_swings_share_one_table() -> None:
    text = source("predator", "locomotion")
    assert re.findall(r"^(Swing[A-Z]) ", text, re.M) == [f"Swing{letter}" for letter in "ABCDE"]
    assert labels("predator", "locomotion")["SwingE"] <= 255


# --- time


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
    pulses = sum(costs["Pulses"][:-1])
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


def test_a_slow_chip_that_cannot_count_an_echo_alike_is_refused() -> None:
    text = with_model(CASES["predator-srf04"], "main", "BS2", 2000, rctime_ns=1900)
    with pytest.raises(RobotError, match="rctime_unit_ns: a BS2 reads an SRF04 by RCTIME"):
        generate(parse_robot(text, "odd.toml"), GENOME)


def test_a_robot_with_any_name_gets_a_banner() -> None:
    text = changed(PREY, ('name = "servobot-prey"', 'name = "K\u00e4fer \\"2\\"  {{x}}"'))
    program = generate(parse_robot(text, "beetle.toml")).programs[0]
    assert program.banner.robot == "K_fer_2_x"
    assert f"#1 M K_fer_2_x {program.banner.genome} {program.banner.source}" in program.source
