"""What a chip lends to an instruction that takes time or touches pins.

Such an instruction is a generator function with the signature::

    def pulsout(port: Port, *, duration: int, pin: int) -> Command[Result]
    def serout(port: Port, items: Sequence[OutputItem], *, baud: int, pin: int, pace: int = 0)
        -> Command[Result]

Its keyword arguments are the names in the instruction's row of `cgagen.stamp.opcodes`, evaluated
to 16-bit words before it starts; where the row has a list, the items come second. Arguments
whose name ends in `_target` are stream addresses, or None where the source has no label.

When it starts, the time that the chip takes to fetch the instruction (without its list) is over.
It yields requests; see `cgagen.emulator.requests`. It never keeps a level between two requests
and never keeps state outside its own frame, so that a chip in the middle of it can be restored.
"""

from collections.abc import Sequence
from typing import NamedTuple, Protocol

from cgagen.emulator.pins import SIN, Pins
from cgagen.emulator.timing import Timing
from cgagen.stamp.chips import Chip

PROGRAMMING_PORT = SIN
"""Where serial instructions find SIN and SOUT: `Until(16, ...)` and `pins.level(16)` mean SIN."""


class Jump(NamedTuple):
    """The result of an instruction that goes on elsewhere: SERIN whose time is over."""

    address: int


Result = int | Jump | None
"""A number is stored in the instruction's variable (PULSIN, RCTIME, COUNT)."""


class OutputItem(Protocol):
    """One item of a list that is sent, or one pair of SHIFTOUT and XOUT.

    Attributes:
        fetch_ns: what the chip takes to read the item from its EEPROM and to evaluate it, just
            before the item is sent.
    """

    @property
    def fetch_ns(self) -> int:
        """Nanoseconds."""
        ...

    def values(self) -> tuple[int, ...]:
        """Evaluate it now: one to three words, the deepest of the stack first."""
        ...


class InputItem(Protocol):
    """One item of a list that is received.

    Attributes:
        fetch_ns: see `OutputItem`.
        stores: a value that is received goes somewhere.
    """

    @property
    def fetch_ns(self) -> int:
        """Nanoseconds."""
        ...

    @property
    def stores(self) -> bool:
        """Whether `store` does anything."""
        ...

    def values(self) -> tuple[int, ...]:
        """Evaluate what is on the stack now; nothing for a plain variable."""
        ...

    def store(self, value: int) -> None:
        """Store what was received, cut to the variable's size."""
        ...


class RegisterBytes(Protocol):
    """The register file, byte by byte: STR reads and writes it so. Numbers wrap at 32."""

    def read_byte(self, element: int) -> int:
        """Read a register byte; 6 is B0."""
        ...

    def write_byte(self, element: int, value: int) -> None:
        """Write a register byte."""
        ...


class Port(Protocol):
    """What an instruction sees of its chip.

    Attributes:
        model: the chip's row.
        pins: sixteen pins and the programming port (`pins.send(level)` sets SOUT).
        timing: units and durations.
        registers: for STR and WAITSTR.
        scratch: scratch pad RAM, `model.scratch_bytes` of it; for SPSTR.
    """

    @property
    def model(self) -> Chip:
        """See above."""
        ...

    @property
    def pins(self) -> Pins:
        """See above."""
        ...

    @property
    def timing(self) -> Timing:
        """See above."""
        ...

    @property
    def registers(self) -> RegisterBytes:
        """See above."""
        ...

    @property
    def scratch(self) -> bytearray:
        """See above."""
        ...


Items = Sequence[OutputItem]
Inputs = Sequence[InputItem]
