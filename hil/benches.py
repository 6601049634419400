"""Every emulated bench of ours, shown to whoever wants to look: for coverage and for waveforms.

The makers of benches call `show`; nobody looks by default, and nothing is done then.
"""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager

from cgagen.emulator.bench import Bench
from cgagen.emulator.chip import Coverage
from cgagen.stamp.image import Image

Look = Callable[[Bench, Mapping[str, Image]], None]
"""Given a bench that has not run yet, and the image in each of its chips, by the chip's name."""

_LOOKS: list[Look] = []


def show(bench: Bench, images: Mapping[str, Image]) -> Bench:
    """Show a new bench to all that look; returns it."""
    for look in _LOOKS:
        look(bench, images)
    return bench


@contextmanager
def looking(look: Look) -> Iterator[None]:
    """Have every bench shown that is made inside of the block."""
    _LOOKS.append(look)
    try:
        yield
    finally:
        _LOOKS.remove(look)


class Counted:
    """Counts what every bench executes, by the digest of the image.

    Attributes:
        coverage: by digest; one of all chips that have that image.
    """

    def __init__(self) -> None:
        self.coverage: dict[str, Coverage] = {}

    def __call__(self, bench: Bench, images: Mapping[str, Image]) -> None:
        """Count on this bench, too."""
        for name, image in images.items():
            chip = bench.chip(name)
            counts = self.coverage.setdefault(image.digest, chip.coverage or Coverage())
            chip.coverage = chip.coverage or counts
