"""A Stamp's programming port for tests of the programmer, written from the documents.

It shares no code with the emulator and none with the programmer but the table of models' names.
Bytes cross the line twice, out to the chip and back as echo; every crossing has a number, and a
fault can be laid on any of them.
"""

import errno
import random
from collections.abc import Callable
from dataclasses import dataclass, field
from enum import Enum

import serial

BYTE_S = 10 / 9600
ANSWER_S = 0.0012
WRITE_S = 0.008
ATN_LEAST_S = 0.002
BREAK_LEAST_S = 0.036

# model: (greeting, challenge for the version, its answer, does it take a slot byte)
MODELS: dict[str, tuple[list[tuple[int, int]], int, int, bool]] = {
    "BS2": ([(0x42, 0xBE), (0x53, 0xAD), (0x32, 0xCE)], 0x00, 0x10, False),
    "BS2e": ([], 0x65, 0x66, True),
    "BS2sx": ([], 0x58, 0x5A, True),
    "BS2p24": ([], 0x50, 0x74, True),
    "BS2p40": ([], 0x50, 0x52, True),
    "BS2pe24": ([], 0x49, 0x6A, True),
}


class SimClock:
    """Time that passes only when somebody waits."""

    def __init__(self) -> None:
        self.time_s = 100.0

    def now_s(self) -> float:
        return self.time_s

    def sleep(self, seconds: float) -> None:
        self.time_s += seconds


class Kind(Enum):
    LOST = "lost"
    DOUBLED = "doubled"
    FLIPPED = "flipped"
    LATE = "late"
    VERY_LATE = "very late"
    UNPLUGGED = "unplugged"
    RESET = "reset"
    POWER_OFF = "power off"


@dataclass
class Fault:
    """What happens at one crossing, or at every one from there on with a period."""

    kind: Kind
    position: int
    every: int = 0

    def strikes(self, crossing: int) -> bool:
        if self.every:
            return crossing >= self.position and (crossing - self.position) % self.every == 0
        return crossing == self.position


@dataclass
class FakeChip:
    """The chip: loader and EEPROM.

    `program` is what runs: called with the chip at each start, it returns bytes with their delay
    in seconds; `hears` is called with each byte that reaches a running program. A deaf chip finds
    every packet broken; one that does not start by itself takes no notice of the sign-off.
    """

    name: str
    program: Callable[["FakeChip"], list[tuple[float, int]]] = lambda chip: []
    hears: Callable[["FakeChip", int], list[tuple[float, int]]] = lambda chip, byte: []
    atn_works: bool = True
    worn_block: int | None = None
    write_s: float = WRITE_S
    deaf: bool = False
    starts_by_itself: bool = True
    slots: dict[int, bytearray] = field(default_factory=dict)
    state: str = "runs"
    starts: int = 0
    writes: list[int] = field(default_factory=list)
    powered: bool = True

    def __post_init__(self) -> None:
        self.slots = {n: bytearray(b"\xff" * 2048) for n in range(8 if MODELS[self.name][3] else 1)}
        self._greeted = 0
        self._slot = 0
        self._packet = bytearray()

    def reset(self, in_break: bool) -> list[tuple[float, int]]:
        self._greeted, self._packet, self._slot = 0, bytearray(), 0
        if in_break:
            self.state = "called"
            return []
        return self.start()

    def start(self) -> list[tuple[float, int]]:
        self.state = "runs"
        self.starts += 1
        return self.program(self)

    def receive(self, byte: int) -> list[tuple[float, int]]:
        if not self.powered:
            return []
        greeting, version, answer, takes_slot = MODELS[self.name]
        if self.state == "runs":
            return self.hears(self, byte)
        if self.state == "called":
            if self._greeted < len(greeting):
                challenge, reply = greeting[self._greeted]
                if byte != challenge:
                    return []
                self._greeted += 1
                return [(ANSWER_S, reply)]
            if byte != version:
                return []
            self.state = "slot" if takes_slot else "packets"
            return [(ANSWER_S, answer)]
        if self.state == "slot":
            self._slot, self.state = byte, "packets"
            return []
        if not self._packet and byte < 0x80:
            return self.start() if self.starts_by_itself else []
        self._packet.append(byte)
        if len(self._packet) < 18:
            return []
        packet, self._packet = bytes(self._packet), bytearray()
        if self.deaf or sum(packet) & 0xFF or self._slot not in self.slots:
            return [(ANSWER_S, 1)]
        block = packet[0] & 0x7F
        if block == self.worn_block:
            return [(self.write_s, 2)]
        self.slots[self._slot][block * 16 : block * 16 + 16] = packet[1:17]
        self.writes.append(block)
        return [(self.write_s, 0)]


class FakePort:
    """A pyserial-like port with a chip on it, against a clock."""

    def __init__(
        self,
        chip: FakeChip,
        clock: SimClock,
        faults: tuple[Fault, ...] = (),
        *,
        echoes: int = 1,
        timeout: float = 0.05,
        noise_every_s: float = 0.0,
    ) -> None:
        self.chip = chip
        self.clock = clock
        self.faults = faults
        self.crossings = 0
        self.unplugged = False
        self.timeout = timeout
        self.sent = bytearray()
        self._echoes = echoes
        self._noise_every_s = noise_every_s
        self._noise_s = clock.now_s()
        self._chance = random.Random(5)
        self._arriving: list[tuple[float, int]] = []
        self._line_free_s = clock.now_s()
        self._atn_s = 0.0
        self._break_s = 0.0
        self._dtr = False
        self._break = False
        self._reset_in_break = False

    # -- Lines of control ---------------------------------------------------------------------

    @property
    def dtr(self) -> bool:
        return self._dtr

    @dtr.setter
    def dtr(self, on: bool) -> None:
        self._plugged()
        now_s = self.clock.now_s()
        if on and not self._dtr:
            self._atn_s = now_s
        if self._dtr and not on and now_s - self._atn_s >= ATN_LEAST_S and self.chip.atn_works:
            self._cut(now_s)
            self.schedule(now_s, self.chip.reset(self._break) if self.chip.powered else [])
            self._reset_in_break = self._break
            self._break_s = now_s
        self._dtr = on

    @property
    def break_condition(self) -> bool:
        return self._break

    @break_condition.setter
    def break_condition(self, on: bool) -> None:
        self._plugged()
        now_s = self.clock.now_s()
        if self._break and not on:
            if self._reset_in_break and now_s - self._break_s < BREAK_LEAST_S:
                self.schedule(now_s, self.chip.start())
            self._arriving.append((now_s + 0.016, 0))
            self._arriving.sort()
        self._break = on

    # -- Bytes --------------------------------------------------------------------------------

    @property
    def in_waiting(self) -> int:
        self._plugged()
        self._babble(self.clock.now_s())
        return sum(1 for at_s, _ in self._arriving if at_s <= self.clock.now_s())

    def write(self, data: bytes) -> int:
        self._plugged()
        for byte in data:
            self.sent.append(byte)
            start_s = max(self.clock.now_s(), self._line_free_s)
            self._line_free_s = at_s = start_s + BYTE_S
            crossing = self._cross(byte, at_s)
            self._line_free_s = at_s = at_s + self._late_s
            for crossed in crossing:
                answers = self.chip.receive(crossed)
                for _ in range(self._echoes if self.chip.powered else 0):
                    self._back(crossed, at_s)
                self.schedule(at_s, answers)
        return len(data)

    def read(self, size: int = 1) -> bytes:
        self._plugged()
        deadline_s = self.clock.now_s() + self.timeout
        self._babble(deadline_s)
        found = bytearray()
        while len(found) < size:
            if not self._arriving or self._arriving[0][0] > deadline_s:
                self.clock.sleep(max(0.0, deadline_s - self.clock.now_s()))
                break
            at_s, byte = self._arriving.pop(0)
            self.clock.sleep(max(0.0, at_s - self.clock.now_s()))
            found.append(byte)
        self._plugged()
        return bytes(found)

    def reset_input_buffer(self) -> None:
        self._plugged()
        now_s = self.clock.now_s()
        self._arriving = [one for one in self._arriving if one[0] > now_s]

    def close(self) -> None:
        pass

    # -- Inside -------------------------------------------------------------------------------

    def _plugged(self) -> None:
        if self.unplugged:
            raise serial.SerialException(errno.EIO, "device disconnected")

    def _babble(self, until_s: float) -> None:
        """Somebody else talks on the line."""
        while self._noise_every_s and self._noise_s + self._noise_every_s <= until_s:
            self._noise_s += self._noise_every_s
            self._arriving.append((self._noise_s, self._chance.randrange(256)))
            self._arriving.sort(key=lambda one: one[0])

    def schedule(self, at_s: float, answers: list[tuple[float, int]]) -> None:
        for delay_s, byte in answers:
            self._back(byte, at_s + delay_s + BYTE_S)

    def _back(self, byte: int, at_s: float) -> None:
        for crossed in self._cross(byte, at_s):
            late_s = self._late_s
            self._arriving.append((at_s + late_s, crossed))
        # An adapter that is late with one byte is late with all behind it.
        self._arriving.sort(key=lambda one: one[0])

    def _cut(self, now_s: float) -> None:
        """A reset ends what the program was about to say."""
        self._arriving = [one for one in self._arriving if one[0] <= now_s + 2 * BYTE_S]

    def _cross(self, byte: int, at_s: float) -> list[int]:
        crossing, self.crossings = self.crossings, self.crossings + 1
        self._late_s = 0.0
        for fault in self.faults:
            if not fault.strikes(crossing):
                continue
            match fault.kind:
                case Kind.LOST:
                    return []
                case Kind.DOUBLED:
                    return [byte, byte]
                case Kind.FLIPPED:
                    return [byte ^ (1 << crossing % 8)]
                case Kind.LATE:
                    self._late_s = 0.3
                case Kind.VERY_LATE:
                    self._late_s = 2.5
                case Kind.UNPLUGGED:
                    self.unplugged = True
                case Kind.RESET:
                    self.schedule(at_s, self.chip.reset(in_break=False))
                case Kind.POWER_OFF:
                    self.chip.powered = False
                    return []
        return [byte]
