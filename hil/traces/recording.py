"""Where traces come from: readings of an episode, or any others, and a target that is asked.

What is asked reading by reading has no time of its own: its readings stand one second apart, so
that the same recording gives the same bytes on every machine.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cgagen.counts import NO_ECHO_COUNT, UNLIT_COUNT
from cgagen.errors import UnprovenError
from cgagen.genome import Genome
from cgagen.robot import Robot
from cgagen.words import Role
from hil.hunt import episode_of
from hil.pursuit_step import stimuli_of
from hil.stimuli import with_values
from hil.subject import Subject
from hil.target import IMAGE, Stimulus, Target
from hil.traces.values import Origin, Sample, Trace, sample_of
from sim.numbers import WorldNumbers

STEP_NS = 1_000_000_000
"""Between two readings of what has no clock. Choice."""


def origin_of(subject: Subject, target: str, **more: Any) -> Origin:
    """Return the origin of decisions of a subject."""
    robot, genome = subject.robot, subject.genome
    return Origin(
        target, robot.name, robot.role, robot.digest, genome.digest if genome else None, **more
    )


def record_readings(
    subject: Subject,
    target: Target,
    stimuli: Sequence[Stimulus],
    source: dict[str, Any],
    seed: int | None = None,
) -> tuple[Trace, int]:
    """Ask an open target for its decision about each reading.

    Args:
        subject: what decides.
        target: where.
        stimuli: in this order.
        source: for the sidecar: how these readings came about.
        seed: likewise.

    Returns:
        The trace, and how many readings were left out because the target cannot be given them.

    Raises:
        RigError: the target is sick; nothing was recorded.
        UnprovenError: it can be given none of them.
    """
    admits = getattr(target, "admits", None)
    wanted = [one for one in stimuli if admits is None or admits(one)]
    if not wanted:
        raise UnprovenError(
            f"{target.url}: can be given none of the {len(stimuli)} readings; record others"
        )
    samples = tuple(
        sample_of(n * STEP_NS, stimulus, (n + 1) & 0xFFFF, target.decide(stimulus))
        for n, stimulus in enumerate(wanted)
    )
    kind = kind_of(target.url)
    origin = origin_of(subject, kind, images=images_of(subject, target), seed=seed, source=source)
    return Trace(target.url, samples, origin), len(stimuli) - len(wanted)


def kind_of(url: str) -> str:
    """Return what decides behind a target's name, as a sidecar has it.

    >>> kind_of("serial-reset:/dev/ttyUSB0"), kind_of("emulator:registers")
    ('serial', 'emulator')
    """
    return url.partition(":")[0].removesuffix("-reset")


def images_of(subject: Subject, target: Target) -> dict[str, str]:
    """Return the digests of what decided; a serial target has compared its chip's on opening."""
    if IMAGE not in target.caps:
        return {}
    if kind_of(target.url) == "serial":
        return {"main": subject.images["main"].digest}
    return target.identity().images


def episode_readings(
    genome: Genome, numbers: WorldNumbers, start: NDArray[np.float64], steps: int, role: Role
) -> list[Stimulus]:
    """Return what a robot senses in an episode of the simulator, up to the capture.

    Args:
        genome: the predator's.
        numbers: of the world.
        start: shape (1, 8).
        steps: at most.
        role: whose readings.
    """
    looks = episode_of(genome, numbers, start, steps).looks
    side = 0 if role is Role.PREDATOR else 1
    return [stimuli_of(row)[side] for row in looks.tolist()]


def episode_source(
    role: Role,
    poses: dict[str, tuple[float, float, float]],
    steps: int,
    genome: Genome,
    options: dict[str, Any],
) -> dict[str, Any]:
    """Return how the readings of an episode came about, for the sidecar.

    Args:
        role: whose readings.
        poses: x_units, y_units, heading_deg by robot.
        steps: at most.
        genome: the predator's.
        options: open points of the world that were given.
    """
    told = {name: list(pose) for name, pose in poses.items()}
    row = {"of": str(role), **told, "steps": steps, "genome": genome.digest}
    return {"episode": row | ({"options": options} if options else {})}


def without_decisions(trace: Trace) -> Trace:
    """Return the readings of a trace alone."""
    samples = (Sample(one.time_ns, one.stimulus, one.seq, where=one.where) for one in trace.samples)
    origin = trace.origin and replace(trace.origin, genome=None)
    return Trace(trace.name, tuple(samples), origin)


def sweep(robot: Robot) -> list[Stimulus]:
    """Return readings in which one sensor after the other goes from near to far, the rest calm."""
    lights = (UNLIT_COUNT, UNLIT_COUNT) if robot.light else ()
    plain = Stimulus((NO_ECHO_COUNT,) * len(robot.sonars), (False, False), lights)
    found = [plain]
    for index, sonar in enumerate(robot.sonars):
        fewest, most = robot.echo_limits_counts(sonar)
        for count in _rising(int(fewest), int(most)):
            found.append(with_values(plain, {index: count}))
    for touched in ((True, False), (True, True), (False, True)):
        found.append(replace(plain, touched=touched))
    if robot.light:
        curves = [sensor.curve for sensor in robot.light.sensors]
        near, far = min(one[0][1] for one in curves), max(one[-1][1] for one in curves)
        for count in _rising(near, far):
            pairs = ((count, UNLIT_COUNT), (UNLIT_COUNT, count), (count, count))
            found += [replace(plain, lights=pair) for pair in pairs]
    return found


def _rising(low: int, high: int) -> list[int]:
    """Return whole numbers from low to high, each twice the one before.

    >>> _rising(10, 50)
    [10, 20, 40, 50]
    """
    found = [low]
    while found[-1] * 2 < high:
        found.append(found[-1] * 2)
    return [*found, high]
