"""Chips for tests, from PBASIC text."""

from dataclasses import replace
from typing import Any

from cgagen.emulator.chip import Chip
from cgagen.emulator.clock import Clock
from cgagen.tokenizer import Tokenizer

SECOND_NS = 1_000_000_000


def chip_of(tokenizer: Tokenizer, *sources: str, model: str = "BS2", **options: Any) -> Chip:
    """Return a chip with a source for each slot from 0 on; nothing has run yet."""
    head = f"' {{$STAMP {model}}}\n' {{$PBASIC 2.5}}\n"
    images = [
        replace(tokenizer.compile(head + source + "\n").image, slot=slot)
        for slot, source in enumerate(sources)
    ]
    return Chip("chip", images, Clock(), **options)
