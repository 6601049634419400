"""Every emulated bench of ours, shown to whoever wants to look: for coverage and for waveforms.

The makers of benches call `show`; nobody looks by default, and nothing is done then.
"""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager

from cgagen.emulator.bench import Bench
from cgagen.emulator.chip import Coverage
from cgagen.errors import SourceError
from cgagen.stamp.compiled import Compiled
from cgagen.stamp.image import Image
from hil.subject import CHIPS, Subject

Look = Callable[[Bench, Mapping[str, Image]], None]
"""Given a bench that has not run yet, and the image in each of its chips, by the chip's name."""

Compile = Callable[[str, str], Compiled]
"""Turns a source and its name into an image with its source map."""

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

    def add(self, digest: str, coverage: Coverage) -> None:
        """Add what was counted elsewhere."""
        mine = self.coverage.setdefault(digest, Coverage())
        mine.counts.update(coverage.counts)
        for place, (on, jumped) in coverage.branches.items():
            gone = mine.branches.setdefault(place, [0, 0])
            gone[0] += on
            gone[1] += jumped


def counted(image: Image, coverage: Coverage) -> None:
    """Tell whoever counts what a check has counted by itself."""
    for look in _LOOKS:
        if isinstance(look, Counted):
            look.add(image.digest, coverage)


def know_lines(bench: Bench, subject: Subject, compile_source: Compile) -> None:
    """Tell a robot's bench which lines its programs are at, where the sources are the images'.

    Args:
        bench: whose chips have the names of the subject's.
        subject: what is in them.
        compile_source: the tokenizer.
    """
    for name in CHIPS:
        image = subject.images[name]
        try:
            compiled = compile_source(subject.sources[name], subject.files[name])
        except SourceError:
            continue
        if compiled.image.eeprom == image.eeprom:
            bench.chip(name).programs[image.slot] = compiled
