"""The loader in a chip's ROM, and the ATN circuit that gets into it.

A host asserts DTR and holds its line at space (BREAK); a reset that ends with the line still at
space leads into the loader, any other reset into the program. The loader tells the model,
takes packets and answers each. A byte without bit 7 where a packet could begin ends it, and the
program starts as after any reset.

Every byte that the host sends comes back to it by the wiring alone (`Uart.echo`); the loader
knows nothing of that. While it answers or burns it hears nothing, as a chip that has its bits
timed by its program. Durations are the bench's.

`cgagen.emulator.host_port.HostPort` is the computer's side of it. Ref: S18, S19,
S17; FIDELITY.md says what of it is doubtful.
"""

from collections.abc import Callable
from enum import StrEnum
from typing import ClassVar

from cgagen.emulator.chip import Chip
from cgagen.emulator.clock import Clock
from cgagen.emulator.parts.part import Part
from cgagen.emulator.parts.uart import BAUD, Uart
from cgagen.emulator.pins import SIN, Pins
from cgagen.emulator.rom import identity
from cgagen.stamp.packets import BLOCK_BYTES, PACKET_BYTES

ATN_NS = 2_000_000
"""A shorter pulse on ATN does not reset. Ref: S18 (a host holds it for 2 ms at least)."""

LOOK_NS = 36_000_000
"""The line must be at space for so long behind the reset. Ref: S18 (a host waits that)."""

PULSE_NS = 5_000_000
"""What a capacitor between DTR and ATN makes of an edge. Choice."""

BIT_NS = 1_000_000_000 // BAUD
"""From the middle of a stop bit to an answer, or to the program's start. Choice: one bit."""

BURN_NS = 10_000_000
"""The EEPROM's time for one block. Choice: the most that its kind takes."""

GOOD, MISHEARD, UNBURNED = 0, 1, 2
"""What a packet is answered with. Ref: S18."""

PACKET_BIT = 0x80


class Atn(StrEnum):
    """What lies between a computer's DTR and a chip's ATN."""

    DIRECT = "direct"
    """Asserted is reset, for as long as it lasts. Ref: S9 (1.8) p. 308; S18."""
    CAPACITOR = "capacitor"
    """An edge to asserted is a short reset. Ref: S9 (1.8) p. 308, two of 0.1 uF; most boards
    have them, as far as we know. bs2-serial leaves DTR asserted and needs them."""


class Phase(StrEnum):
    """Where a chip is between two bytes."""

    RUNNING = "running"
    HELD = "held"
    LOOKING = "looking"
    """The reset is over, and the line is still at space."""
    IDENTIFY = "identify"
    SLOT = "slot"
    PACKETS = "packets"


class RomLine(Uart):
    """The loader's own bits on SIN and SOUT."""

    def __init__(self, name: str, clock: Clock, pins: Pins) -> None:
        self._pins = pins
        super().__init__(name, clock, pins.sout, pins.wires[SIN], mark=0)

    def _drive(self, bit: int) -> None:
        self._pins.send(1 - bit)


class Loader(Part):
    """The ROM of one chip; made by `HostPort`, or by hand with its line added to the bench first.

    Args:
        chip: whose it is.
        line: its bits.
        atn: the board's circuit.
        legs: 24 or 40.
        version: place of the firmware's version among those of the model.

    Attributes:
        phase: where it is.
        slot: the program slot that packets go into.
        packets: that were answered with 00 since the chip was made.
        bad_blocks: blocks that the EEPROM does not take, for tests.
        on_change: told a slot that holds other bytes than before.

    Raises:
        BenchError: no such model.
    """

    CIRCUIT: ClassVar[frozenset[str]] = frozenset({"chip", "on_change"})

    def __init__(
        self,
        chip: Chip,
        line: RomLine,
        atn: Atn = Atn.CAPACITOR,
        legs: int = 24,
        version: int = 0,
    ) -> None:
        super().__init__(f"{chip.name}_rom", chip.clock)
        self.chip = chip
        self.on_change: Callable[[int], None] = _nothing
        self.phase = Phase.RUNNING
        self.slot = 0
        self.packets = 0
        self.bad_blocks: frozenset[int] = frozenset()
        known = identity(chip.machine.model.name, legs)
        self._challenge = known.challenge
        self._version = known.versions[version]
        self._atn = atn
        self._dtr = False
        self._known = 0
        self._half = b""
        self._answer = 0
        self._line = line
        line.heard = self._hear
        chip.pins.wires[SIN].listen(self._line_changed)
        self._taken = self.timer(self._take)
        self._pulse_over = self.timer(self._released)
        self._looked = self.timer(self._enter)
        self._speak = self.timer(self._say)
        self._burned = self.timer(self._burn)
        self._ending = self.timer(self.start)

    # -- What the board does ------------------------------------------------------------------

    @property
    def dtr(self) -> bool:
        """Whether the computer asserts DTR."""
        return self._dtr

    @dtr.setter
    def dtr(self, asserted: bool) -> None:
        if asserted == self._dtr:
            return
        self._dtr = asserted
        if asserted:
            self._taken.after(ATN_NS)
            if self._atn is Atn.CAPACITOR:
                self._pulse_over.after(PULSE_NS)
        elif self._atn is Atn.DIRECT:
            self._released()

    @property
    def settled(self) -> bool:
        """Whether nothing is about to happen by itself: no reset, no answer, no burning."""
        return not self._timed and not self._line.sending

    @property
    def listening(self) -> bool:
        """Whether the loader waits for a byte."""
        return self.settled and self.phase in (Phase.IDENTIFY, Phase.SLOT, Phase.PACKETS)

    # -- Reset --------------------------------------------------------------------------------

    @property
    def _timed(self) -> bool:
        return any(timer.due_ns is not None for timer in self._timers)

    def _take(self) -> None:
        """ATN has been asserted for long enough."""
        self._give_up()
        self.phase = Phase.HELD
        self.chip.hold()

    def _released(self) -> None:
        self._taken.cancel()
        if self.phase is not Phase.HELD:
            return
        if self.chip.pins.wires[SIN].level:
            self.phase = Phase.LOOKING
            self._looked.after(LOOK_NS)
        else:
            self.start()

    def _line_changed(self, level: int | None) -> None:
        if self.phase is Phase.LOOKING and not level:
            self.start()

    def _enter(self) -> None:
        self.phase = Phase.IDENTIFY
        self._known = 0

    def start(self) -> None:
        """Leave the loader for the program, which starts as after any reset."""
        self._give_up()
        self.phase = Phase.RUNNING
        self.chip.reset()

    def _give_up(self) -> None:
        for timer in (self._looked, self._speak, self._burned, self._ending):
            timer.cancel()
        self._line.drop()
        self._half = b""

    # -- Bytes --------------------------------------------------------------------------------

    def _hear(self, byte: int) -> None:
        self._line.take()
        if not self.listening:
            return
        if self.phase is Phase.IDENTIFY:
            self._identify(byte)
        elif self.phase is Phase.SLOT:
            self._choose(byte)
        else:
            self._collect(byte)

    def _identify(self, byte: int) -> None:
        """Take the next byte of the challenge; anything else is ignored."""
        if byte != self._challenge[self._known]:
            self._known = 0
            if byte != self._challenge[0]:
                return
        self._known += 1
        if self._known < len(self._challenge):
            self._reply(-byte & 0xFF)
            return
        self._reply(self._version)
        self.slot = 0
        self.phase = Phase.SLOT if self.chip.machine.model.slots > 1 else Phase.PACKETS

    def _choose(self, byte: int) -> None:
        if byte >= self.chip.machine.model.slots:
            self._ending.after(BIT_NS)
            return
        self.slot = byte
        self.phase = Phase.PACKETS

    def _collect(self, byte: int) -> None:
        if not self._half and not byte & PACKET_BIT:
            self._ending.after(BIT_NS)
            return
        self._half += bytes([byte])
        if len(self._half) == PACKET_BYTES:
            if sum(self._half) & 0xFF:
                self._half = b""
                self._reply(MISHEARD)
            else:
                self._burned.after(BURN_NS)

    def _burn(self) -> None:
        packet, self._half = self._half, b""
        block = packet[0] - PACKET_BIT
        if block in self.bad_blocks:
            self._reply(UNBURNED)
            return
        memory = self.chip.machine.memory
        before = memory.slots[self.slot].frozen()
        for place, value in enumerate(packet[1:-1], BLOCK_BYTES * block):
            memory.write(self.slot, place, value)
        if memory.slots[self.slot].frozen() != before:
            self.on_change(self.slot)
        self.packets += 1
        self._reply(GOOD)

    def _reply(self, byte: int) -> None:
        self._answer = byte
        self._speak.after(BIT_NS)

    def _say(self) -> None:
        self._line.send(bytes([self._answer]))


def _nothing(_slot: int) -> None:
    pass
