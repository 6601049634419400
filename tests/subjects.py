"""The robots whose firmware is in the repository, read once for all tests."""

from functools import cache
from pathlib import Path

from hil.subject import Subject, read_subject

FIRMWARE = Path(__file__).parent.parent / "firmware"


@cache
def subject(role: str) -> Subject:
    return read_subject(FIRMWARE / role)
