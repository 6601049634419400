"""What an instruction asks of the bench while it runs.

An instruction that takes time or touches a pin is a generator. It yields requests and is resumed
when they are met; in between, the rest of the bench moves on. It never touches the clock, so it
can be tested as a plain list of requests.
"""

from collections.abc import Generator
from typing import NamedTuple, TypeVar


class Delay(NamedTuple):
    """Go on after this time; resumed with the time that has passed, `ns`."""

    ns: int


class Until(NamedTuple):
    """Go on when a pin, or `cgagen.emulator.pins.SIN`, reads a level, at once where it does.

    Resumed with the nanoseconds that have passed, or with None when `timeout_ns` were over first.
    """

    pin: int
    level: int
    timeout_ns: int


Request = Delay | Until

T = TypeVar("T")
Command = Generator[Request, int | None, T]
"""An instruction under way; what it returns is the instruction's result."""
