"""One step of the pursuit: both robots sense the same instant, decide, and then both move.

Ref: S1 II.C. `step` is what evolution runs, in lanes; `look` is the same step with everything
that was sensed and decided, for people. Both are made of the same parts.
"""

import math
from typing import NamedTuple

from cgagen.robot import SituationCounts
from sim.decide import gene, lit, obstacle_situation, prey_command, target_situation
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
    lamp = light_count(seen.distance, numbers.curve)
    return Reading(
        sonar(seen, numbers.front, numbers.counts_per_unit),
        sonar(seen, numbers.right, numbers.counts_per_unit),
        sonar(seen, numbers.left, numbers.counts_per_unit),
        touch(seen, numbers.touch_left),
        touch(seen, numbers.touch_right),
        light(seen, numbers.lit_left, lamp),
        light(seen, numbers.lit_right, lamp),
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
def state_of_reading(reading: Reading, masking: bool, limits: SituationCounts) -> int:
    """Return the state, 0 to 63, that a reading puts the predator in."""
    obstacle = obstacle_situation(
        reading.front,
        reading.right,
        reading.left,
        reading.touch_left,
        reading.touch_right,
        lit(reading.light_left, limits.target_range),
        lit(reading.light_right, limits.target_range),
        masking,
        limits,
    )
    return 8 * obstacle + target_situation(reading.light_left, reading.light_right, limits)


@device
def answer_of_reading(reading: PreyReading, reflex: ReflexNumbers) -> int:
    """Return the prey's command for a reading."""
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


@device
def step(
    px: float,
    py: float,
    pc: float,
    ps: float,
    qx: float,
    qy: float,
    qc: float,
    qs: float,
    distance: float,
    word_0: int,
    word_1: int,
    word_2: int,
    numbers: WorldNumbers,
) -> tuple[float, float, float, float, float, float, float, float, float]:
    """Play one gait cycle of both robots.

    Args:
        px, py, pc, ps: the predator.
        qx, qy, qc, qs: the prey.
        distance: between their centres.
        word_0, word_1, word_2: the predator's genome (see `gene`).
        numbers: of this world.

    Returns:
        The same nine numbers after the step.
    """
    predator, prey = numbers.predator, numbers.prey
    per_distance = 1.0 / distance
    p = see(px, py, pc, ps, qx, qy, distance, per_distance, prey.radius, numbers.side)
    q = see(qx, qy, qc, qs, px, py, distance, per_distance, predator.radius, numbers.side)
    state = state_of_reading(read_predator(p, predator.sensors), predator.masking, predator.limits)
    command = Bits(gene(state, word_0), gene(state, word_1), gene(state, word_2))
    answer = bits_of(answer_of_reading(read_prey(q, prey.sensors), prey.reflex))
    stay = numbers.hold & captured(distance, numbers.scoring)
    stop = numbers.stop_at_walls
    px2, py2, pc2, ps2 = move(
        px, py, pc, ps, command, predator.steps, predator.radius, numbers.side, stop
    )
    qx2, qy2, qc2, qs2 = move(qx, qy, qc, qs, answer, prey.steps, prey.radius, numbers.side, stop)
    px2 = px if stay else px2
    py2 = py if stay else py2
    pc2 = pc if stay else pc2
    ps2 = ps if stay else ps2
    qx2 = qx if stay else qx2
    qy2 = qy if stay else qy2
    qc2 = qc if stay else qc2
    qs2 = qs if stay else qs2
    dx = qx2 - px2
    dy = qy2 - py2
    return px2, py2, pc2, ps2, qx2, qy2, qc2, qs2, math.sqrt(dx * dx + dy * dy)
