"""The lists in square brackets: what the items of SEROUT, SERIN and their relatives stand for.

The words of an item are the tokenizer's (Ref: S3); what they do is the manual's (Ref: S2 p. 163,
164, 404). How bytes come and go is the business of the instruction.
"""

from typing import Protocol

from cgagen.emulator.commands.formatters import NUMBER, NumberReader, text_of
from cgagen.emulator.port import InputItem, Inputs, Port
from cgagen.emulator.requests import Command
from cgagen.errors import ExecutionError

_LENGTH_GIVEN = 0x200  # WAITSTR with a length
_TO_ZERO = 0x200  # STR sent up to a zero byte
_END_GIVEN = 0x200  # STR received up to an end character
_REGISTER = 0x1F
_SKIP = 0x400
_WAIT_STRING = 0x800
_WAIT = 0xC00
_SCRATCH = 0x1000

REGISTER_BYTES = 32

_SCRATCH_ROOM = 127
"""Bytes of the scratch pad that can be written, on the chips with SPSTR. Ref: S2 p. 93."""

_BYTE = 0xFF


def bytes_of(port: Port, values: tuple[int, ...]) -> bytes:
    """Return the bytes that an output item sends.

    Raises:
        ExecutionError: a number in radix 1, or a list that the tokenizer cannot have made.
    """
    match values:
        case (value,):
            return bytes([value & _BYTE])
        case (form, value) if form & NUMBER:
            return text_of(form, value)
        case (start, length):
            return _string(port, start & _REGISTER, length, bool(start & _TO_ZERO))
        case (value, _, length):
            return bytes([value & _BYTE]) * length
    raise ExecutionError(f"an output item has {len(values)} values; compile the program anew")


def _string(port: Port, start: int, length: int, to_zero: bool) -> bytes:
    """Read a string from the registers; up to a zero byte it never leaves them."""
    if to_zero:
        length = min(length, REGISTER_BYTES - start)
    text = bytes(
        port.registers.read_byte((start + index) % REGISTER_BYTES) for index in range(length)
    )
    return text.partition(b"\0")[0] if to_zero else text


class Receiver(Protocol):
    """Where an input list takes its bytes from."""

    def byte(self) -> Command[int]:
        """Receive one byte."""
        ...

    def busy(self, ns: int) -> Command[None]:
        """Spend time with something else than receiving."""
        ...


def receive(port: Port, items: Inputs, receiver: Receiver) -> Command[None]:
    """Work off an input list.

    Raises:
        ExecutionError: an item that the tokenizer cannot have made.
    """
    for item in items:
        yield from receiver.busy(item.fetch_ns)
        values = item.values()
        if not item.stores:
            yield from _receive_special(port, values, receiver)
        elif not values:
            item.store((yield from receiver.byte()))
        else:
            yield from _receive_number(item, values[0], receiver)


def _receive_number(item: InputItem, form: int, receiver: Receiver) -> Command[None]:
    number = NumberReader(form)
    while not number.take((yield from receiver.byte())):
        pass
    item.store(number.value)


def _receive_special(port: Port, values: tuple[int, ...], receiver: Receiver) -> Command[None]:
    """Receive what goes nowhere, or into an array or the scratch pad."""
    if len(values) < 2:
        raise ExecutionError("an input item has too few values; compile the program anew")
    *before, kind, length = values
    if kind & _SCRATCH:
        yield from _receive_scratch(port, length, receiver)
    elif kind & _WAIT == _WAIT:
        yield from _wait(bytes(value & _BYTE for value in reversed(before)), receiver)
    elif kind & _WAIT_STRING:
        to_zero = not kind & _LENGTH_GIVEN
        yield from _wait(_string(port, kind & _REGISTER, length, to_zero), receiver)
    elif kind & _SKIP:
        for _ in range(length):
            yield from receiver.byte()
    else:
        end = before[0] & _BYTE if kind & _END_GIVEN and before else None
        yield from _receive_string(port, kind & _REGISTER, length, end, receiver)


def _receive_string(
    port: Port, start: int, length: int, end: int | None, receiver: Receiver
) -> Command[None]:
    """STR: the end character is not stored, zeros fill what is left. Ref: S2 p. 404."""
    ended = False
    for index in range(length):
        byte = 0
        if not ended:
            byte = yield from receiver.byte()
            ended = byte == end
        port.registers.write_byte((start + index) % REGISTER_BYTES, 0 if ended else byte)


def _receive_scratch(port: Port, length: int, receiver: Receiver) -> Command[None]:
    """SPSTR: what does not fit below the read-only locations is received and lost."""
    if len(port.scratch) < _SCRATCH_ROOM:
        raise ExecutionError(f"a {port.model.name} has no SPSTR; use a BS2p or a BS2pe")
    for index in range(length):
        byte = yield from receiver.byte()
        if index < _SCRATCH_ROOM:
            port.scratch[index] = byte


def _wait(text: bytes, receiver: Receiver) -> Command[None]:
    """WAIT and WAITSTR: the last bytes are the text. Ref: choice for bytes that overlap."""
    latest = b""
    while latest != text:
        latest = (latest + bytes([(yield from receiver.byte())]))[-len(text) :]
