"""Everything in a chip but time: registers, pins, EEPROM, scratch pad, where the program is."""

from cgagen.emulator.expressions import Evaluator
from cgagen.emulator.memory import Memory
from cgagen.emulator.pins import PINS, SIN, Pins
from cgagen.emulator.polling import Polling
from cgagen.emulator.registers import Registers
from cgagen.emulator.timing import Timing
from cgagen.emulator.unknowns import Unknowns
from cgagen.emulator.wires import Wire
from cgagen.stamp.chips import Chip as Model

GOSUB_LEVELS = 4
"""Ref: S2 p. 210; a fifth GOSUB loses the first."""

_SMALL_PAD = 64

_FIRST_STATUS = 127
"""From here on the scratch pad of a BS2p shows the chip. Ref: S2 p. 93."""


class Machine:
    """The state of one chip between instructions, and what its instructions do to it.

    Attributes:
        model: the chip's row.
        timing: its durations.
        pins: the pins that INS, OUTS and DIRS mean now, see AUXIO.
        registers: the register file.
        scratch: the bytes that PUT can write.
        memory: the EEPROM.
        evaluator: evaluates expressions on the registers.
        slot: program slot that runs.
        store_slot: slot that READ and WRITE use.
        pc: stream address of the next instruction.
        gosubs: numbers of the GOSUBs that have not returned, at most four.
        polling: polled inputs and outputs.
    """

    def __init__(
        self,
        model: Model,
        memory: Memory,
        pins: Pins,
        timing: Timing,
        unknowns: Unknowns,
    ) -> None:
        self.model = model
        self.timing = timing
        self.unknowns = unknowns
        self.memory = memory
        self.pins = self.main_pins = pins
        self.aux_pins = Pins(f"{pins.owner}.aux")
        # Not led out, and pulled up in the chip. Ref: S2 p. 129.
        self.aux_pins.wires[:PINS] = [
            Wire(f"{pins.owner}.aux.P{pin}", pull=1) for pin in range(PINS)
        ]
        self.groups = (self.main_pins, self.aux_pins)
        self.registers = Registers(pins)
        self.evaluator = Evaluator(self.registers, unknowns)
        self.scratch = bytearray(model.scratch_bytes)
        self.gosubs: list[int] = []
        self.clear()

    def clear(self) -> None:
        """Go to the state after a reset. Ref: S2 p. 83; scratch pad and slot: choice."""
        self.registers.words[:] = [0] * len(self.registers.words)
        for pins in self.groups:
            pins.restore(0, 0)
        self.choose_port(auxiliary=False)
        self.scratch[:] = bytes(len(self.scratch))
        self.polling = Polling()
        self.last_return = 0
        self.gosubs.clear()
        self.slot = self.store_slot = 0
        self.pc = self.start()

    def start(self) -> int:
        """Return where the running slot's program starts."""
        return self.memory.slots[self.slot].header(0)

    def call(self, number: int) -> None:
        """Remember a GOSUB by its number."""
        self.gosubs.append(number)
        if len(self.gosubs) > GOSUB_LEVELS:
            del self.gosubs[0]

    def returned(self) -> int:
        """Take the last GOSUB back; returns where the program goes on.

        With none, number 0 is taken: that slot of the header is the start.
        """
        if self.gosubs:
            self.last_return = self.gosubs.pop()
            return self.memory.slots[self.slot].header(self.last_return)
        stray = 0 if self.unknowns.stray_return_restarts else self.last_return
        return self.memory.slots[self.slot].header(stray)

    def run_slot(self, slot: int) -> int:
        """Change to another program slot; returns where it starts.

        A number past the last slot wraps, and READ and WRITE use the new slot (choice, both).
        """
        self.slot = self.store_slot = slot % self.model.slots
        if self.unknowns.run_clears_gosubs:
            self.gosubs.clear()
        return self.start()

    def use_slot(self, slot: int) -> None:
        """Carry out STORE; a number past the last slot wraps (choice)."""
        self.store_slot = slot % len(self.memory.slots)

    def read(self, location: int) -> int:
        """Carry out READ; the location wraps at the slot's end (choice)."""
        return self.memory.slots[self.store_slot].data[location & 0x7FF]

    def get(self, location: int) -> int:
        """Carry out GET. The last bytes of the scratch pad show the chip's own state.

        Locations wrap at 64 on BS2e and BS2sx; on BS2p and BS2pe those from 136 to 255 read 0
        and then they wrap (choice).
        """
        size = len(self.scratch)
        if size == _SMALL_PAD:
            location %= _SMALL_PAD
            return self.slot if location == _SMALL_PAD - 1 else self.scratch[location]
        location &= 0xFF
        if location < _FIRST_STATUS:
            return self.scratch[location]
        return self._status(location)

    def put(self, location: int, value: int) -> None:
        """Carry out PUT; what shows the chip's own state cannot be written. Ref: S2 p. 92."""
        if len(self.scratch) == _SMALL_PAD:
            location %= _SMALL_PAD
        location &= 0xFF
        if location < (_SMALL_PAD - 1 if len(self.scratch) == _SMALL_PAD else _FIRST_STATUS):
            self.scratch[location] = value & 0xFF

    def choose_port(self, auxiliary: bool) -> None:
        """Carry out MAINIO, AUXIO, IOTERM: which pins INS, OUTS and DIRS are.

        The auxiliary port of a chip with 24 pins is not led out: latches, and pull-ups that read 1.
        """
        self.pins = self.registers.pins = self.groups[auxiliary]
        # The programming port is the same one, on whatever wires it is now.
        self.aux_pins.wires[SIN] = self.main_pins.wires[SIN]
        self.aux_pins.sout = self.main_pins.sout

    def place(self, pin: int) -> int:
        """Return a pin of the port that is chosen as a place for `Polling`."""
        return pin + PINS * (self.pins is self.aux_pins)

    def _status(self, location: int) -> int:
        seen, mode, run_slot, flags = self.polling.status()
        port = int(self.pins is self.aux_pins)
        shown = (self.store_slot << 4 | self.slot, *seen, mode, run_slot, port, flags)
        place = location - _FIRST_STATUS
        return shown[place] if place < len(shown) else 0


def pin_number(value: int) -> int:
    """Return the pin that a number computed at run time means: it wraps at 16 (choice)."""
    return value % PINS
