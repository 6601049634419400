"""One step of the pursuit: both robots sense the same instant, decide, and then both move.

Ref: S1 II.C. `step` is what evolution runs, in lanes; `look` is the same step with everything
that was sensed and decided, for people. Both are made of the same parts.
"""

import math
from typing import NamedTuple

from cgagen.robot import SituationCounts
from sim.decide import gene, heard, lit, obstacle_situation, prey_command, target_situation
from sim.jit import device
from sim.numbers import (
    Eight,
    PredatorSensors,
    PreySensors,
    ReflexNumbers,
    Scoring,
    StepTable,
    WorldNumbers,
)
from sim.senses import Seen, light, light_count, see, sonar, touch

ONE_POINT_UNITS = 1e-9
"""Nearer than this, both robots stand on one point and have no bearing: no sonar or light sensor
faces the other. Only robots that go on after the capture come so near, in a corner. Choice."""


class Reading(NamedTuple):
    """What the predator's chip measures: sonar and light counts, touched antennas."""

    front: int
    right: int
    left: int
    touch_left: bool
    touch_right: bool
    light_left: int
    light_right: int


class PreyReading(NamedTuple):
    """What the prey's chip measures."""

    front_left: int
    front_right: int
    left: int
    right: int
    rear_left: int
    rear_right: int
    touch_left: bool
    touch_right: bool


@device
def read_predator(seen: Seen, numbers: PredatorSensors) -> Reading:
    """Read all sensors of the predator."""
    return Reading(
        sonar(seen, numbers.front, numbers.counts_per_unit),
        sonar(seen, numbers.right, numbers.counts_per_unit),
        sonar(seen, numbers.left, numbers.counts_per_unit),
        touch(seen, numbers.touch_left),
        touch(seen, numbers.touch_right),
        light(seen, numbers.lit_left, light_count(seen.distance, numbers.curve_left)),
        light(seen, numbers.lit_right, light_count(seen.distance, numbers.curve_right)),
    )


@device
def read_prey(seen: Seen, numbers: PreySensors) -> PreyReading:
    """Read all sensors of the prey."""
    return PreyReading(
        sonar(seen, numbers.front_left, numbers.counts_per_unit),
        sonar(seen, numbers.front_right, numbers.counts_per_unit),
        sonar(seen, numbers.left, numbers.counts_per_unit),
        sonar(seen, numbers.right, numbers.counts_per_unit),
        sonar(seen, numbers.rear_left, numbers.counts_per_unit),
        sonar(seen, numbers.rear_right, numbers.counts_per_unit),
        touch(seen, numbers.touch_left),
        touch(seen, numbers.touch_right),
    )


@device
def state_of_heard(reading: Reading, masking: bool, limits: SituationCounts) -> int:
    """Return the state, 0 to 63, of a reading in which every sonar heard an echo."""
    obstacle = obstacle_situation(
        reading.front,
        reading.right,
        reading.left,
        reading.touch_left,
        reading.touch_right,
        lit(reading.light_left, limits.lamp_left.range),
        lit(reading.light_right, limits.lamp_right.range),
        masking,
        limits,
    )
    return 8 * obstacle + target_situation(reading.light_left, reading.light_right, limits)


@device
def state_of_reading(reading: Reading, masking: bool, limits: SituationCounts) -> int:
    """Return the state, 0 to 63, of any reading; a sonar count of 0 is no echo."""
    front, right, left = heard(reading.front), heard(reading.right), heard(reading.left)
    others = reading.touch_left, reading.touch_right, reading.light_left, reading.light_right
    return state_of_heard(Reading(front, right, left, *others), masking, limits)


@device
def answer_of_heard(reading: PreyReading, reflex: ReflexNumbers) -> int:
    """Return the prey's command for a reading in which every sonar heard an echo."""
    return prey_command(
        reading.front_left,
        reading.front_right,
        reading.left,
        reading.right,
        reading.rear_left,
        reading.rear_right,
        reading.touch_left,
        reading.touch_right,
        reflex,
    )


@device
def answer_of_reading(reading: PreyReading, reflex: ReflexNumbers) -> int:
    """Return the prey's command for any reading; a sonar count of 0 is no echo."""
    return answer_of_heard(
        PreyReading(
            heard(reading.front_left),
            heard(reading.front_right),
            heard(reading.left),
            heard(reading.right),
            heard(reading.rear_left),
            heard(reading.rear_right),
            reading.touch_left,
            reading.touch_right,
        ),
        reflex,
    )


class Bits(NamedTuple):
    """A command, bit by bit, the least significant first."""

    bit_0: bool
    bit_1: bool
    bit_2: bool


@device
def bits_of(command: int) -> Bits:
    """Take a command apart."""
    return Bits((command & 1) != 0, (command & 2) != 0, (command & 4) != 0)


@device
def pick(values: Eight, at: Bits) -> float:
    """Return one of eight values; selects instead of a load, so that lanes stay together."""
    first = values[1] if at.bit_0 else values[0]
    second = values[3] if at.bit_0 else values[2]
    third = values[5] if at.bit_0 else values[4]
    fourth = values[7] if at.bit_0 else values[6]
    low = second if at.bit_1 else first
    high = fourth if at.bit_1 else third
    return high if at.bit_2 else low


@device
def within(value: float, low: float, high: float) -> float:
    """Return the value, or the end of the range that it is beyond."""
    value = value if value > low else low
    return value if value < high else high


@device
def move(
    x: float,
    y: float,
    c: float,
    s: float,
    command: Bits,
    steps: StepTable,
    radius: float,
    side: float,
    stop_at_walls: bool,
) -> tuple[float, float, float, float]:
    """Return the pose after one gait cycle.

    The displacement is along the heading before the step and to its right; the body stays within
    the walls: it slides along them, or the whole displacement is lost.
    """
    along = pick(steps.along, command)
    right = pick(steps.right, command)
    cosine = pick(steps.cos, command)
    sine = pick(steps.sin, command)
    to_x = x + (along * c + right * s)
    to_y = y + (along * s - right * c)
    near_x = within(to_x, radius, side - radius)
    near_y = within(to_y, radius, side - radius)
    lost = stop_at_walls & ((near_x != to_x) | (near_y != to_y))
    return (
        x if lost else near_x,
        y if lost else near_y,
        c * cosine - s * sine,
        s * cosine + c * sine,
    )


@device
def captured(distance: float, scoring: Scoring) -> bool:
    """Say whether the predator has caught the prey. Ref: S1 III.A."""
    return scoring.longest - distance > scoring.capture_score


@device
def score_of(distance: float, scoring: Scoring) -> float:
    """Return the score of a step before the bonus for speed. Ref: S1 III.A, equation 1.

    The capture doubles it first (DECISIONS.md 9).
    """
    score = scoring.longest - distance
    return 2.0 * score if score > scoring.capture_score else score


class Pair(NamedTuple):
    """Both robots at one instant: p is the predator, q the prey; and how far they are apart."""

    px: float
    py: float
    pc: float
    ps: float
    qx: float
    qy: float
    qc: float
    qs: float
    distance: float


class Words(NamedTuple):
    """A genome: word b holds bit b of all 64 commands (see `gene`)."""

    bit_0: int
    bit_1: int
    bit_2: int


class Look(NamedTuple):
    """What both robots sense and decide at one instant."""

    reading: Reading
    state: int
    command: Bits
    prey_reading: PreyReading
    answer: int


@device
def look(at: Pair, genome: Words, numbers: WorldNumbers) -> Look:
    """Let both robots sense and decide; the genome is the predator's."""
    predator, prey, side = numbers.predator, numbers.prey, numbers.side
    nearness = 1.0 / max(at.distance, ONE_POINT_UNITS)
    p = see(at.px, at.py, at.pc, at.ps, at.qx, at.qy, at.distance, nearness, prey.radius, side)
    q = see(at.qx, at.qy, at.qc, at.qs, at.px, at.py, at.distance, nearness, predator.radius, side)
    reading = read_predator(p, predator.sensors)
    state = state_of_heard(reading, predator.masking, predator.limits)
    command = Bits(gene(state, genome.bit_0), gene(state, genome.bit_1), gene(state, genome.bit_2))
    prey_reading = read_prey(q, prey.sensors)
    return Look(reading, state, command, prey_reading, answer_of_heard(prey_reading, prey.reflex))


@device
def step(at: Pair, genome: Words, numbers: WorldNumbers) -> Pair:
    """Play one gait cycle of both robots: look, then move, unless the capture holds them."""
    predator, prey = numbers.predator, numbers.prey
    seen = look(at, genome, numbers)
    stay = numbers.hold & captured(at.distance, numbers.scoring)
    side, stop = numbers.side, numbers.stop_at_walls
    px, py, pc, ps = move(
        at.px, at.py, at.pc, at.ps, seen.command, predator.steps, predator.radius, side, stop
    )
    qx, qy, qc, qs = move(
        at.qx, at.qy, at.qc, at.qs, bits_of(seen.answer), prey.steps, prey.radius, side, stop
    )
    px, py = at.px if stay else px, at.py if stay else py
    pc, ps = at.pc if stay else pc, at.ps if stay else ps
    qx, qy = at.qx if stay else qx, at.qy if stay else qy
    qc, qs = at.qc if stay else qc, at.qs if stay else qs
    dx, dy = qx - px, qy - py
    return Pair(px, py, pc, ps, qx, qy, qc, qs, math.sqrt(dx * dx + dy * dy))
