"""Which stimuli are worth applying: derived from the robot's file, in chip counts.

A decision can change only where a count meets a threshold or another count. So the critical
values of a sensor are each of its thresholds with one less and one more, and the ends of its
range; and the lists here combine them. What was chosen by chance comes from a seed.
"""

import itertools
import random
from collections.abc import Iterator
from enum import StrEnum

from cgagen.counts import FARTHEST_COUNT, NO_ECHO_COUNT, UNLIT_COUNT
from cgagen.robot import Robot
from hil.simulated import states_of
from hil.target import Stimulus

Touched = tuple[bool, bool]

TOUCHES: tuple[Touched, ...] = ((False, False), (True, False), (False, True), (True, True))

SAMPLES = 500
"""Readings by chance in the smoke level. Choice."""

SEED = 1
"""Choice."""


class Level(StrEnum):
    """How much is tried."""

    SMOKE = "smoke"
    """All states that can be reached, every threshold once, and a sample of the rest."""
    BOUNDARY = "boundary"
    """Besides, ties in every order, the ends of the ranges, and every pair of these."""
    EXHAUSTIVE = "exhaustive"
    """Besides, one reading of each cell of the whole sensor space: a proof (`hil.proof`), of the
    image on the emulator. What has pins, or is on a wire, is given the boundaries as well. The
    default: it costs a second or two more."""

    @property
    def wide(self) -> bool:
        """Whether more is wanted than states and thresholds."""
        return self is not Level.SMOKE


def neutral(robot: Robot) -> Stimulus:
    """Return the reading of a robot that senses nothing."""
    lights = (UNLIT_COUNT, UNLIT_COUNT) if robot.light else ()
    return Stimulus((NO_ECHO_COUNT,) * len(robot.sonars), (False, False), lights)


def sonar_limits(robot: Robot) -> tuple[tuple[int, ...], ...]:
    """Return the thresholds of each sonar, rising."""
    if robot.limits is None:
        return ((robot.alarm_count,),) * len(robot.sonars)
    counts = robot.situation_counts
    side = (counts.side_near, counts.side_far)
    front = (counts.front_near, counts.front_middle, counts.front_far)
    return tuple(front if sonar.name == "front" else side for sonar in robot.sonars)


def light_limits(robot: Robot) -> tuple[tuple[int, ...], ...]:
    """Return the thresholds of each light sensor, rising; none for a prey."""
    if robot.limits is None:
        return ()
    counts = robot.situation_counts
    return tuple(tuple(sorted(lamp)) for lamp in (counts.lamp_left, counts.lamp_right))


def around(limits: tuple[int, ...]) -> tuple[int, ...]:
    """Return each limit with one less and one more, rising.

    >>> around((10, 11))
    (9, 10, 11, 12)
    """
    return tuple(sorted({limit + step for limit in limits for step in (-1, 0, 1)}))


def critical_sonar(robot: Robot, index: int) -> tuple[int, ...]:
    """Return the values at which something may change for one sonar."""
    longest = int(robot.echo_limits_counts(robot.sonars[index])[1])
    ends = {NO_ECHO_COUNT, 1, longest, FARTHEST_COUNT}
    return tuple(sorted(ends | set(around(sonar_limits(robot)[index]))))


def critical_lights(robot: Robot) -> list[tuple[int, ...]]:
    """Return the values at which something may change for each light sensor."""
    ends = {UNLIT_COUNT, 1, FARTHEST_COUNT}
    return [tuple(sorted({*ends, *around(limits)})) for limits in light_limits(robot)]


def with_values(stimulus: Stimulus, values: dict[int, int]) -> Stimulus:
    """Return a stimulus with other counts, by index: the sonars', then the lights'.

    >>> with_values(Stimulus((1, 2), lights=(3, 4)), {1: 9, 2: 8})
    Stimulus(sonars=(1, 9), touched=(False, False), lights=(8, 4))
    """
    counts = [*stimulus.sonars, *stimulus.lights]
    for index, value in values.items():
        counts[index] = value
    sonars = len(stimulus.sonars)
    return Stimulus(tuple(counts[:sonars]), stimulus.touched, tuple(counts[sonars:]))


def every_state(robot: Robot) -> dict[int, Stimulus]:
    """Return a reading for each state that can be reached, the plainest one first found.

    With masking, a predator that has the target ahead sees obstacles by touch alone, so not all
    64 states have a reading.
    """
    stimuli = sorted(_representatives(robot), key=lambda one: weight(robot, one))
    states = states_of(robot, stimuli).tolist()
    found: dict[int, Stimulus] = {}
    for state, stimulus in zip(states, stimuli, strict=True):
        found.setdefault(state, stimulus)
    return dict(sorted(found.items()))


def _representatives(robot: Robot) -> Iterator[Stimulus]:
    """Return readings with a value from between all neighbouring thresholds of each sensor."""
    sonars = [(NO_ECHO_COUNT, *between(limits)) for limits in sonar_limits(robot)]
    lights = [(UNLIT_COUNT, *between(limits)) for limits in light_limits(robot)]
    if robot.limits is None:
        sonars = [(NO_ECHO_COUNT, low - index) for index, (_, low, *_) in enumerate(sonars)]
    for touched in TOUCHES:
        for values in itertools.product(*sonars, *lights):
            yield Stimulus(values[: len(sonars)], touched, values[len(sonars) :])


def between(limits: tuple[int, ...]) -> tuple[int, ...]:
    """Return a value below each limit and above the one before.

    >>> between((10, 20))
    (5, 15)
    """
    return tuple((low + high) // 2 for low, high in itertools.pairwise((0, *limits)))


def thresholds(robot: Robot) -> Iterator[Stimulus]:
    """Return each threshold of each sensor with one less and one more, the rest neutral.

    A light's thresholds come with the other light dark, with it farther away, and with both
    alike: that is how all of them decide something.
    """
    plain = neutral(robot)
    sonars = len(plain.sonars)
    for index, limits in enumerate(sonar_limits(robot)):
        for value in around(limits):
            yield with_values(plain, {index: value})
    lights = light_limits(robot)
    if not lights:
        return
    far = [limits[-1] - 1 for limits in lights]
    for here, limits in enumerate(lights):
        there = 1 - here
        for value in around(limits):
            for other in (0, far[there], value):
                yield with_values(plain, {sonars + here: value, sonars + there: other})


def ties(robot: Robot) -> Iterator[Stimulus]:
    """Return the sonars alike and one apart around each threshold, in every order.

    The lights likewise; and for a predator the sonars also with either light lit, so that the
    tie is among those that are not masked.
    """
    plain = neutral(robot)
    sonars = len(plain.sonars)
    both = sorted({limit for limits in sonar_limits(robot) for limit in limits})
    near = [limits[0] for limits in light_limits(robot)]
    lights = [(0, 0), (near[0], 0), (0, near[1])] if near else [()]
    for limit in both:
        for values in itertools.product((limit - 1, limit, limit + 1), repeat=sonars):
            for lit in lights:
                yield Stimulus(values, (False, False), lit)
    for limits in zip(*light_limits(robot), strict=True):
        for pair in itertools.product(*((one - 1, one, one + 1) for one in limits)):
            yield Stimulus(plain.sonars, (False, False), pair)


def pairs(robot: Robot) -> Iterator[Stimulus]:
    """Return every pair of critical values of two sensors, antennas among them."""
    plain = neutral(robot)
    values = [critical_sonar(robot, index) for index in range(len(plain.sonars))]
    values += critical_lights(robot)
    for one, two in itertools.combinations(range(len(values)), 2):
        for first, second in itertools.product(values[one], values[two]):
            yield with_values(plain, {one: first, two: second})
    for touched in TOUCHES[1:]:
        bent = Stimulus(plain.sonars, touched, plain.lights)
        for index, options in enumerate(values):
            for value in options:
                yield with_values(bent, {index: value})
    sides = [index for index, sonar in enumerate(robot.sonars) if sonar.name in ("left", "right")]
    bent = Stimulus(plain.sonars, (True, True), plain.lights)
    for first, second in itertools.product(values[sides[0]], values[sides[1]]):
        yield with_values(bent, {sides[0]: first, sides[1]: second})


def sample(robot: Robot, count: int = SAMPLES, seed: int = SEED) -> Iterator[Stimulus]:
    """Return readings of critical values by chance; the same seed, the same readings."""
    chance = random.Random(seed)
    plain = neutral(robot)
    sonars = [critical_sonar(robot, index) for index in range(len(plain.sonars))]
    lights = critical_lights(robot)
    for _ in range(count):
        yield Stimulus(
            tuple(chance.choice(values) for values in sonars),
            TOUCHES[chance.randrange(4)] if chance.random() < 0.2 else TOUCHES[0],
            tuple(chance.choice(values) for values in lights),
        )


def stimuli_of(robot: Robot, level: Level, seed: int = SEED) -> list[Stimulus]:
    """Return the readings of a level, each once, in a fixed order."""
    wanted: list[Stimulus] = [neutral(robot), *every_state(robot).values(), *thresholds(robot)]
    if level.wide:
        wanted += [*ties(robot), *pairs(robot)]
        wanted += sample(robot, 10 * SAMPLES, seed)
    else:
        wanted += sample(robot, SAMPLES, seed)
    return list(dict.fromkeys(wanted))


def weight(robot: Robot, stimulus: Stimulus) -> tuple[int, Stimulus]:
    """Return what a stimulus is compared by: fewer sensors that see something are smaller."""
    plain = neutral(robot)
    counts = zip((*stimulus.sonars, *stimulus.lights), (*plain.sonars, *plain.lights), strict=True)
    return sum(one != other for one, other in counts) + sum(stimulus.touched), stimulus
