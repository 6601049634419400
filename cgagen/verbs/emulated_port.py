"""`--port emu`: an emulated Stamp, or a robot with two, for the length of one call.

It is served on a socket of this machine and opened like any other port, so that what is tried is
the whole way. Its chips come blank, as from the shop, and are gone with the call.
"""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from cgagen.emulator.programs import bench_of_image
from cgagen.robot import load_robot
from cgagen.serve import serve
from cgagen.stamp.chips import EEPROM_BYTES, Chip
from cgagen.stamp.image import Image
from hil.emulated import robot_bench


@contextmanager
def emulated_chip(model: Chip) -> Iterator[str]:
    """Give the port of an emulated module."""
    with serve(bench_of_image(_blank(model)), "rfc2217:0") as server:
        yield server.url


@contextmanager
def emulated_robot(robot_file: Path, models: Mapping[str, Chip]) -> Iterator[dict[str, str]]:
    """Give the ports of an emulated robot, by chip.

    Args:
        robot_file: what it is.
        models: its chips.
    """
    blank = {name: _blank(model) for name, model in models.items()}
    bench = robot_bench(load_robot(str(robot_file)), blank)
    with serve(bench, dict.fromkeys(models, "rfc2217:0")) as server:
        yield {name: one.url for name, one in zip(models, server.endpoints, strict=True)}


def _blank(model: Chip) -> Image:
    return Image(model, bytes(EEPROM_BYTES))
