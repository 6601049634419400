"""What the protocol asks of a line, and what it is told: the seam between bytes and time.

A conversation is a generator: it yields one of these requests and is sent what was `Heard`. It
opens nothing, waits for nothing and knows no clock, so that it can be played through with any
line, real or imagined.
"""

from collections.abc import Generator
from enum import Enum
from typing import NamedTuple, TypeVar

T = TypeVar("T")


class Enter(NamedTuple):
    """Reset the chip with the line in BREAK, so that its loader listens."""


class Restart(NamedTuple):
    """Reset the chip with the line at rest, so that its program runs."""


class Say(NamedTuple):
    """Send bytes; hear their echo and what comes behind it.

    Attributes:
        data: what is sent.
        replies: bytes that are awaited behind the echo.
        wait_ms: how long the line may take, beyond the time that the bytes need.
    """

    data: bytes
    replies: int
    wait_ms: int


class Hear(NamedTuple):
    """Listen without a word; the first byte ends it.

    Attributes:
        wait_ms: how long.
    """

    wait_ms: int


class Progress(NamedTuple):
    """Not a request of the line: how far the download is.

    Attributes:
        done: packets that the chip has acknowledged.
        total: packets of the image.
        attempt: from 1.
    """

    done: int
    total: int
    attempt: int


class Heard(NamedTuple):
    """What came.

    Attributes:
        before: bytes that lay on the line before anything was said; after `Enter`, what went
            on coming although nobody had asked.
        after: echo and answers, shorter than awaited where the time ran out; after `Enter`, all
            that came meanwhile, the echo of BREAK among it.
    """

    before: bytes = b""
    after: bytes = b""


Request = Enter | Restart | Say | Hear | Progress

Conversation = Generator[Request, Heard, T]


class Symptom(Enum):
    """What is wrong on a line, most telling first."""

    DOUBLE_ECHO = "every byte comes back twice"
    NO_BREAK = "neither BREAK nor an answer comes back"
    TALKING = "something talks although it was reset"
    WRONG_ECHO = "another byte comes back than was sent"
    STRAY = "bytes come that nobody asked for"
    WRONG_ANSWER = "an answer that no module gives"
    NO_ANSWER = "the echo comes and no answer"
    NO_ECHO = "nothing comes back"
    WRONG_MODEL = "another module"
    REFUSED = "the chip reports a broken packet"
    WORN = "the chip's EEPROM does not take the bytes"
    FELL_SILENT = "nothing comes back after the last acknowledgement"


class TroubleError(Exception):
    """A conversation that cannot go on.

    Attributes:
        symptom: what is wrong.
        detail: the bytes, or where.
        final: trying again is of no use.
    """

    def __init__(self, symptom: Symptom, detail: str = "", final: bool = False) -> None:
        super().__init__(f"{symptom.value}: {detail}")
        self.symptom = symptom
        self.detail = detail
        self.final = final


def exchange(data: bytes, replies: int, wait_ms: int) -> Conversation[bytes]:
    """Say something and return the replies.

    Raises:
        TroubleError: the echo is not what was sent, or replies are missing.
    """
    heard = yield Say(data, replies, wait_ms)
    if heard.before:
        raise TroubleError(Symptom.STRAY, f"{heard.before.hex(' ')}h before {data[:1].hex()}h")
    if not heard.after:
        raise TroubleError(Symptom.NO_ECHO, f"to {data[:1].hex()}h")
    echo, reply = heard.after[: len(data)], heard.after[len(data) :]
    if echo != data:
        raise TroubleError(Symptom.WRONG_ECHO, _difference(data, echo))
    if len(reply) < replies:
        raise TroubleError(Symptom.NO_ANSWER, f"to {data[:1].hex()}h")
    return reply


def _difference(data: bytes, echo: bytes) -> str:
    for sent, came in zip(data, echo, strict=False):
        if sent != came:
            return f"{sent:02x}h came back as {came:02x}h"
    return f"{len(echo)} of {len(data)} bytes came back"
