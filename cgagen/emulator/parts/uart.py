"""A serial peer: sends bytes at a baud rate and takes what comes.

Left out: rise times, the tolerance of baud rates, and handshake lines other than one that says
"send now". A receiver samples once in the middle of a bit, where real ones vote among three.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

from cgagen.emulator.clock import Clock
from cgagen.emulator.parts.part import Part
from cgagen.emulator.wires import Strength, Wire

BAUD = 9_600
"""The programming port's on all five models. Ref: S2 p. 419."""


class Uart(Part):
    """One end of a serial line, 8N1 or 7E1.

    Args:
        name: as the bench calls it.
        clock: the bench's.
        transmit: the wire that it sends on; None to only listen.
        receive: the wire that it listens on; None to only send.
        baud: bits per second.
        mark: level of the idle line: 0 on the programming port, where everything is inverted.
        seven_even: 7 bits and even parity instead of 8 bits without. Ref: S2 p. 397, 419.
        echo: what it sends also comes back on `receive`, through a resistor, as on every board
            with a programming port; a chip that sends at the same time mixes into it.
        may_send: asked before every byte; where it says no, `poke` asks again.
    """

    CIRCUIT = frozenset({"may_send", "heard"})

    def __init__(
        self,
        name: str,
        clock: Clock,
        transmit: Wire | None,
        receive: Wire | None,
        baud: int = BAUD,
        mark: int = 1,
        seven_even: bool = False,
        echo: bool = False,
        may_send: Callable[[], bool] | None = None,
    ) -> None:
        super().__init__(name, clock)
        self.may_send = may_send
        self.heard: Callable[[int], None] | None = None
        """Told every byte that was received."""
        self.sent = 0
        """Bytes that are on their way or over."""
        self.errors = 0
        """Frames without a stop bit (a break is one) or with wrong parity."""
        self.keeps_errors = False
        """Give such frames as they were read, as a computer's terminal driver does: a break is
        one 0. Otherwise they are dropped."""
        self._transmit = transmit
        self._receive = receive
        self._baud = baud
        self._mark = mark
        self._seven_even = seven_even
        self._echo = echo and receive is not None
        self._queue = bytearray()
        self._space = False
        self._received = bytearray()
        self._edges: list[tuple[int, int]] = []
        self._bits: tuple[int, ...] = ()
        self._bit = 0
        self._began_ns = 0
        self._next = self.timer(self._next_bit)
        self._sample = self.timer(self._frame_over)
        self._later = self.timer(self.poke)
        self._drive(1)
        if receive is not None:
            receive.listen(self._changed)

    def send(self, data: bytes) -> None:
        """Send bytes after those that wait already."""
        self._queue += data
        self.poke()

    def send_at(self, data: bytes, time_ns: int) -> None:
        """Send likewise, but begin at a time, and not before the clock runs."""
        self._queue += data
        self._later.at(time_ns)

    def poke(self) -> None:
        """Begin with the next byte if there is one and it may be sent."""
        idle = self._next.due_ns is None
        if idle and self._queue and (self.may_send is None or self.may_send()):
            self._bits = _frame(self._queue.pop(0), self._seven_even)
            self._bit = 0
            self._began_ns = self.clock.now_ns
            self.sent += 1
            self._next_bit()

    def hold_break(self, on: bool) -> None:
        """Hold the line at space, whatever is sent meanwhile, or end that."""
        self._space = on
        self._drive(self._bits[self._bit - 1] if self._bits else 1)

    def drop(self) -> None:
        """Stop sending in the middle of a byte, and forget what waits."""
        self._next.cancel()
        self._queue.clear()
        self._bits = ()
        self._drive(1)

    @property
    def baud(self) -> int:
        """Bits per second, both ways; a change spoils what is being sent."""
        return self._baud

    @baud.setter
    def baud(self, baud: int) -> None:
        if baud != self._baud:
            self.drop()
            self._baud = baud

    @property
    def seven_even(self) -> bool:
        """7 bits and even parity, both ways; a change spoils what is being sent."""
        return self._seven_even

    @seven_even.setter
    def seven_even(self, seven_even: bool) -> None:
        if seven_even != self._seven_even:
            self.drop()
            self._seven_even = seven_even

    @property
    def sends(self) -> bool:
        """Whether there is a wire that it sends on."""
        return self._transmit is not None

    @property
    def waiting(self) -> int:
        """Bytes that have not begun."""
        return len(self._queue)

    @property
    def sending(self) -> bool:
        """Whether a byte is on its way."""
        return self._next.due_ns is not None

    @property
    def idle_ns(self) -> int:
        """When the last byte that has begun is over."""
        return self._began_ns + self._bit_ns(FRAME_BITS)

    @property
    def received(self) -> bytes:
        """What came, and was not taken yet."""
        return bytes(self._received)

    def take(self, most: int | None = None) -> bytes:
        """Return what came, or so many bytes of it, and forget those."""
        taken = bytes(self._received[:most])
        del self._received[:most]
        return taken

    def told(self) -> dict[str, Any]:
        """See `Part.told`."""
        text = self._received.decode("latin-1")
        return {"sent": self.sent, "received": text, "errors": self.errors}

    @property
    def unread(self) -> int:
        """Bytes that came, and were not taken yet."""
        return len(self._received)

    @property
    def breaks(self) -> bool:
        """Whether the line is held at space."""
        return self._space

    def _drive(self, bit: int) -> None:
        level = self._mark if bit and not self._space else 1 - self._mark
        if self._transmit is not None:
            self._transmit.drive(self.name, level)
        if self._echo and self._receive is not None:
            self._receive.drive(self.name, level, Strength.RESISTOR)

    def _next_bit(self) -> None:
        if self._bit == len(self._bits):
            self._bits = ()
            self.poke()
            return
        self._drive(self._bits[self._bit])
        self._bit += 1
        self._next.at(self._began_ns + self._bit_ns(self._bit))

    def _bit_ns(self, bits: float) -> int:
        """Return how long so many bits take."""
        return int(bits * 1_000_000_000 // self._baud)

    def _changed(self, level: int | None) -> None:
        space = level == 1 - self._mark
        if not self._sample.order:
            if not space:
                return
            self._edges = []
            self._sample.after(_looks_ns(self._baud)[-1])
        self._edges.append((self.clock.now_ns, 0 if space else 1))

    def _frame_over(self) -> None:
        bits = _looked_at(self._edges, _looks_ns(self._baud))
        byte = bits >> 1 & (0x7F if self._seven_even else 0xFF)
        if bits != _number(byte, self._seven_even):
            start = bits & 1
            self.errors += not start
            if start or not self.keeps_errors:
                return
        self._received.append(byte)
        if self.heard is not None:
            self.heard(byte)


FRAME_BITS = 10


def _frame(byte: int, seven_even: bool) -> tuple[int, ...]:
    """Return the bits of a byte on the line: 1 is the mark.

    >>> _frame(0x41, False), _frame(0x41, True)
    ((0, 1, 0, 0, 0, 0, 0, 1, 0, 1), (0, 1, 0, 0, 0, 0, 0, 1, 0, 1))
    """
    bits = [byte >> place & 1 for place in range(8)]
    if seven_even:
        bits[7] = sum(bits[:7]) & 1
    return (0, *bits, 1)


@cache
def _number(byte: int, seven_even: bool) -> int:
    """Return a frame as a number, its first bit lowest."""
    return sum(bit << place for place, bit in enumerate(_frame(byte, seven_even)))


@cache
def _looks_ns(baud: int) -> tuple[int, ...]:
    """Return when each bit of a frame is looked at, from its beginning on."""
    return tuple(int((place + 0.5) * 1_000_000_000 // baud) for place in range(FRAME_BITS))


def _looked_at(edges: list[tuple[int, int]], looks_ns: tuple[int, ...]) -> int:
    """Return a frame as a number: at each look, the level after the last edge up to then."""
    began_ns, level = edges[0]
    bits, following, count = 0, 1, len(edges)
    for place, look_ns in enumerate(looks_ns):
        while following < count and edges[following][0] <= began_ns + look_ns:
            level = edges[following][1]
            following += 1
        bits |= level << place
    return bits
