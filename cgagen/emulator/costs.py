"""What an instruction takes before it does anything, by the model of `cgagen.emulator.timing`."""

from cgagen.emulator.expressions import expression_bits, operators_ns
from cgagen.emulator.timing import Timing
from cgagen.stamp.opcodes import Tail
from cgagen.stamp.program import Instruction, Item

LISTS_LATER = frozenset(
    "DTMFOUT XOUT SEROUT SEROUT_FLOW SERIN SERIN_FLOW SHIFTIN SHIFTOUT LCDIN LCDOUT I2CIN "
    "I2CIN_LOW I2COUT I2COUT_LOW OWOUT OWIN".split()
)
"""Instructions that read an item of their list when its turn comes."""

_JUMPS = {"GOTO": 1, "GOSUB": 1, "RETURN": 2, "RUN": 1}
"""Jumps that are always taken; RETURN goes to its slot of the header first."""

_SLOT_BITS = {"RETURN": 14}
"""Bits that are read elsewhere: the address in that slot. Ref: S3 for their number."""

_RANDOM_READS = frozenset({"READ"})


def item_bits(instruction: Instruction, item: Item) -> int:
    """Return the bits of an item of a list, with those that close it and announce another.

    The operators of an input item may be none, so a bit of their own ends them. Ref: S3.
    """
    bits = expression_bits(tuple(token for value in item.values for token in value)) + 1
    if item.write is not None:
        bits += expression_bits(item.write)
    return bits + int(Tail.INPUT in instruction.opcode.tail)


def item_ns(instruction: Instruction, item: Item, timing: Timing) -> int:
    """Return what the chip takes to read and evaluate an item."""
    expressions = item.values if item.write is None else (*item.values, item.write)
    return timing.bit_ns * item_bits(instruction, item) + operators_ns(expressions, timing)


def instruction_ns(instruction: Instruction, timing: Timing) -> int:
    """Return what passes before an instruction acts, without the items of a list that waits.

    Jumps that depend on something are not in it.

    >>> from cgagen.emulator.timing import timing_of
    >>> from cgagen.stamp.chips import chip
    >>> from cgagen.stamp.decode import decode_at
    >>> led = decode_at(bytes(2044) + bytes.fromhex("140e07c0"), 14, chip("BS2"))
    >>> instruction_ns(led, timing_of(chip("BS2")))
    147400
    """
    bits = instruction.end - instruction.address + _SLOT_BITS.get(instruction.name, 0)
    expressions = instruction.operands
    if instruction.write is not None:
        expressions += (instruction.write,)
    if instruction.name in LISTS_LATER:
        bits -= sum(item_bits(instruction, item) for item in instruction.items)
    else:
        expressions += tuple(value for item in instruction.items for value in item.values)
    return (
        timing.fetch_ns
        + timing.bit_ns * bits
        + timing.jump_ns * _JUMPS.get(instruction.name, 0)
        + (timing.read_ns if instruction.name in _RANDOM_READS else 0)
        + (timing.pause_setup_ns if instruction.name == "PAUSE" else 0)
        + operators_ns(expressions, timing)
    )
