"""The edge: a conversation's requests carried out on an open port, against a clock."""

import time
from collections.abc import Callable
from typing import Protocol, TypeVar

from cgagen.flash.requests import (
    Conversation,
    Enter,
    Hear,
    Heard,
    Progress,
    Request,
    Restart,
    Say,
)

T = TypeVar("T")

ATN_MS = 10
"""How long DTR is asserted. Ref: S18 and S19, which quote Parallax: 2 ms or more."""

BREAK_MS = 60
"""How long BREAK outlasts the reset. Ref: likewise 36 ms or more; S17 takes 60."""

SETTLE_MS = 20
"""How long the line rests after BREAK, which comes back as one broken byte. Ref: S18."""

SETTLE_ROUNDS = 3
"""How often input is thrown away until the line is silent; adapters deliver late. Choice."""

BYTE_S = 10 / 9600
"""Ref: S2 p. 419: 9600 baud, 8N1, on all models known here."""

BABBLE_BYTES = 64
"""The most that is read before anything is said. Choice: a bound."""


class Wire(Protocol):
    """What is needed of pyserial's ports."""

    dtr: bool
    break_condition: bool

    @property
    def in_waiting(self) -> int:
        """Bytes that can be read at once."""
        ...

    def write(self, data: bytes, /) -> int | None:
        """Send."""
        ...

    def read(self, size: int, /) -> bytes:
        """Return so many bytes, or fewer after the port's own time-out."""
        ...


class Clock(Protocol):
    """Time, which a test makes itself."""

    def now_s(self) -> float:
        """Seconds since some moment."""
        ...

    def sleep(self, seconds: float) -> None:
        """Wait."""
        ...


class WallClock:
    """The computer's."""

    def now_s(self) -> float:
        """Seconds since some moment."""
        return time.monotonic()

    def sleep(self, seconds: float) -> None:
        """Wait."""
        time.sleep(seconds)


class Line:
    """An open port that takes requests.

    Args:
        wire: the port.
        clock: what its waits are measured with.
        latency_s: what the way to the port adds to every answer.
    """

    def __init__(self, wire: Wire, clock: Clock, latency_s: float = 0.0) -> None:
        self._wire = wire
        self._clock = clock
        self._latency_s = latency_s

    def converse(
        self, conversation: Conversation[T], tell: Callable[[Progress], None] | None = None
    ) -> T:
        """Carry a conversation to its end and return what it returns.

        Raises:
            TroubleError: the conversation cannot go on.
            OSError: the port is lost; likewise all of `cgagen.link.why.LOST`.
        """
        try:
            request = next(conversation)
            while True:
                if isinstance(request, Progress) and tell is not None:
                    tell(request)
                request = conversation.send(self.perform(request))
        except StopIteration as end:
            result: T = end.value
            return result

    def perform(self, request: Request) -> Heard:
        """Carry out one request."""
        match request:
            case Enter():
                return self._enter()
            case Restart():
                self._pulse()
                return Heard()
            case Say(data, replies, wait_ms):
                before = self._waiting()
                self._wire.write(data)
                wait_s = len(data) * BYTE_S + wait_ms / 1_000
                return Heard(before, self._read(len(data) + replies, wait_s))
            case Hear(wait_ms):
                return Heard(after=self._read(1, wait_ms / 1_000))
        return Heard()

    def _enter(self) -> Heard:
        wire = self._wire
        try:
            wire.break_condition = True
            self._pulse()
            self._clock.sleep(BREAK_MS / 1_000)
        finally:
            wire.break_condition = False
        came = b""
        for _ in range(SETTLE_ROUNDS):
            self._clock.sleep(SETTLE_MS / 1_000 + self._latency_s / SETTLE_ROUNDS)
            noise = self._waiting()
            came += noise
            if not noise:
                break
        return Heard(noise, came)

    def _pulse(self) -> None:
        try:
            self._wire.dtr = True
            self._clock.sleep(ATN_MS / 1_000)
        finally:
            self._wire.dtr = False

    def _waiting(self) -> bytes:
        found = b""
        while len(found) < BABBLE_BYTES and (count := self._wire.in_waiting):
            piece = self._wire.read(min(count, BABBLE_BYTES))
            if not piece:
                break
            found += piece
        return found

    def _read(self, wanted: int, wait_s: float) -> bytes:
        deadline_s = self._clock.now_s() + wait_s + self._latency_s
        found = b""
        while len(found) < wanted and self._clock.now_s() < deadline_s:
            found += self._wire.read(wanted - len(found))
        return found
