"""A bench for one chip, from a source or an image."""

from collections.abc import Mapping
from dataclasses import replace

from cgagen.emulator.bench import Bench
from cgagen.emulator.chip import Chip
from cgagen.stamp.compiled import Compiled
from cgagen.stamp.image import Image

MAIN = "main"
"""What the chip of such a bench is called."""


def bench_of_image(image: Image, compiled: Compiled | None = None) -> Bench:
    """Return a bench with one chip and nothing wired to it.

    Args:
        image: what it executes.
        compiled: the source that the image came from, where it is known.
    """
    bench = _bench([image])
    if compiled is not None:
        bench.chips[MAIN].programs[image.slot] = compiled
    return bench


def bench_of_sources(sources: Mapping[int, Compiled]) -> Bench:
    """Return a bench with one chip and the programs of its slots.

    Args:
        sources: by slot; slot 0 runs first.

    Raises:
        BenchError: they are for different models.
        ImageError: for a slot that the model does not have.
    """
    bench = _bench([replace(one.image, slot=slot) for slot, one in sources.items()])
    bench.chips[MAIN].programs.update(sources)
    return bench


def _bench(images: list[Image]) -> Bench:
    bench = Bench()
    chip = Chip(MAIN, images, bench.clock, floated=lambda pin: bench.floats(f"{MAIN}.P{pin}"))
    bench.add_chip(chip)
    return bench
