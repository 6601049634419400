"""What two ends of a serial line have to agree on: bits per second, and the form of a byte."""

import re
from typing import NamedTuple

SLOWEST_BAUD, FASTEST_BAUD = 100, 250_000
"""SERIN and SEROUT have bits of 20 to 8,211 units, so 122 to 50,000 baud with 1 us and 304 to
125,000 with 0.4 us; the rest is room. Ref: S2 p. 394, 416, 431."""

RATES = (300, 600, 1_200, 2_400, 4_800, 9_600, 14_400, 19_200, 28_800, 31_250, 38_400, 57_600)
"""Those that programs and terminals use. Ref: S2 p. 395, 419."""

CLOSE = 0.04
"""Ten bits at a rate that is so much off are heard. Ref: choice; half a bit at the end is 0.05."""

_WRITTEN = re.compile(r"(\d{1,9})(?:[-,/ ]?(8N1|7E1))?", re.IGNORECASE)


class SerialMode(NamedTuple):
    """A rate and a form. Which level is a mark does not belong to it.

    Attributes:
        baud: bits per second.
        seven_even: seven data bits and even parity instead of eight and none.

    >>> str(SerialMode(2400, True)), str(SerialMode())
    ('2400-7E1', '9600')
    """

    baud: int = 9_600
    seven_even: bool = False

    def is_heard_as(self, other: "SerialMode") -> bool:
        """Whether what is sent so is what a receiver of another mode takes."""
        off = abs(self.baud - other.baud) / other.baud
        return off < CLOSE and self.seven_even == other.seven_even

    def __str__(self) -> str:
        return f"{self.baud}-7E1" if self.seven_even else str(self.baud)


DEBUG_MODE = SerialMode()
"""That of DEBUG and DEBUGIN on all five models. Ref: S2 p. 419."""


def usual(baud: float) -> int:
    """Return the rate that a line with such a bit time is meant to have.

    >>> usual(2403.8), usual(980.4)
    (2400, 980)
    """
    nearest = min(RATES, key=lambda rate: abs(rate - baud))
    return nearest if abs(nearest - baud) < CLOSE / 2 * nearest else round(baud)


def parse_mode(text: str) -> SerialMode | None:
    """Return the mode that a text names; None for none.

    >>> parse_mode("2400"), parse_mode("1200,7e1"), parse_mode("5")
    (SerialMode(baud=2400, seven_even=False), SerialMode(baud=1200, seven_even=True), None)
    """
    found = _WRITTEN.fullmatch(text.strip())
    if found is None or not SLOWEST_BAUD <= int(found[1]) <= FASTEST_BAUD:
        return None
    return SerialMode(int(found[1]), (found[2] or "").upper() == "7E1")
