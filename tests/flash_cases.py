"""Emulated Stamps to be programmed, and what they hold afterwards."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from cgagen.emulator.bench import Bench
from cgagen.robot import load_robot
from cgagen.serve import serve
from cgagen.stamp.chips import chip
from cgagen.stamp.image import Image
from hil.emulated import robot_bench

PREDATOR = Path(__file__).parent.parent / "firmware" / "predator"
CHIPS = ("main", "locomotion")
MODELS = {"main": "BS2p", "locomotion": "BS2"}


def blank(model: str) -> Image:
    """A chip from the shop: its program is an END."""
    return Image(chip(model), bytes(2048))


def blank_robot() -> Bench:
    return robot_bench(
        load_robot("servobot-predator"), {name: blank(MODELS[name]) for name in CHIPS}
    )


@contextmanager
def robot() -> Iterator[tuple[Bench, dict[str, str]]]:
    """An emulated robot with blank chips, both ports served."""
    bench = blank_robot()
    with serve(bench, dict.fromkeys(CHIPS, "rfc2217:0")) as server:
        yield bench, {name: one.url for name, one in zip(CHIPS, server.endpoints, strict=True)}
    assert server.failure is None
