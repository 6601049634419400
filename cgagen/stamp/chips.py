"""The chips: one row per model, every number with its source.

Five models speak the token format of this package. The 40-pin BS2p has the rows of the BS2p;
the tokenizer that the format is known from does not know the BS2px.
"""

from dataclasses import dataclass

from cgagen.errors import ImageError
from cgagen.near import did_you_mean

EEPROM_BYTES = 2048
"""Bytes of one program slot, on every model. Ref: S2 p. 459 (addresses 0 to 2047)."""


@dataclass(frozen=True, slots=True)
class Chip:
    """What one model is.

    Attributes:
        name: as Parallax writes it.
        directive: the word in the source's `$STAMP` directive.
        target: the tokenizer's number for it. Ref: S3 (TModuleRec.TargetModule).
        slots: program slots of `EEPROM_BYTES` each. The BS2pe has as many again for data.
            Ref: S2 p. 382 (RUN), S5 (STOREALL).
        variable_bytes: RAM for variables, W0 to W12. Ref: S2 p. 82.
        scratch_bytes: scratch pad RAM reached by GET and PUT. Ref: S2 p. 92.
        pins: input/output pins that an instruction can name.
        debug_baud_word: what DEBUG pushes for 9,600 baud: bit time - 20, in 1 us on BS2, BS2e
            and BS2pe and in 0.4 us on BS2sx and BS2p. Ref: S2 p. 419; the words themselves S3.
        pulsin_unit_ns: one count of PULSIN. Ref: S2 p. 343; of a BS2p 750 by S4, S5 and S9 (2.0c
            p. 241), where S2 alone says 800; of a BS2pe 1,880, for S2 and S4 say "2 us" and
            123.6 ms at most (FIDELITY.md).
        pulsout_unit_ns: one count of PULSOUT. Ref: S2 p. 347.
        rctime_unit_ns: one count of RCTIME. Ref: S2 p. 363.
    """

    name: str
    directive: str
    target: int
    slots: int
    variable_bytes: int
    scratch_bytes: int
    pins: int
    debug_baud_word: int
    pulsin_unit_ns: int
    pulsout_unit_ns: int
    rctime_unit_ns: int


CHIPS: tuple[Chip, ...] = (
    #    name     directive target slots RAM scratch pins baud pulsin pulsout rctime
    Chip("BS2",   "BS2",   2,     1,    26,   0,    16,   84, 2000,  2000,   2000),
    Chip("BS2e",  "BS2E",  3,     8,    26,  64,    16,   84, 2000,  2000,   2000),
    Chip("BS2sx", "BS2SX", 4,     8,    26,  64,    16,  240,  800,   800,    800),
    Chip("BS2p",  "BS2P",  5,     8,    26, 136,    16,  240,  750,   800,    750),
    Chip("BS2pe", "BS2PE", 6,     8,    26, 136,    16,   84, 1880,  2000,   2000),
)  # fmt: skip

_BY_NAME = {row.name.lower(): row for row in CHIPS}
_BY_TARGET = {row.target: row for row in CHIPS}


def chip(name: str) -> Chip:
    """Return the row of a model; upper and lower case are the same.

    Raises:
        ImageError: no such model.

    >>> chip("bs2P").pulsin_unit_ns
    750
    """
    try:
        return _BY_NAME[name.strip().lower()]
    except KeyError:
        known = ", ".join(row.name for row in CHIPS)
        meant = did_you_mean(name, (row.name for row in CHIPS))
        raise ImageError(f"there is no model {name!r}{meant}; the models are {known}") from None


def chip_of_target(target: int) -> Chip:
    """Return the row of a tokenizer's target number, 2 to 6.

    Raises:
        ImageError: another number.
    """
    if target not in _BY_TARGET:
        raise ImageError(f"the tokenizer's target {target} is none of 2 to 6")
    return _BY_TARGET[target]
