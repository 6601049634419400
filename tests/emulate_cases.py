"""Programs for the tests of `cgagen emulate`, and the types of its fixtures."""

from collections.abc import Callable
from pathlib import Path

PROGRAMS = Path(__file__).parent / "programs"
PREDATOR = Path(__file__).parent.parent / "firmware" / "predator"
BASIC = "' {$STAMP BS2}\n' {$PBASIC 2.5}\n"
ENDLESS = BASIC + 'DO\n  DEBUG "."\n  PAUSE 100\nLOOP\n'


Emulate = Callable[..., tuple[int, str, str]]


Program = Callable[..., Path]
