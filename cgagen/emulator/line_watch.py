"""Whether a terminal hears a chip as it sends, and if not, which rate and form would fit.

Only edges are looked at, as a logic analyser does: a terminal at another rate makes bytes of them
that nobody has sent, or none at all.
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

from cgagen.emulator.clock import Clock
from cgagen.emulator.wires import Wire
from cgagen.stamp.serial_mode import FASTEST_BAUD, RATES, SLOWEST_BAUD, SerialMode

STOP_BITS = 9.5
"""From the edge of a start bit to the middle of the stop bit."""

OFF_BITS = 0.25
"""An edge that is so far from where one can be belongs to another rate. Ref: choice: over ten bits
a sender that is 2 % off stays inside."""

MOST_BITS = 3
"""The shortest piece of a text is not longer; it would fit any finer grid. Ref: choice."""

MANY_EDGES = 256
"""So many are kept; they are more than 20 bytes. Ref: choice."""

FEW_EDGES = 40
"""So many are tried alone where all of them fit no rate: it may change again. Ref: choice."""

FEW_BYTES = 4
"""Of a terminal at the right rate, so many with even parity are more than chance. Ref: choice."""

SILENCE_NS = 100_000_000
"""Longer than three bytes with 300 baud. Ref: choice."""

SECOND_NS = 1_000_000_000

Edge = tuple[int, bool]
"""A time, and whether the line is at space from then on."""


class Frame(NamedTuple):
    """What a receiver takes for a byte.

    Attributes:
        first: number of the edge that begins it.
        behind: number of the first edge behind it.
        over_ns: when the middle of its stop bit has come.
        data: the eight bits behind the start bit.
        good: no edge is where none can be, no two are in one place, and the stop bit is a mark.
    """

    first: int
    behind: int
    over_ns: int
    data: int
    good: bool


class LineWatch:
    """Watches what a chip drives onto its SOUT.

    Args:
        clock: the bench's.
        sout: the chip's own end.
        mode: of the terminal.

    Attributes:
        mode: see above.
    """

    def __init__(self, clock: Clock, sout: Wire, mode: SerialMode) -> None:
        self._clock = clock
        self._sout = sout
        self._space = False
        self.close = sout.listen(self._changed)
        """Look no longer."""
        self.set_mode(mode)

    def set_mode(self, mode: SerialMode) -> None:
        """The terminal has another mode from now on; what was before says nothing any more."""
        self.mode = mode
        self._edges: list[Edge] = []
        self._starts: list[int] = []
        self._heard: list[int] = []
        self._next = 0
        self._spoiled = False
        self._tried = 0

    def fitting(self, over: bool = True) -> SerialMode | None:
        """Return the mode in which the chip sends, if it is not the terminal's and can be told.

        Args:
            over: nothing more is waited for; otherwise half a text is not judged.
        """
        self._follow()
        now_ns = self._clock.now_ns
        if len(self._edges) == self._tried or not (over or self._is_much(now_ns)):
            return None
        self._tried = len(self._edges)
        if not self._spoiled:
            return self._told_by_bytes(now_ns)
        # A program may speak DEBUG's mode first, so that the first piece that fits is looked for.
        for text in (True, False):
            for start in self._starts:
                mode = mode_of(self._edges[start:], now_ns, text=text)
                if mode is not None and mode != self.mode:
                    return mode
        return mode_of(self._edges[self._starts[-1] :][:FEW_EDGES], now_ns)

    def _is_much(self, now_ns: int) -> bool:
        """Whether there is enough to tell a rate, or nothing more comes."""
        if self._edges and now_ns - self._edges[-1][0] > SILENCE_NS:
            return True
        doubtful = self._starts[-1] if self._spoiled else 0
        return len(self._edges) - doubtful > FEW_EDGES

    def _told_by_bytes(self, now_ns: int) -> SerialMode | None:
        """Return likewise where every frame is one for the terminal, too, but no text."""
        if self.mode.seven_even or _is_text(self._heard):
            return None
        if len(self._heard) >= FEW_BYTES and _is_seven_even(self._heard):
            return SerialMode(self.mode.baud, True)
        strange = next(place for place, one in enumerate(self._heard) if not _is_text([one]))
        mode = mode_of(self._edges[self._starts[strange] :], now_ns, text=True)
        return mode if mode is not None and mode.baud < self.mode.baud else None

    def _changed(self, _level: int | None) -> None:
        # What else is on the wire, such as the echo of what is typed, is not the chip's.
        space = self._sout.name in self._sout.drivers
        if space == self._space:
            return
        self._space = space
        if len(self._edges) >= MANY_EDGES:
            self._follow()
            if not self._spoiled:
                self._forget()
        if len(self._edges) < MANY_EDGES:
            self._edges.append((self._clock.now_ns, space))

    def _follow(self) -> None:
        """Hear what the terminal hears, up to the first frame that is none for it."""
        if self._spoiled:
            return
        for frame in frames_of(self._edges, self.mode.baud, self._next):
            if frame.over_ns > self._clock.now_ns:
                return
            self._starts.append(frame.first)
            self._next = frame.behind
            self._heard.append(frame.data)
            odd = self.mode.seven_even and frame.data.bit_count() & 1
            if not frame.good or odd:
                self._spoiled = True
                return

    def _forget(self) -> None:
        """Forget the older half of what was heard rightly."""
        half = len(self._starts) // 2
        gone = self._starts[half] if self._starts else 0
        del self._edges[:gone], self._heard[:half]
        self._starts = [start - gone for start in self._starts[half:]]
        self._next -= gone
        self._tried = 0


def mode_of(edges: Sequence[Edge], now_ns: int, text: bool = False) -> SerialMode | None:
    """Return the slowest mode in which bytes with these edges were sent; None where none fits.

    Args:
        edges: the first is that of a start bit.
        now_ns: up to when there were no others.
        text: the bytes have to be characters.

    >>> bit = 416_667  # "U" and "3" with 2400 baud
    >>> runs = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 13, 15, 17, 19]
    >>> str(mode_of([(n * bit, i % 2 == 0) for i, n in enumerate(runs)], 30 * bit))
    '2400'
    """
    if len(edges) < 2:
        return None
    shortest_ns = min(later - sooner for (sooner, _), (later, _) in pairwise(edges))
    others = [round(SECOND_NS / shortest_ns)] if shortest_ns else []
    for baud in (*RATES, *others):
        bit_ns = SECOND_NS / baud
        if not SLOWEST_BAUD <= baud <= FASTEST_BAUD or shortest_ns > MOST_BITS * bit_ns:
            continue
        frames = [one for one in frames_of(edges, baud) if one.over_ns <= now_ns]
        if not frames or not all(frame.good for frame in frames):
            continue
        data = [frame.data for frame in frames]
        seven = _is_seven_even(data)
        if not text or _is_text(data, 0x7F if seven else 0xFF):
            return SerialMode(baud, seven)
    return None


def frames_of(edges: Sequence[Edge], baud: int, index: int = 0) -> Iterator[Frame]:
    """Return the bytes that a receiver makes of edges.

    Args:
        edges: of one line.
        baud: of the receiver.
        index: of the edge from which on it looks for a start bit.
    """
    bit_ns = SECOND_NS / baud
    while index < len(edges):
        began_ns, space = edges[index]
        if not space:
            index += 1
            continue
        over_ns = began_ns + round(STOP_BITS * bit_ns)
        behind, good = index + 1, True
        bits, place, level = 0, 0, 0  # bits from `place` on have this level: a space is 0
        while behind < len(edges) and edges[behind][0] < over_ns:
            at = (edges[behind][0] - began_ns) / bit_ns
            good &= abs(at - round(at)) < OFF_BITS and round(at) > place
            bits |= level * ((1 << round(at)) - (1 << place))
            place, level = round(at), 0 if edges[behind][1] else 1
            behind += 1
        bits |= level * ((1 << 10) - (1 << place))
        yield Frame(index, behind, over_ns, bits >> 1 & 0xFF, bool(good and level))
        index = behind


def _is_text(data: Sequence[int], mask: int = 0xFF) -> bool:
    """Whether bytes are characters, or codes of a DEBUG terminal."""
    return all((one & mask) < 16 or 32 <= (one & mask) < 127 for one in data)


def _is_seven_even(data: Sequence[int]) -> bool:
    """Whether bytes are a text with even parity: with a bit 7 that makes no other sense."""
    even = all(not one.bit_count() & 1 for one in data)
    return even and _is_text(data, 0x7F) and max(data) > 0x7F
