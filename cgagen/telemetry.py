"""The main controller's telemetry, as PROTOCOL.md has it, read back."""

import re
from collections.abc import Sequence
from typing import NamedTuple

from cgagen.bench_protocol import (
    ANTENNA_KEYS,
    COMMAND_KEY,
    LIGHT_KEYS,
    PREY_ANTENNA_LEFT,
    PREY_ANTENNA_RIGHT,
    PREY_BOTH_LEFT_OPEN,
    PREY_BOTH_RIGHT_OPEN,
    PREY_CALM,
    PREY_FIRST_SONAR,
    SONAR_KEYS,
    STATE_KEY,
    TELEMETRY,
)
from cgagen.words import Role

_WORD = re.compile(r"([A-Z]+)(\d{1,5})")
_LINE = re.compile(rf"(\d{{1,3}})((?: {_WORD.pattern})+)\s*")


class Telemetry(NamedTuple):
    """What one line says.

    Attributes:
        number: 0 to 255, and again from 0.
        sonars: PULSIN counts in the robot's order, 0 = no echo.
        touched: antennas, left and right.
        lights: RCTIME counts, left and right, 0 = dark; none of a prey.
        state: as PROTOCOL.md numbers it.
        command: 0 to 7.
    """

    number: int
    sonars: tuple[int, ...]
    touched: tuple[bool, bool]
    lights: tuple[int, ...]
    state: int
    command: int


_PREY_REASONS = {
    PREY_CALM: "nothing_near",
    PREY_ANTENNA_LEFT: "antenna_left",
    PREY_ANTENNA_RIGHT: "antenna_right",
    PREY_BOTH_LEFT_OPEN: "both_left_open",
    PREY_BOTH_RIGHT_OPEN: "both_antennas",
}


def prey_reason(state: int, sonars: Sequence[str]) -> str | None:
    """Return what a prey's state says has decided; None for a number that is no state.

    Args:
        state: as PROTOCOL.md numbers it.
        sonars: names, in the robot's order.

    >>> prey_reason(1, ("front_left", "front_right")), prey_reason(8, ()), prey_reason(11, ())
    ('near_front_left', 'antenna_right', None)
    """
    if 0 <= state - PREY_FIRST_SONAR < len(sonars):
        return f"near_{sonars[state - PREY_FIRST_SONAR]}"
    return _PREY_REASONS.get(state)


def parse_telemetry(text: str, role: Role) -> Telemetry | None:
    r"""Return what the last line of telemetry in a text says; None where there is none whole.

    >>> parse_telemetry(">:7 F1843 R0 L23125 LL170 LR0 AL1 AR0 S15 C3\r", Role.PREDATOR)[1:4]
    ((1843, 0, 23125), (False, True), (170, 0))
    >>> parse_telemetry(":7 F1843 R0 L2\r", Role.PREDATOR)
    """
    found = _LINE.fullmatch(text.rpartition(TELEMETRY)[2]) if TELEMETRY in text else None
    words = dict(_WORD.findall(found[2])) if found else {}
    lights = LIGHT_KEYS if role is Role.PREDATOR else ()
    keys = (*SONAR_KEYS[role], *lights, *ANTENNA_KEYS, STATE_KEY, COMMAND_KEY)
    if found is None or set(words) != set(keys):
        return None
    value = {key: int(words[key]) for key in keys}
    counts = [value[key] for key in (*SONAR_KEYS[role], *lights)]
    if max(counts) > 0xFFFF:
        return None
    left, right = (value[key] == 0 for key in ANTENNA_KEYS)
    sonars = len(SONAR_KEYS[role])
    return Telemetry(
        int(found[1]),
        tuple(counts[:sonars]),
        (left, right),
        tuple(counts[sonars:]),
        value[STATE_KEY],
        value[COMMAND_KEY],
    )


def role_in(text: str) -> Role | None:
    """Return whose telemetry stands in a text; None where no whole line does.

    >>> role_in(":0 FL1 FR2 L3 R4 RL5 RR6 AL1 AR1 S0 C1")
    <Role.PREY: 'prey'>
    """
    return next((role for role in Role if parse_telemetry(text, role)), None)
