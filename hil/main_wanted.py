"""What a main controller is tried with, and what it has to decide."""

from dataclasses import dataclass

from hil.simulated import SimulatedTarget
from hil.stimuli import Level, neutral, stimuli_of, ties
from hil.subject import Subject
from hil.target import Observation, Stimulus


@dataclass(frozen=True)
class Wanted:
    """What a main controller is tried with, and what it has to decide.

    Attributes:
        decisions: for `Decide` by itself, from a snapshot.
        hunts: for the pins, one after the other; then for the words of a bench.
    """

    decisions: tuple[tuple[Stimulus, Observation], ...]
    hunts: tuple[tuple[Stimulus, Observation], ...]


def wanted_of(subject: Subject) -> Wanted:
    """Return stimuli and the simulator's decisions."""
    robot, target = subject.robot, SimulatedTarget(subject)
    listed = list(dict.fromkeys([*stimuli_of(robot, Level.SMOKE), *ties(robot)]))
    decisions = zip(listed, target.decide_all(listed), strict=True)
    hunts = _hunts(subject)
    return Wanted(tuple(decisions), tuple(zip(hunts, target.decide_all(hunts), strict=True)))


def _hunts(subject: Subject) -> list[Stimulus]:
    """Return readings whose counts all differ, each sensor silent, touched, lit in turn."""
    plain = neutral(subject.robot)
    number, lights = len(plain.sonars), bool(plain.lights)
    rising = tuple(2_000 + 111 * index for index in range(number))
    gone = tuple(0 if index == number - 1 else 7_000 - index for index in range(number))
    far = tuple(9_000 + index for index in range(number))
    # Of any two sonars one hears a long echo and the other a short one, both ways round: each
    # sonar's rest follows from its own.
    mixed = [
        tuple((1_500, 9_500)[(index >> bit & 1) ^ odd] + index for index in range(number))
        for bit in range((number - 1).bit_length())
        for odd in (0, 1)
    ]
    rows: list[tuple[tuple[int, ...], tuple[bool, bool], tuple[int, int]]] = [
        (rising, (False, False), (0, 0)),
        (rising[::-1], (True, False), (300, 0)),
        (gone, (False, True), (0, 400)),
        (far, (True, True), (500, 600)),
        (far, (False, False), (1_000, 900)),
        (rising, (False, False), (0, 700)),
        *((one, (False, False), (0, 0)) for one in mixed),
    ]
    return [Stimulus(sonars, touched, lit if lights else ()) for sonars, touched, lit in rows]
