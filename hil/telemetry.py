"""A line of telemetry as a stimulus and what was decided about it."""

from typing import NamedTuple

from cgagen import telemetry
from cgagen.words import Role
from hil.target import Stimulus


class Told(NamedTuple):
    """What a line says."""

    number: int
    stimulus: Stimulus
    state: int
    command: int


def parse_telemetry(text: str, role: Role) -> Told | None:
    r"""Return what the last line of telemetry in a text says; None where there is none.

    >>> parse_telemetry(":7 F1843 R0 L23125 LL170 LR0 AL1 AR0 S15 C3\r", Role.PREDATOR)[1:]
    (Stimulus(sonars=(1843, 0, 23125), touched=(False, True), lights=(170, 0)), 15, 3)
    """
    said = telemetry.parse_telemetry(text, role)
    if said is None:
        return None
    stimulus = Stimulus(said.sonars, said.touched, said.lights)
    return Told(said.number, stimulus, said.state, said.command)
