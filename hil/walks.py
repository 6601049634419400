"""What the legs make of each command: all eight movements, read back from twelve pulse trains."""

from collections.abc import Iterator

from cgagen.errors import CgagenError
from cgagen.words import COMMANDS
from hil.colony_bench import colony_bench
from hil.emulated import stopped
from hil.equivalence import Trial, Verdict, blocked
from hil.gait_reader import GaitReader, Reading
from hil.lone import MS, OFF_NS, Lone
from hil.stride import Stride
from hil.subject import Subject

SEEN_MS = 40
"""After so long the legs have seen the line high, and take a command. Ref: PROTOCOL.md."""


BOOT_MS, WALK_MS = 4_000, 4_000
"""How long a robot may take to its first movement, and for each. Choice: twice the longest."""

WORD, TESTER = "robot", "tester"

Walked = tuple[int, int | None, str]
"""A command, the movement that was made, and what was wrong with it."""


def try_walks(subject: Subject) -> Trial:
    """Give a locomotion controller each command, and compare what its servos do."""
    trial = Trial("emulator:locomotion")
    told = subject.robot.link.step_line is not None
    try:
        walks = list(_told(subject) if told else _read(subject))
    except CgagenError as error:
        return blocked(trial.target, stopped(subject.where, error))
    for command, made, wrong in walks:
        movement = COMMANDS[subject.role][command]
        trial.tried[command], trial.agreed[command] = 1, int(made == command and not wrong)
        if not trial.agreed[command] and not trial.reason:
            trial.verdict = Verdict.FAIL
            trial.reason = (
                f"{subject.where}: {subject.files['locomotion']}: {movement} was asked for: "
                f"{wrong or 'its servos make another movement'}"
            )
    return trial


def _told(subject: Subject) -> Iterator[Walked]:
    """Say GO for each command on the step line."""
    lone = Lone(subject, mute=True)
    lone.stand()
    for command in range(len(COMMANDS[subject.role])):
        lone.run(SEEN_MS)
        lone.go(command)
        walk = lone.walk()
        if walk is None:
            yield command, None, "nobody took it"
            continue
        wrong = walk.made.reason or ("" if walk.asked == command else "the lines said another one")
        if lone.uncommanded:
            wrong = f"it moved without a command {lone.uncommanded[0]}"
        yield command, walk.made.command, wrong


def _read(subject: Subject) -> Iterator[Walked]:
    """Put each command on the three lines as the movement before it ends, to be read behind it."""
    bench = colony_bench({WORD: subject})
    bench.reset(f"{WORD}_main", OFF_NS)
    made: list[Reading] = []
    commands = len(COMMANDS[subject.role])

    def say(command: int) -> None:
        for bit in range(3):
            bench.wire(f"{WORD}_command_{bit}").drive(TESTER, command >> bit & 1)

    def walked(reading: Reading) -> None:
        made.append(reading)
        say(len(made) % commands)
        bench.clock.stop()

    Stride(GaitReader(subject.robot, bench, f"{WORD}_"), bench, f"{WORD}_locomotion", walked)
    say(0)
    for command in range(commands):
        bench.run(bench.clock.now_ns + (WALK_MS + BOOT_MS * (command == 0)) * MS)
        if len(made) <= command:
            yield command, None, "no movement is made"
            return
        yield command, made[command].command, made[command].reason
