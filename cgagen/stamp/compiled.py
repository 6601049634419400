"""What the tokenizer says about one source it has accepted."""

from bisect import bisect_right
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

from cgagen.stamp.image import Image, Use

ADDRESS_BITS = 14
"""Bits of an address in the program, hence of each header slot. Ref: S3."""


class Statement(NamedTuple):
    """Where one executable statement is in the source, and in the program.

    Attributes:
        offset: characters before it in the source.
        line: from 1.
        column: from 1.
        bit: stream bit of its first token; a statement that emits nothing (ENDIF, DO, SELECT)
            has the bit of the next one.
    """

    offset: int
    line: int
    column: int
    bit: int


class SourceWarning(NamedTuple):
    """What a source says that is compiled, and hardly meant.

    Attributes:
        line: from 1.
        column: from 1.
        text: what it is and what to do, without the place.
    """

    line: int
    column: int
    text: str


class VariableCounts(NamedTuple):
    """Variables by size, elements of arrays counted singly. Fixed names (W1, B3) are not in it."""

    bits: int
    nibbles: int
    bytes: int
    words: int

    @property
    def total_bits(self) -> int:
        """Bits of RAM that the declared variables take.

        >>> VariableCounts(bits=2, nibbles=2, bytes=2, words=2).total_bits
        58
        """
        return self.bits + 4 * self.nibbles + 8 * self.bytes + 16 * self.words


@dataclass(frozen=True)
class SourceMap:
    """The statements of a program in source order, addresses ascending with them."""

    statements: tuple[Statement, ...]

    def at_bit(self, bit: int) -> Statement | None:
        """Return the statement that a stream bit belongs to; None in the header.

        Of several statements with one address, the last is the one that emitted the bit.
        """
        index = bisect_right(self._bits, bit)
        return self.statements[index - 1] if index else None

    @cached_property
    def _bits(self) -> tuple[int, ...]:
        return tuple(statement.bit for statement in self.statements)


@dataclass(frozen=True)
class Compiled:
    """One source, accepted.

    Attributes:
        name: what the source is called in messages, usually its file name.
        source: its text, as given; blanks for control characters that mean nothing.
        image: EEPROM, flags and model.
        variables: how many of each size.
        source_map: statement by statement.
        project_files: further files that `$STAMP` names, for slots 1 to 7; not compiled.
        port: the `$PORT` directive, or "".
        language: 200 for PBASIC 2.0, 250 for 2.5.
        debugs: the program has DEBUG or DEBUGIN in it.
        warnings: in the order of the source.
    """

    name: str
    source: str = field(repr=False)
    image: Image
    variables: VariableCounts
    source_map: SourceMap = field(repr=False)
    project_files: tuple[str, ...] = ()
    port: str = ""
    language: int = 200
    debugs: bool = False
    warnings: tuple[SourceWarning, ...] = ()

    @property
    def start_bit(self) -> int:
        """Stream bit of the first instruction: the program's first 14 bits say it. Ref: S3."""
        first = self.image.eeprom[-1] << 8 | self.image.eeprom[-2]
        rotated = first >> 2
        return (rotated & 0x7FF) * 8 + (rotated >> 11)

    @property
    def gosub_slots(self) -> int:
        """GOSUBs in the source, ON..GOSUB once each: every one has a return slot."""
        return self.start_bit // ADDRESS_BITS - 1

    @property
    def program_bytes(self) -> int:
        """EEPROM bytes of the program, its header included."""
        return self.image.count(Use.PROGRAM)

    @property
    def data_bytes(self) -> int:
        """EEPROM bytes that DATA takes, with and without a value."""
        return self.image.count(Use.DATA) + self.image.count(Use.RESERVED)
