"""A line of telemetry, as PROTOCOL.md has it, read back."""

import re
from typing import NamedTuple

from cgagen.bench_protocol import (
    ANTENNA_KEYS,
    COMMAND_KEY,
    LIGHT_KEYS,
    SONAR_KEYS,
    STATE_KEY,
    TELEMETRY,
)
from cgagen.words import Role
from hil.target import Stimulus

_WORD = re.compile(r"([A-Z]+)(\d+)")


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
    number, _, rest = text.rpartition(TELEMETRY)[2].partition(" ")
    words = dict(_WORD.findall(rest))
    lights = LIGHT_KEYS if role is Role.PREDATOR else ()
    try:
        left, right = (int(words[key]) for key in ANTENNA_KEYS)
        stimulus = Stimulus(
            tuple(int(words[key]) for key in SONAR_KEYS[role]),
            (left == 0, right == 0),
            tuple(int(words[key]) for key in lights),
        )
        return Told(int(number), stimulus, int(words[STATE_KEY]), int(words[COMMAND_KEY]))
    except (KeyError, ValueError):
        return None
