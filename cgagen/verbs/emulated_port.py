"""`--port emu`: an emulated Stamp, or a robot with two, for the length of one call.

It is served on a socket of this machine and opened like any other port, so that what is tried is
the whole way. `emu` alone has blank chips, as from the shop; `emu:BUILD` has the programs of a
build in them. All of it is gone with the call.
"""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from cgagen.build.record import ROBOT_FILE
from cgagen.emulator.programs import bench_of_image
from cgagen.errors import RigError
from cgagen.link.ports import choose_port
from cgagen.robot import load_robot
from cgagen.serve import serve
from cgagen.stamp.chips import EEPROM_BYTES, Chip
from cgagen.stamp.image import Image
from hil.emulated import robot_bench
from hil.subject import read_subject

EMULATED = "emu"


@contextmanager
def named_port(name: str, chip: str, realtime: bool = False) -> Iterator[str]:
    """Give the port that a user has named, for as long as it is wanted.

    Args:
        name: see `choose_port`; or `emu:BUILD`.
        chip: of an emulated robot, the one to be talked to.
        realtime: an emulated robot is no faster than a real one.

    Raises:
        RigError: no such port, or not one.
        FolderError: no such build.
    """
    kind, _, folder = name.partition(":")
    if kind != EMULATED:
        yield choose_port(name)
        return
    if not folder:
        raise RigError("emu: say which robot, by the folder of its build: emu:runs/demo/build-prey")
    subject = read_subject(Path(folder))
    bench = robot_bench(subject.robot, subject.images)
    with serve(bench, {chip: "rfc2217:0"}, realtime=realtime) as server:
        yield server.url


def robot_behind(name: str) -> str | None:
    """Return the robot file of an emulated robot; None for a port whose robot nobody knows."""
    kind, _, folder = name.partition(":")
    return str(Path(folder) / ROBOT_FILE) if kind == EMULATED and folder else None


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
