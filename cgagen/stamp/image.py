"""What goes into a Stamp: the 2,048 bytes of one program slot, and what each byte is."""

from dataclasses import dataclass, field
from enum import IntEnum

from cgagen.errors import ImageError
from cgagen.files import digest
from cgagen.stamp.chips import EEPROM_BYTES, Chip

SENT = 0x80
"""Bit of a flag: the byte lies in a 16-byte block that is sent to the chip. Ref: S3."""


class Use(IntEnum):
    """What an EEPROM byte holds: the low bits of its flag. Ref: S3 (TModuleRec.EEPROMFlags)."""

    EMPTY = 0
    RESERVED = 1
    """By DATA without a value: keeps on the chip what it held before the download."""
    DATA = 2
    PROGRAM = 3


_FLAGS = bytes(use | sent for use in Use for sent in (0, SENT))


@dataclass(frozen=True, slots=True)
class Image:
    """One program slot as it is on the chip.

    Attributes:
        model: the chip that it was made for; the bytes alone do not tell.
        eeprom: 2,048 bytes, DATA from 0 up, the program from 2047 down. Ref: S3.
        flags: one byte for each, `Use` and `SENT`; None where only the bytes are known.
        slot: program slot, 0 to the model's last.

    Raises:
        ImageError: a wrong length, a flag that has no meaning, or a slot the model lacks.
    """

    model: Chip
    eeprom: bytes = field(repr=False)
    flags: bytes | None = field(default=None, repr=False)
    slot: int = 0

    def __post_init__(self) -> None:
        for what, data in (("an EEPROM image", self.eeprom), ("an array of flags", self.flags)):
            if data is not None and len(data) != EEPROM_BYTES:
                raise ImageError(
                    f"{what} of a {self.model.name} has {EEPROM_BYTES} bytes, this one has "
                    f"{len(data)}; give the whole slot, unused bytes as 0"
                )
        if self.flags is not None and self.flags.translate(None, _FLAGS):
            raise ImageError("a flag is not 0 to 3 with bit 7; give the tokenizer's own flags")
        if not 0 <= self.slot < self.model.slots:
            raise ImageError(
                f"a {self.model.name} has no program slot {self.slot}; "
                f"its slots are 0 to {self.model.slots - 1}"
            )

    @property
    def digest(self) -> str:
        """SHA-256 of the EEPROM bytes, 64 hexadecimal digits."""
        return digest(self.eeprom)

    def count(self, use: Use) -> int:
        """Return how many bytes are of this use.

        Raises:
            ImageError: the image came without flags.
        """
        return sum(1 for flag in self.known_flags() if flag & 3 == use)

    def known_flags(self) -> bytes:
        """Return the flags, or refuse where there are none.

        Raises:
            ImageError: the image came without flags.
        """
        if self.flags is None:
            raise ImageError(
                "a bare image does not say which bytes are program; compile its source instead"
            )
        return self.flags
