"""Noise: short glitches at an end of a wire, at times that look random and always are the same."""

from cgagen.emulator.clock import Clock
from cgagen.emulator.parts.fault import Fault
from cgagen.emulator.wires import Wire

_WORD = (1 << 64) - 1


class Noise(Fault):
    """A pin or a lead reads the opposite for a moment, again and again.

    The other ends of the wire read what they read: a glitch at a pin triggers no sonar. It fires
    with every glitch; where the wire floats there is nothing to turn round.

    Args:
        name: as the bench calls it.
        clock: the bench's.
        end: the pin's or the lead's own end.
        every_ns: from one glitch to the next, on the average; between half of it and 3/2.
        width_ns: of a glitch.
        seed: another seed, other times.
        from_ns: see `Fault`.
        until_ns: likewise.
    """

    def __init__(
        self,
        name: str,
        clock: Clock,
        end: Wire,
        every_ns: int,
        width_ns: int,
        seed: int = 0,
        from_ns: int | None = 0,
        until_ns: int | None = None,
    ) -> None:
        super().__init__(name, clock, from_ns, until_ns)
        self._reads = end
        self._every_ns = every_ns
        self._width_ns = width_ns
        self._random = seed & _WORD
        self._next = self.timer(self._glitch)
        self._over = self.timer(self._still)

    def _begin(self) -> None:
        self._book()

    def _end(self) -> None:
        self._next.cancel()
        if self._over.due_ns is not None:
            self._over.cancel()
            self._still()

    def _book(self) -> None:
        self._random = (self._random + 0x9E3779B97F4A7C15) & _WORD
        wait_ns = self._every_ns // 2 + _mixed(self._random) % max(self._every_ns, 1)
        self._next.after(max(wait_ns, self._width_ns + 1))

    def _glitch(self) -> None:
        self._book()
        if self._reads.level is not None:
            self._fire()
            self._over.after(self._width_ns)
            self._reads.force(self.name, 1 - self._reads.level)

    def _still(self) -> None:
        self._reads.force(self.name, None)


def _mixed(word: int) -> int:
    """Return a well mixed word of 64 bits: the last step of SplitMix64.

    >>> _mixed(0), _mixed(0x9E3779B97F4A7C15) == 0xE220A8397B1DCDAF
    (0, True)
    """
    word = ((word ^ word >> 30) * 0xBF58476D1CE4E5B9) & _WORD
    word = ((word ^ word >> 27) * 0x94D049BB133111EB) & _WORD
    return word ^ word >> 31
