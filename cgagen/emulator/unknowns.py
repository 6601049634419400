"""What no document says about the chips: one choice for each, and a switch.

Every row is in FIDELITY.md, too. Give a chip another value to see what depends on it:

>>> from dataclasses import replace
>>> other = replace(CHOICES, quotient_by_zero=0)
"""

from dataclasses import dataclass
from enum import StrEnum


class Wide(StrEnum):
    """What an operand that is too large does."""

    GOES_ON = "goes on"
    """The chip counts it down, one step for each: 0s come in."""
    WRAPS = "wraps"
    """The low bits that make sense are used."""


class Rounding(StrEnum):
    """How a real number becomes a whole one."""

    NEAREST = "nearest"
    DOWN = "down"
    """Towards zero."""


@dataclass(frozen=True, slots=True)
class Unknowns:
    """The choices. Every default is ours (Ref: choice) but where another source stands.

    Attributes:
        quotient_by_zero: x / 0.
        remainder_by_zero: x // 0; None for x itself.
        wide_shift: << and >> by 16 and more. GOES_ON gives 0, WRAPS takes the low four bits.
        wide_digit: DIG 5 and more. GOES_ON gives 0, WRAPS takes the remainder by 5.
        wide_reverse: REV of more than 16 bits. GOES_ON reverses on into 0s, WRAPS takes the low
            four bits.
        wide_decode: DCD of 16 and more. WRAPS takes the low four bits, GOES_ON gives 0.
        root: SQR and HYP.
        sine: SIN and COS.
        angle: ATN.
        true_word: what a comparison that holds leaves. Ref: S9 (0.94).
        random_taps: bits whose parity RANDOM shifts in from the right. Bits 15, 14, 12 and 3
            give a sequence of 65,535 values. Ref: S2 p. 359 for that number.
        random_inverts: the parity is inverted, so that RANDOM gets away from 0 and stays at
            65,535.
        stray_return_restarts: RETURN without GOSUB goes to the start (Ref: S2 p. 210);
            otherwise to where the last RETURN went (Ref: S9, 1.8 p. 266).
        run_clears_gosubs: RUN forgets the GOSUBs that have not returned.
    """

    quotient_by_zero: int = 0xFFFF
    remainder_by_zero: int | None = None
    wide_shift: Wide = Wide.GOES_ON
    wide_digit: Wide = Wide.GOES_ON
    wide_reverse: Wide = Wide.GOES_ON
    wide_decode: Wide = Wide.WRAPS
    root: Rounding = Rounding.DOWN
    sine: Rounding = Rounding.NEAREST
    angle: Rounding = Rounding.NEAREST
    true_word: int = 0xFFFF
    random_taps: int = 0xD008
    random_inverts: bool = True
    stray_return_restarts: bool = True
    run_clears_gosubs: bool = True


CHOICES = Unknowns()
