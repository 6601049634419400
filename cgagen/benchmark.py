"""How fast this machine is, as rates and ratios measured in one run.

Nothing here passes or fails: a figure depends on the machine and on what else it does, so the
load is printed with it, and the ratios (lanes against the plain loop, two threads against one)
are what can be compared between machines. Targets are those of DECISIONS.md 10.
"""

import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from cgagen.build import make_build
from cgagen.emulator.bench import Bench
from cgagen.emulator.chip import Chip
from cgagen.emulator.parts.ping import Ping
from cgagen.emulator.routine import Routine
from cgagen.errors import TargetTimeout
from cgagen.evolve import Settings, first_generation, next_generation
from cgagen.genome import from_commands
from cgagen.robot import Robot, load_arena, load_robot
from cgagen.stamp.image import Image
from cgagen.temporaries import temporary_folder
from cgagen.tokenizer import Tokenizer
from hil.emulated import PinsTarget, robot_bench
from hil.registers import RegisterTarget
from hil.stimuli import Level, sample
from hil.subject import Subject, subject_of
from hil.target import Stimulus
from hil.verify import pin_readings
from sim.model import World, with_distance, words_of
from sim.numbers import Options
from sim.scalar import play_scalar

STARTS = 10
STEPS = 200
GENERATIONS = 300
REPEATS = 5


class Row(NamedTuple):
    """One figure.

    Attributes:
        name: what was measured.
        value: the number.
        unit: of it.
        target: in words, or "".
    """

    name: str
    value: float
    unit: str
    target: str = ""


def rows() -> Iterator[Row]:
    """Measure everything, in the order of the house; yields each figure as it is known."""
    yield from _world()
    yield from _evolution()
    yield from _programs()
    yield from _chips()
    yield from _command_line()


def load() -> str:
    """Return what else the machine does, for the reader of the figures."""
    one_minute, *_ = os.getloadavg()
    return f"{len(os.sched_getaffinity(0))} cores, load {one_minute:.2f}"


def _best_rate(work: float, function: Callable[[], object], clock: Callable[[], float]) -> float:
    """Return the best of a few runs: noise of the machine only ever slows one down."""
    function()
    rates = []
    for _ in range(REPEATS):
        begin = clock()
        function()
        rates.append(work / (clock() - begin))
    return max(rates)


def _world() -> Iterator[Row]:
    parts = load_robot("servobot-predator"), load_robot("servobot-prey"), load_arena("colony")
    # Without hold no episode ends early, so every step that is counted is played.
    options = Options(after_capture="go_on")
    one, two = (World(*parts, options, threads=threads) for threads in (1, 2))
    rng = np.random.Generator(np.random.Philox(1))
    words, starts = words_of(first_generation(Settings(), rng)), one.draw_starts(rng, STARTS)
    work = words.shape[1] * STARTS * STEPS / 1e6
    lanes = _best_rate(work, lambda: one.play(words, starts), time.thread_time)
    columns, few = with_distance(starts), words[:, :32].copy()
    sums = np.empty(32 * STARTS)
    scalar = _best_rate(
        work / 8, lambda: play_scalar(few, columns, STEPS, one.numbers, sums), time.thread_time
    )
    wide = _best_rate(work, lambda: two.play(words, starts), time.perf_counter)
    yield Row("world steps, one core", lanes, "M/s", "45 with AVX-512")
    yield Row("world steps, plain loop", scalar, "M/s")
    yield Row("lanes against the plain loop", lanes / scalar, "x", "3.5")
    yield Row("world steps, two threads", wide, "M/s")
    for world in (one, two):
        world.close()


def _evolution() -> Iterator[Row]:
    with temporary_folder() as folder:
        words = ("--generations", "1", "--fixed-starts", "1", "--run", f"{folder}/first")
        first = _seconds("evolve", *words)
        begin = os.times()
        trial = _seconds("evolve", "--seed", "7", "--run", f"{folder}/trial")
        spent = os.times().children_user - begin.children_user
    genetic = _genetic_seconds()
    steps = (GENERATIONS * STARTS + 31 * 100) * 256 * STEPS / 1e6
    yield Row("second start to the first generation", first, "s", "1.5")
    yield Row("a paper trial, two threads", trial - first, "s", "6")
    yield Row("steps that the trial asks for", steps, "M")
    yield Row("genetic algorithm's part of it", 100 * genetic / spent, "% of CPU", "10")
    yield Row("peak memory", _peak_mb(), "MB", "500")


def _genetic_seconds() -> float:
    settings, rng = Settings(), np.random.Generator(np.random.Philox(2))
    bits = first_generation(settings, rng)
    fitness = rng.random(settings.population)
    begin = time.thread_time()
    for _ in range(GENERATIONS):
        bits = next_generation(bits, fitness, settings, rng)
    return time.thread_time() - begin


def _programs() -> Iterator[Row]:
    with temporary_folder() as folder:
        both = _seconds("build", "--robot", "servobot-prey", "-o", f"{folder}/build")
    with Tokenizer() as tokenizer:
        rate = _best_rate(
            100, lambda: [tokenizer.compile(_SOURCE) for _ in range(100)], time.perf_counter
        )
    yield Row("build of both programs", both, "s", "2")
    yield Row(f"compiles of {len(_SOURCE):,} characters", rate, "/s", "500")


_SOURCE = "' {$STAMP BS2}\n' {$PBASIC 2.5}\nwidth VAR Word\n" + "".join(
    f"IF width > {number} THEN\n  PULSOUT {number % 16}, width + {number}  ' servo\nENDIF\n"
    for number in range(1, 46)
)
"""A program of a common size: some 2,800 characters, 100 statements."""


def _chips() -> Iterator[Row]:
    robot = load_robot("servobot-predator")
    with Tokenizer() as tokenizer:
        built = make_build(robot, from_commands([*range(8)] * 8), tokenizer)
        subject = subject_of(built, "benchmark")
        readings = list(sample(robot, 2000))
        with RegisterTarget(subject, tokenizer.compile) as target:
            decisions = _best_rate(2000, lambda: target.decide_all(readings), time.thread_time)
            instructions = _classifier_rate(robot, subject, target, readings)
    yield Row("decisions from a snapshot", decisions, "/s", "20,000")
    yield Row("PBASIC instructions of the classifier", instructions, "M/s", "1.5")
    yield Row("a decision through all pins", _through_pins(subject), "x the robot's", "50")
    bench = robot_bench(robot, subject.images)
    bench.run(2_000_000_000)
    whole = _best_rate(2, lambda: _run_on(bench, 2), time.thread_time)
    yield Row("a whole emulated robot", whole, "x real", "30")
    alone = _main_alone(subject.images["main"])
    alone.run(2_000_000_000)
    hunts = _best_rate(10, lambda: _run_on(alone, 10), time.thread_time)
    yield Row("an emulated BS2p24 that hunts", hunts, "x real", "100")


def _through_pins(subject: Subject) -> float:
    """Return how much faster than the robot a decision comes, with everything through its pins.

    The robot's time is that of the decision alone: from the trigger of the first sonar to GO, when
    the command is on its wires, for the readings that `pytest hil/` puts in front of the sensors.
    Against it stands all that `PinsTarget.decide` takes: going back to the moment before the
    first look, setting the sensors, both chips with all parts, and the line of telemetry, for
    which both run on for 150 ms of the robot's time after GO; these are not counted for it.
    """
    with PinsTarget(subject) as target:
        readings = pin_readings(subject, Level.SMOKE)
        robot_s = sum(target.decide(one).latency_ns or 0 for one in readings) / 1e9
        return _best_rate(
            robot_s, lambda: [target.decide(one) for one in readings], time.thread_time
        )


def _classifier_rate(
    robot: Robot, subject: Subject, target: RegisterTarget, readings: Sequence[Stimulus]
) -> float:
    """Return millions of instructions a second of `Decide` alone, with nothing around it."""
    chip = robot_bench(robot, subject.images).chip("main")
    if not chip.run_until(lambda: chip.pc == target.entry, 5_000_000_000):
        raise TargetTimeout("the main controller never comes to Decide; build the robot anew")
    routine = Routine(chip, chip.machine.memory.slots[chip.slot].header(chip.machine.gosubs[-1]))
    calls = [target.registers(reading) for reading in readings]
    instructions = 0
    for words in calls:
        routine.call(words)
        instructions += routine.instructions

    def run() -> None:
        for words in calls:
            routine.call(words)

    return _best_rate(instructions / 1e6, run, time.thread_time)


def _main_alone(image: Image) -> Bench:
    """Return a main controller with its sonars, whose legs always stand."""
    bench = Bench()
    bench.add_chip(Chip("main", [image], bench.clock))
    bench.connect("step", "main.P3", pull=1)
    for sonar in load_robot("servobot-predator").sonars:
        wire = bench.connect(sonar.name, f"main.P{sonar.pins[0]}")
        bench.add_part(Ping(f"{sonar.name}_sonar", bench.clock, wire))
    return bench


def _run_on(bench: Bench, seconds: int) -> None:
    bench.run(bench.clock.now_ns + seconds * 1_000_000_000)


def _command_line() -> Iterator[Row]:
    yield Row("cgagen --help", min(_seconds("--help") for _ in range(REPEATS)), "s", "0.15")


def _seconds(*words: str) -> float:
    """Return how long a call of `cgagen` takes as a process."""
    begin = time.perf_counter()
    subprocess.run(
        [sys.executable, "-m", "cgagen", *words],
        check=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        timeout=600,
        stdin=subprocess.DEVNULL,
    )
    return time.perf_counter() - begin


def _peak_mb() -> float:
    """Return the largest memory of any process that this one has started."""
    import resource

    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
