"""The loop between a port, a keyboard and whoever wants to see what comes."""

import time
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Protocol

from cgagen.errors import RigError
from cgagen.link.why import LOST
from cgagen.monitor.echo import EchoFilter
from cgagen.monitor.rates import ENOUGH_BYTES, slower_rate
from cgagen.stamp.serial_mode import DEBUG_MODE

Sink = Callable[[bytes], None]
Typed = Callable[[], bytes | None]
"""What was typed since the last time: nothing is b"", the end is None."""

GARBAGE_BYTES = 64
GARBAGE_SHARE = 0.3
"""So many of so many bytes that are no text: the line is not read as it is sent. Choice."""

_CONTROL = frozenset(range(17))
"""Codes of a DEBUG terminal. Ref: S4 (DEBUG)."""


class Port(Protocol):
    """What is needed of a port; pyserial's have it."""

    def read(self, size: int = 1, /) -> bytes:
        """Return at most so many bytes, after a short wait."""
        ...

    def write(self, data: bytes, /) -> int | None:
        """Send bytes."""
        ...


class Listener:
    """One session on an open port.

    Args:
        name: what messages call the port.
        port: open; its `read` waits for a moment.
        sinks: given every byte that the chip sends, without the echo of what was typed.
        note: told, once each, what seems to be wrong with the line.
        now_s: a clock.
        baud: of the port.

    Attributes:
        received: bytes of the chip's.
    """

    def __init__(
        self,
        name: str,
        port: Port,
        sinks: Sequence[Sink],
        note: Callable[[str], None],
        now_s: Callable[[], float] = time.monotonic,
        baud: int = DEBUG_MODE.baud,
    ) -> None:
        self.received = 0
        self._baud = baud
        self._name = name
        self._port = port
        self._sinks = sinks
        self._note = note
        self._now_s = now_s
        self._echo = EchoFilter()
        self._recent = bytearray()
        self._said: set[str] = set()

    def turn(self, typed: bytes) -> None:
        """Send what was typed, and hand on what has come.

        Raises:
            RigError: the port is gone.
        """
        try:
            if typed:
                self._echo.sent(typed, self._now_s())
                self._port.write(typed)
            data = self._port.read(1)
            data += self._port.read(_waiting(self._port)) if data else b""
        except LOST as error:
            raise RigError(
                f"{self._name}: the port is gone ({error}); plug it in and begin again"
            ) from error
        kept = self._echo.received(data, self._now_s())
        if kept:
            self.received += len(kept)
            for sink in self._sinks:
                sink(kept)
        self._diagnose(kept)

    def _diagnose(self, data: bytes) -> None:
        if self._echo.missing:
            self._once(
                f"{self._name}: what is typed does not come back, as the wiring of a Stamp's "
                "programming port would have it: the Stamp spoke at the same time, which spoils "
                "both, or there is no such wiring; type less at a time, or look at the cable"
            )
        self._recent += data
        if len(self._recent) >= GARBAGE_BYTES:
            self._judge()

    def end(self) -> None:
        """The session is over: what came last is judged, too."""
        if len(self._recent) >= ENOUGH_BYTES:
            self._judge()

    def _judge(self) -> None:
        """Say what is to be said of the last bytes, and forget them."""
        strange = sum(byte not in _CONTROL and not 32 <= byte < 127 for byte in self._recent)
        # A sender that is slower by far makes one 0 after the other; no program clears so often.
        strange += sum(one == next_one == 0 for one, next_one in pairwise(self._recent))
        if strange > GARBAGE_SHARE * len(self._recent):
            rate = slower_rate(bytes(self._recent), self._baud)
            fits = "" if rate is None else f": {rate} would fit"
            self._once(
                f"{self._name}: much of what comes is no text; the program may send at another "
                f"rate (--baud{fits}), or the line is inverted or has no ground",
                "garbage",
            )
        self._recent.clear()

    def _once(self, sentence: str, about: str = "") -> None:
        about = about or sentence
        if about not in self._said:
            self._said.add(about)
            self._note(sentence)


def listen(listener: Listener, typed: Typed, goes_on: Callable[[], bool]) -> None:
    """Carry bytes until nobody wants any more.

    Args:
        listener: what is listened to.
        typed: the keyboard; after its end the chip is still listened to.
        goes_on: asked after every turn.

    Raises:
        RigError: the port is gone.
    """
    text = typed()
    while True:
        listener.turn(text or b"")
        if not goes_on():
            return
        if text is not None:
            text = typed()


def _waiting(port: Port) -> int:
    """Return how many more bytes can be had at once; a port that cannot say has none."""
    return max(int(getattr(port, "in_waiting", 0) or 0), 0)
