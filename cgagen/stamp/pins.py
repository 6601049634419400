"""Pins that a program names as constants, and that the chip does not have.

The tokenizer accepts `HIGH 16`; what the chip then does is not documented. The check reads the
program's own bits, so that a pin named through CON or PIN is seen too, and a pin that is
computed at run time never gives a false alarm.
"""

from typing import NamedTuple

from cgagen.stamp.chips import Chip
from cgagen.stamp.decode import head_at
from cgagen.stamp.opcodes import OPCODES
from cgagen.stamp.program import constant_of

LAST_PIN = 15
PROGRAMMING_PORT = 16
"""SEROUT and SERIN know the programming port as pin 16. Ref: S2 p. 419."""

_PINS = frozenset({"pin", "flow_pin", "data_pin", "clock_pin", "zero_pin"})
"""What the table of opcodes calls a pin among the operands."""

INSTRUCTIONS_WITH_PINS = frozenset(
    row.word for row in OPCODES if any(_PINS.intersection(form) for form in row.forms)
)
"""Words that start a statement with a pin among its operands."""


class WrongPin(NamedTuple):
    """A constant pin that does not exist, and the last one that does in its place."""

    pin: int
    last: int


def wrong_pin(stream: str, bit: int, model: Chip) -> WrongPin | None:
    """Return the first impossible pin of the instruction that starts at a stream bit.

    Args:
        stream: see `stream_of`.
        bit: where a statement's first token is.
        model: the chip; opcodes differ.

    Raises:
        ImageError: no instruction of this chip starts there.
    """
    head = head_at(stream, bit, model)
    for name, operand in zip(head.form, head.operands, strict=True):
        pin = constant_of(operand) if name in _PINS else None
        if pin is not None and pin > LAST_PIN:
            serial = name == "pin" and head.opcode.word in ("SERIN", "SEROUT")
            if not serial or pin > PROGRAMMING_PORT:
                return WrongPin(pin, PROGRAMMING_PORT if serial else LAST_PIN)
    return None
