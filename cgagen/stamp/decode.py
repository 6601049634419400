"""From the bytes of an EEPROM to instructions: one at an address, or a whole program."""

from typing import NamedTuple

from cgagen.errors import ImageError
from cgagen.stamp.bits import ADDRESS_BITS, STREAM_BITS, BitReader, refused
from cgagen.stamp.chips import EEPROM_BYTES, Chip
from cgagen.stamp.grammar import Stack, read_tail
from cgagen.stamp.image import Use
from cgagen.stamp.opcodes import Opcode, opcodes_of
from cgagen.stamp.program import (
    Expression,
    Instruction,
    Program,
    constant_of,
    label_address,
)
from cgagen.stamp.stream import stream_of

_END_BITS = 7
_MOST_GOSUBS = 255


class Head(NamedTuple):
    """An instruction up to its code.

    Attributes:
        opcode: its row.
        form: the names of its operands.
        operands: expressions in the order in which they are pushed.
        write: where LET stores its value; None for anything else.
    """

    opcode: Opcode
    form: tuple[str, ...]
    operands: tuple[Expression, ...]
    write: Expression | None


def decode_at(eeprom: bytes, address: int, model: Chip) -> Instruction:
    """Return the instruction that starts at a stream bit, whatever stands around it.

    Args:
        eeprom: the 2,048 bytes of a slot, as they are now.
        address: stream bit, 0 to 16383.
        model: the chip; opcodes differ.

    Raises:
        ImageError: no instruction of this chip starts there.

    >>> from cgagen.stamp.chips import chip
    >>> led = decode_at(bytes(2044) + bytes.fromhex("140e07c0"), 14, chip("BS2"))
    >>> led.name, led.operands[0][0].value, led.end
    ('HIGH', 3, 30)
    """
    return decode_stream(stream_of(eeprom), address, model)


def decode_stream(stream: str, address: int, model: Chip) -> Instruction:
    """Return what `decode_at` returns, from a stream that was made before (`stream_of`).

    Raises:
        ImageError: see `decode_at`.
    """
    reader = BitReader(stream, address)
    opcode, form, operands, write = _head(reader, model)
    parts = read_tail(reader, opcode.tail)
    targets = tuple(parts.targets) or _label_operands(form, operands)
    return Instruction(
        address=address,
        end=reader.position,
        opcode=opcode,
        operands=operands,
        items=tuple(parts.items),
        write=write or parts.write,
        targets=targets,
        number=parts.number,
        comparison=parts.comparison,
    )


def head_at(stream: str, address: int, model: Chip) -> Head:
    """Return an instruction without what follows its code; quicker where that is enough.

    Raises:
        ImageError: see `decode_at`.
    """
    return _head(BitReader(stream, address), model)


def decode(eeprom: bytes, model: Chip, flags: bytes | None = None) -> Program:
    """Return the whole program of a slot.

    With flags the last byte of the program is known. Without, the program ends at the first
    END that nothing before jumps beyond and that zeros follow; or, where DATA follows directly,
    at the first END that nothing before jumps beyond. What could come after it cannot run.

    Args:
        eeprom: 2,048 bytes.
        model: the chip; the bytes do not tell it.
        flags: what each byte is, where the tokenizer's answer is at hand.

    Raises:
        ImageError: the bytes are no program; the sentence has the stream bit.
    """
    stream = stream_of(eeprom)
    start, slots = _header(stream)
    if flags is None:
        instructions = _walk_to_quiet_end(stream, start, slots, model)
    else:
        instructions = _walk_to_byte(stream, start, slots, _program_bits(flags), model)
    return Program(model, start, slots, tuple(instructions))


def _head(reader: BitReader, model: Chip) -> Head:
    stack = Stack()
    while reader.flag():
        here = reader.position
        stack.push(reader.token(), here, stored=False)
        if stack.write is not None and len(stack.values) > 1:
            raise refused(here, "values are left on the stack where one is stored")
    here = reader.position - 1
    code = reader.take(6)
    opcode = opcodes_of(model).get(code)
    if opcode is None:
        raise refused(here, f"a {model.name} has no instruction of code {code:02X}h")
    operands = tuple(stack.values)
    form = _checked_form(opcode, operands, stack.write, here)
    return Head(opcode, form, operands, stack.write)


def _checked_form(
    opcode: Opcode, operands: tuple[Expression, ...], write: Expression | None, bit: int
) -> tuple[str, ...]:
    """Return the names of an instruction's operands, or refuse some that it does not have."""
    if (write is not None) != (opcode.name == "LET"):
        what = "a value is stored before" if write else "no variable is named before"
        raise refused(bit, f"{what} {opcode.name}")
    form = opcode.form_of(len(operands))
    if form is None:
        wanted = " or ".join(str(len(form)) for form in opcode.forms)
        raise refused(bit, f"{opcode.name} has {len(operands)} operands instead of {wanted}")
    return form


def _label_operands(form: tuple[str, ...], operands: tuple[Expression, ...]) -> tuple[int, ...]:
    """Return the addresses among the operands of a serial instruction."""
    targets = []
    for name, operand in zip(form, operands, strict=True):
        if name.endswith("_target"):
            constant = constant_of(operand)
            address = None if constant is None else label_address(constant)
            if address is not None:
                targets.append(address)
    return tuple(targets)


def _header(stream: str) -> tuple[int, tuple[int, ...]]:
    """Return the start address and the return addresses."""
    reader = BitReader(stream, 0)
    start = reader.address()
    gosubs, rest = divmod(start, ADDRESS_BITS)
    if rest or not 1 <= gosubs <= _MOST_GOSUBS + 1:
        raise refused(0, f"no program starts at stream bit {start}")
    return start, tuple(reader.address() for _ in range(gosubs - 1))


def _program_bits(flags: bytes) -> int:
    """Return how many stream bits the flags call program."""
    used = [index for index, flag in enumerate(flags) if flag & 3 == Use.PROGRAM]
    if len(flags) != EEPROM_BYTES or not used or len(used) != EEPROM_BYTES - used[0]:
        raise ImageError(
            "the flags do not call the end of the EEPROM program; give those of this image"
        )
    return 8 * len(used)


def _walk_to_byte(
    stream: str, start: int, slots: tuple[int, ...], end: int, model: Chip
) -> list[Instruction]:
    """Decode up to the END in the last byte of the program, and zeros behind it.

    Seven zeros may be padding or one more END; they are padding where nothing jumps there, and
    the same bytes either way.
    """
    instructions: list[Instruction] = []
    farthest = max(slots, default=start)
    bit = start
    while True:
        instructions.append(decode_stream(stream, bit, model))
        bit = instructions[-1].end
        farthest = max(farthest, *instructions[-1].targets, 0)
        if bit > end or (end - bit < _END_BITS and instructions[-1].name != "END"):
            raise refused(bit - 1, f"the program does not end with END before stream bit {end}")
        if end - bit <= _END_BITS and instructions[-1].name == "END" and farthest < bit:
            break
    if "1" in stream[bit:end]:
        raise refused(bit, "the last byte of the program has something behind its END")
    return instructions


def _walk_to_quiet_end(
    stream: str, start: int, slots: tuple[int, ...], model: Chip
) -> list[Instruction]:
    """Decode up to an END that nothing needs to be looked for behind."""
    instructions: list[Instruction] = []
    farthest = max(slots, default=start)
    possible_end = 0
    bit = start
    while True:
        try:
            if bit >= STREAM_BITS:
                raise refused(bit - 1, "the program does not end with END")
            instruction = decode_stream(stream, bit, model)
        except ImageError:
            if possible_end:
                return instructions[:possible_end]
            raise
        instructions.append(instruction)
        bit = instruction.end
        farthest = max(farthest, *instruction.targets, 0)
        if instruction.name == "END" and farthest < bit:
            possible_end = possible_end or len(instructions)
            # The rest of this byte and the next whole one: no instruction starts like that.
            if "1" not in stream[bit : bit + -bit % 8 + 8]:
                return instructions
