"""No servo misses its pulse: every way through the locomotion programs, on a model of time.

The toy runs the program's text; each statement takes the time that the token bits of the compiled
program give it (`cgagen.firmware.timing`), each character and pulse its own. No chip is as exact as
the model: the limit is 50 ms, at which servos go limp, less 10 %.
"""

import itertools
import random
from collections.abc import Callable

import pytest

from cgagen.bench_protocol import BAUD, FRAME_LIMIT_MS, LOCOMOTION_SLICE_MS
from cgagen.firmware.timing import SPEED, frame_times
from cgagen.memory import report
from cgagen.robot import Robot
from cgagen.stamp.compiled import Compiled
from cgagen.tokenizer import Tokenizer
from tests.firmware_cases import genome_of, robot_of
from tests.toy_pbasic import SilenceError, Toy

CHARACTER_US = 10_000_000 / BAUD
FETCH_US, BIT_US, JUMP_US, PAUSE_US = 18.6, 8.05, 102.9, 59.2


class Clock(Toy):
    """The toy with a clock, in us, and the longest gap between two pulses of a servo."""

    def __init__(self, compiled: Compiled, robot: Robot, late: bool) -> None:
        data = report(compiled).data
        assert data is not None
        labels = {block.name: block.address for block in data}
        super().__init__(compiled.source, compiled.image.eeprom, labels)
        self.now_us = self.longest_us = 0.0
        self.last_us: dict[str, float] = {}
        self._late = late
        self._speed = SPEED[robot.locomotion.model]
        self._unit_us = robot.locomotion.pulsout_unit_ns / 1000
        self._cost_us = _costs_us(compiled)

    def step(self, pc: int, stack: list[int]) -> int:
        self.now_us += self._cost_us.get(self.numbers[pc], 0) / self._speed
        before = len(self.sent)
        following = super().step(pc, stack)
        self.now_us += (len(self.sent) - before) * CHARACTER_US
        if following != pc + 1:
            self.now_us += JUMP_US / self._speed
        return following

    def pulse(self, pin: str, width: int) -> None:
        if pin in self.last_us:
            self.longest_us = max(self.longest_us, self.now_us - self.last_us[pin])
        self.last_us[pin] = self.now_us
        self.now_us += width * self._unit_us
        super().pulse(pin, width)

    def receive(self, items: list[str]) -> bool:
        heard = super().receive(items)
        self.now_us += LOCOMOTION_SLICE_MS * 1000 if self._late or not heard else 0
        self.now_us += 4 * CHARACTER_US if heard else 0
        return heard


def _costs_us(compiled: Compiled) -> dict[int, float]:
    """Time of each line on a BS2, without pulses, characters and waits."""
    lines = compiled.source.splitlines()
    statements = compiled.source_map.statements
    ends = [statement.bit for statement in statements[1:]] + [compiled.program_bytes * 8]
    costs: dict[int, float] = {}
    for statement, end in zip(statements, ends, strict=True):
        text = lines[statement.line - 1].split("'")[0]
        reads = text.count(",") if text.strip().startswith("READ ") else 0
        cost = FETCH_US * max(1, reads) + BIT_US * (end - statement.bit) + 100 * reads
        cost += PAUSE_US * text.strip().startswith("PAUSE ")
        cost += 50 * text.count("* Pulse") + 90 * text.count("//")
        # GOSUB and RETURN each move an address of 14 bits more.
        cost += (BIT_US * 14 + JUMP_US) * (text.strip() == "RETURN")
        costs[statement.line] = costs.get(statement.line, 0) + cost
    return costs


def program_of(case: str, tokenizer: Tokenizer, late: bool = True) -> Clock:
    from cgagen.firmware import generate

    robot = robot_of(case)
    source = generate(robot, genome_of(case)).files["locomotion.bs2"]
    return Clock(tokenizer.compile(source, case), robot, late)


def ran(program: Clock, start: str, *inbox: str) -> float:
    """Run until nothing more is to be heard or seen; return the longest gap in ms."""
    program.inbox = list(inbox)
    with pytest.raises(SilenceError):
        program.run(start)
    return program.longest_us / 1000


def stand(program: Clock) -> None:
    """Start the program up to where the legs stand and nobody has said anything."""
    program.level = levels()
    ran(program, "Start", *[""] * 17)
    program.sent, program.last_us, program.longest_us = "", {}, 0.0


def levels(*answers: int) -> Callable[[str], int]:
    given = iter(answers)

    def level(pin: str) -> int:
        answer = next(given, None)
        if answer is None:
            raise SilenceError
        return answer

    return level


CASES = [
    "predator",
    "predator-trimmed",
    "predator-bs2e",
    "predator-bs2sx",
    "predator-bs2pe",
    "prey",
]


@pytest.mark.parametrize("case", CASES)
def test_from_reset_to_the_first_movement(case: str, tokenizer: Tokenizer) -> None:
    program = program_of(case, tokenizer)
    program.level = levels(1, 1, 1, 0, 1)
    ran(program, "Start", *[""] * 17)
    assert program.longest_us <= FRAME_LIMIT_MS * 1000
    assert len(program.sent.split("\r")[1]) == 17  # prompts


@pytest.mark.parametrize("case", CASES)
def test_while_walking_everything_after_everything(case: str, tokenizer: Tokenizer) -> None:
    program = program_of(case, tokenizer)
    stand(program)
    program.run("Pulses")
    commands = list(itertools.product(range(8), repeat=2))
    random.Random(2).shuffle(commands)
    for command in itertools.chain.from_iterable(commands[:20]):
        program.set("IND", command)
        program.level = levels(1, 0)
        ran(program, "Ready")
    assert program.longest_us <= FRAME_LIMIT_MS * 1000
    model = frame_times(robot_of(case)).changing_pose_ms
    assert program.longest_us / 1000 <= model + 0.5


def test_while_nobody_says_anything(tokenizer: Tokenizer) -> None:
    program = program_of("predator", tokenizer)
    stand(program)
    program.level = levels(*[0] * 501, *[1] * 501)
    ran(program, "Ready")
    assert program.sent == "*LOW\r*LOW\r*IDLE\r*IDLE\r"
    assert program.longest_us <= FRAME_LIMIT_MS * 1000


def test_while_the_command_lines_never_agree(tokenizer: Tokenizer) -> None:
    program = program_of("predator", tokenizer)
    stand(program)
    flicker = itertools.cycle((1, 2))
    read = program.get
    program.get = lambda name, index=0: (  # type: ignore[method-assign]
        next(flicker) if name == "commandLines" else read(name, index)
    )
    program.level = levels(1, 0, 1, 0)
    ran(program, "Ready")
    assert program.sent == "*LINES\r*LINES\r"
    assert program.longest_us <= FRAME_LIMIT_MS * 1000


@pytest.mark.parametrize("late", [False, True])
@pytest.mark.parametrize("case", CASES)
def test_in_bench_mode_whatever_is_asked_for(case: str, late: bool, tokenizer: Tokenizer) -> None:
    program = program_of(case, tokenizer, late)
    requests = ["?H00", "", "?M0a", "?M2b", "?M2b", "?C00", "?M7c", "?D13", "?Z00", "junk", "?D3o",
                "?H01", "?C00", "?X00"]  # fmt: skip
    program.level = levels(1)
    ran(program, "Start", *requests)
    assert program.sent.count("!") == 12
    assert program.longest_us <= FRAME_LIMIT_MS * 1000
    times = frame_times(robot_of(case))
    assert program.longest_us / 1000 <= times.longest_ms + 0.6


def test_while_running_free(tokenizer: Tokenizer) -> None:
    program = program_of("predator-free-running", tokenizer)
    steps = 0

    def walk(pin: str) -> int:
        raise AssertionError(pin)

    program.level = walk
    read = program.get

    def get(name: str, index: int = 0) -> int:
        nonlocal steps
        if name == "commandLines":
            steps += 1
            if steps > 20:
                raise SilenceError
            return steps // 2 % 8
        return read(name, index)

    program.get = get  # type: ignore[method-assign]
    ran(program, "Start", *[""] * 17)
    assert program.longest_us <= FRAME_LIMIT_MS * 1000
