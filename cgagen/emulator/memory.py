"""The EEPROM slots of a chip, and the instructions that were found in them so far."""

from collections.abc import Callable, Sequence

from cgagen.errors import ImageError
from cgagen.stamp.chips import EEPROM_BYTES, Chip
from cgagen.stamp.decode import decode_stream
from cgagen.stamp.program import Instruction
from cgagen.stamp.stream import address_at, stream_of

ADDRESS_BITS = 14
_DATA_SLOTS = {"BS2pe": 8}
"""Slots for STORE alone, behind the program slots. Ref: S5 (STOREALL)."""


class Slot:
    """One slot: its bytes and what was decoded from them.

    Attributes:
        data: the bytes; change them with `write` alone.
    """

    __slots__ = ("_decoded", "_frozen", "_lowest", "_model", "_returns", "_stream", "data")

    def __init__(self, model: Chip, data: bytes) -> None:
        self._model = model
        self._lowest = EEPROM_BYTES
        self.load(data)

    def load(self, data: bytes) -> None:
        """Put other bytes in, all of them."""
        self.data = bytearray(data)
        self._frozen: bytes | None = None
        self._stream = ""
        self._forget()

    def at(self, address: int) -> Instruction:
        """Return the instruction at a stream bit.

        Raises:
            ImageError: there is none.
        """
        found = self._decoded.get(address)
        if found is None:
            found = decode_stream(self._bits(), address, self._model)
            self._decoded[address] = found
            self._lowest = min(self._lowest, EEPROM_BYTES - 1 - (found.end - 1) // 8)
        return found

    def header(self, number: int) -> int:
        """Return the address in a slot of the header: 0 is the start, then GOSUB 1, 2, ..."""
        found = self._returns.get(number)
        if found is None:
            found = address_at(self._bits(), ADDRESS_BITS * number)
            self._returns[number] = found
        return found

    def frozen(self) -> bytes:
        """Return the bytes as they are now; the same object while nothing is burned."""
        if self._frozen is None:
            self._frozen = bytes(self.data)
        return self._frozen

    def write(self, location: int, value: int) -> bool:
        """Burn a byte; returns whether that may have changed an instruction that was decoded."""
        if self.data[location] == value:
            return False
        self.data[location] = value
        self._frozen = None
        self._stream = ""
        hit = location >= self._lowest or location >= EEPROM_BYTES - 512  # 512: longest header
        if hit:
            self._forget()
        return hit

    def _forget(self) -> None:
        self._decoded: dict[int, Instruction] = {}
        self._returns: dict[int, int] = {}
        self._lowest = EEPROM_BYTES

    def _bits(self) -> str:
        if not self._stream:
            self._stream = stream_of(bytes(self.data))
        return self._stream


class Memory:
    """All slots of a chip.

    Args:
        model: the chip's row.
        slots: bytes by slot number; the others are erased, all 0.
        changed: told the number of a slot whose program was written over.

    Raises:
        ImageError: a slot that the model does not have, or a wrong number of bytes.
    """

    def __init__(
        self, model: Chip, slots: dict[int, bytes], changed: Callable[[int], None]
    ) -> None:
        count = model.slots + _DATA_SLOTS.get(model.name, 0)
        for number, data in slots.items():
            if not 0 <= number < count or len(data) != EEPROM_BYTES:
                raise ImageError(
                    f"slot {number} with {len(data)} bytes does not fit a {model.name}; give "
                    f"{EEPROM_BYTES} bytes for a slot from 0 to {count - 1}"
                )
        self.slots = [Slot(model, slots.get(n, bytes(EEPROM_BYTES))) for n in range(count)]
        self._changed = changed

    def write(self, slot: int, location: int, value: int) -> None:
        """Burn a byte of a slot; the location wraps at the slot's end (choice)."""
        if self.slots[slot].write(location & EEPROM_BYTES - 1, value & 0xFF):
            self._changed(slot)

    def images(self) -> tuple[bytes, ...]:
        """Return the bytes of all slots."""
        return tuple(slot.frozen() for slot in self.slots)

    def load(self, images: Sequence[bytes]) -> None:
        """Put bytes back that `images` returned."""
        for number, (slot, data) in enumerate(zip(self.slots, images, strict=True)):
            if slot.frozen() is not data and slot.data != data:
                slot.load(data)
                self._changed(number)
