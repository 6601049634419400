"""Pins that a program names as constants, and that the chip does not have.

The tokenizer accepts `HIGH 16`; what the chip then does is not documented. The check reads the
program's own bits, so that a pin named through CON or PIN is seen too, and a pin that is
computed at run time never gives a false alarm.
"""

from typing import NamedTuple

from cgagen.stamp.chips import Chip

LAST_PIN = 15
PROGRAMMING_PORT = 16
"""SEROUT and SERIN know the programming port as pin 16. Ref: S2 p. 419."""

_PIN_OPERANDS: dict[int, tuple[tuple[int, int], ...]] = {
    # opcode: (place on the stack, last pin that is legal) ... Ref: S3
    **dict.fromkeys((0x04, 0x05, 0x06, 0x07, 0x08, 0x0C), ((-1, LAST_PIN),)),  # OUTPUT .. INPUT
    **dict.fromkeys((0x16, 0x17, 0x18), ((0, LAST_PIN),)),  # FREQOUT, DTMFOUT
    0x19: ((0, LAST_PIN), (1, LAST_PIN)),  # XOUT
    0x20: ((-1, PROGRAMMING_PORT),),  # SEROUT
    0x21: ((-2, PROGRAMMING_PORT), (-1, LAST_PIN)),  # SEROUT with flow control
    0x22: ((-1, PROGRAMMING_PORT),),  # SERIN
    0x23: ((-2, PROGRAMMING_PORT), (-1, LAST_PIN)),  # SERIN with flow control
    **dict.fromkeys((0x24, 0x25, 0x26, 0x29, 0x2A, 0x2B), ((-1, LAST_PIN),)),  # PULSOUT .. PWM
    **dict.fromkeys((0x27, 0x28), ((-2, LAST_PIN), (-1, LAST_PIN))),  # SHIFTIN, SHIFTOUT
}
_PIN_OPERANDS_P = dict.fromkeys(
    # BS2p and BS2pe only: LCD.., I2C.., POLLIN, POLLOUT, OW.. Ref: S3
    (0x2C, 0x2D, 0x2E, 0x2F, 0x30, 0x31, 0x32, 0x35, 0x36, 0x38, 0x39),
    ((-1, LAST_PIN),),
)
INSTRUCTIONS_WITH_PINS = frozenset(
    "OUTPUT HIGH TOGGLE LOW REVERSE INPUT FREQOUT DTMFOUT XOUT SEROUT SERIN PULSOUT PULSIN "
    "COUNT SHIFTIN SHIFTOUT RCTIME BUTTON PWM LCDIN LCDOUT LCDCMD I2CIN I2COUT POLLIN POLLOUT "
    "OWOUT OWIN".split()
)
"""Words that start a statement with a pin among its operands. Ref: S2 chapter 5."""

_ELEMENT_BITS = (8, 6, 5, 4)
"""Bits of the element number of a bit, nibble, byte and word variable. Ref: S3."""


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
    """
    stack, opcode = _operands(stream, bit)
    places = _PIN_OPERANDS.get(opcode, ())
    if model.directive in ("BS2P", "BS2PE"):
        places = places or _PIN_OPERANDS_P.get(opcode, ())
    for place, last in places:
        pin = stack[place] if -len(stack) <= place < len(stack) else None
        if pin is not None and pin > last:
            return WrongPin(pin, last)
    return None


def _operands(stream: str, bit: int) -> tuple[list[int | None], int]:
    """Return what lies on the stack when the opcode comes (None: not constant), and the opcode."""
    stack: list[int | None] = []
    while stream[bit : bit + 1] == "1":
        code = int(stream[bit + 1 : bit + 7], 2)
        bit += 7
        if code < 0x08:  # unary
            del stack[-1:]
            stack.append(None)
        elif code < 0x20:  # binary
            del stack[-2:]
            stack.append(None)
        elif code < 0x30:
            value, bit = _constant(stream, bit, code & 15)
            stack.append(value)
        else:
            write, indexed = bool(code & 8), bool(code & 4)
            del stack[len(stack) - write - indexed :]
            if not write:
                stack.append(None)
            bit += _ELEMENT_BITS[code & 3]
    return stack, int(stream[bit + 1 : bit + 7] or "0", 2)


def _constant(stream: str, bit: int, width: int) -> tuple[int, int]:
    """Return the value of a constant of this width, and the bit behind it."""
    more = stream[bit : bit + 1] == "1"
    if width == 0:
        return (0 if more else 1), bit + 1
    if not more:
        return 1 << width, bit + 1
    return 1 << width | int(stream[bit + 1 : bit + 1 + width] or "0", 2), bit + 1 + width
