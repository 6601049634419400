"""The traces in this folder: how they were recorded, so that anybody can record them again.

`python -m hil.traces.shipped` writes them anew; a test compares the bytes. They come from the
simulator, so a change of the firmware alone leaves them as they are.
"""

import sys
from pathlib import Path
from typing import Any

from cgagen.genome import load
from cgagen.robot import load_arena
from cgagen.words import Role
from hil.simulated import SimulatedTarget
from hil.subject import Subject, read_subject
from hil.target import Stimulus
from hil.traces.recording import episode_readings, episode_source, origin_of, record_readings, sweep
from hil.traces.sidecar import HAND
from hil.traces.storage import read_trace, write_beside, write_trace
from hil.traces.values import Trace
from sim.numbers import Options, world_numbers
from sim.starts import start_of

FOLDER = Path(__file__).parent
FIRMWARE = FOLDER.parent.parent / "firmware"

FIGURE_7 = {"predator": (268.75, 31.25, 180.0), "prey": (15.0, 150.0, 90.0)}
"""Ref: S1 IV and figure 7."""

WALL = {"predator": (60.0, 40.0, 250.0), "prey": (20.0, 280.0, 90.0)}
"""The predator walks into the south wall. Choice."""

EPISODES = {
    "hunt.log": (Role.PREDATOR, FIGURE_7, 100),
    "hunt-prey.log": (Role.PREY, FIGURE_7, 30),
    "wall.log": (Role.PREDATOR, WALL, 25),
}
"""By file: whose readings, from which poses, for how many steps at most."""

SWEEPS = {"sweep.log": Role.PREDATOR}
WRITTEN_BY_HAND = {"vectors.csv": Role.PREDATOR, "vectors-prey.csv": Role.PREY}

ROLES = {name: role for name, (role, _, _) in EPISODES.items()} | SWEEPS | WRITTEN_BY_HAND
"""Of all files."""


def reference() -> dict[Role, Subject]:
    """Return the reference robots.

    Raises:
        FolderError: this is not a checkout of the project.
    """
    return {role: read_subject(FIRMWARE / str(role)) for role in Role}


def recorded(subjects: dict[Role, Subject]) -> dict[str, Trace]:
    """Return all traces that are recorded, by file."""
    predator, prey = subjects[Role.PREDATOR], subjects[Role.PREY]
    genome = load(FIRMWARE / "reference.genome")
    numbers = world_numbers(predator.robot, prey.robot, load_arena("colony"), Options())
    radii = numbers.predator.radius, numbers.prey.radius
    found = {}
    for name, (role, poses, steps) in EPISODES.items():
        start = start_of(poses["predator"], poses["prey"], numbers.side, radii)
        readings = episode_readings(genome, numbers, start, steps, role)
        source = episode_source(role, poses, steps, genome, {})
        found[name] = _simulated(subjects[role], readings, source)
    for name, role in SWEEPS.items():
        found[name] = _simulated(subjects[role], sweep(subjects[role].robot), {"sweep": "sensors"})
    return found


def _simulated(subject: Subject, readings: list[Stimulus], source: dict[str, Any]) -> Trace:
    return record_readings(subject, SimulatedTarget(subject), readings, source)[0]


def write_all(folder: Path, subjects: dict[Role, Subject]) -> None:
    """Record all traces into a folder, and give vectors written by hand their sidecars."""
    for name, trace in recorded(subjects).items():
        write_trace(folder / name, trace, subjects[ROLES[name]].robot, force=True)
    for name, role in WRITTEN_BY_HAND.items():
        subject = subjects[role]
        (folder / f"{name}.json").unlink(missing_ok=True)
        vectors = read_trace(folder / name, subject.robot)
        write_beside(folder / name, origin_of(subject, HAND), len(vectors.samples), subject.robot)


if __name__ == "__main__":
    write_all(FOLDER, reference())
    sys.stdout.write(f"{FOLDER.name}: {len(EPISODES) + len(SWEEPS)} traces recorded\n")
