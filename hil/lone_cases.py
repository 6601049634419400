"""What the tests of a robot alone share: the robots of the repository, and a movement as asked."""

from functools import cache
from pathlib import Path

from hil.lone import Walk
from hil.subject import Subject, read_subject

FIRMWARE = Path(__file__).parents[1] / "firmware"
SEEN_MS = 40
"""After that the legs have seen the line high, and may be told; sensing takes longer still."""


@cache
def subject(name: str) -> Subject:
    """Return the predator or the prey, read once."""
    return read_subject(FIRMWARE / name)


def as_asked(walk: Walk | None) -> Walk:
    """Return a movement that is there, and is the one that the lines said."""
    assert walk is not None
    assert walk.made.command == walk.asked, walk.made.reason
    return walk
