"""The recorded traces: replayed on every target with zero tolerance, and recorded again.

They are of the reference genome; firmware of another genome is given their readings alone.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from cgagen.robot import load_robot
from hil.equivalence import Trial
from hil.registers import RegisterTarget
from hil.simulated import SimulatedTarget
from hil.subject import Subject
from hil.target import Target
from hil.traces import Trace, read_trace, replay
from hil.traces.recording import without_decisions
from hil.traces.shipped import FIRMWARE, FOLDER, ROLES, reference, write_all
from hil.traces.sidecar import read_origin

pytestmark = pytest.mark.hil_req("TRACES")

Check = Callable[[Target, Trace], Trial]


def traces_of(subject: Subject) -> list[Trace]:
    """Return the traces of a robot's kind; without decisions, where those are of another."""
    robot = load_robot(f"servobot-{subject.role}")
    names = [name for name, role in ROLES.items() if role is subject.role]
    found = [read_trace(FOLDER / name, robot) for name in names]
    return [trace if _is_of(trace, subject) else without_decisions(trace) for trace in found]


def _is_of(trace: Trace, subject: Subject) -> bool:
    origin, genome = trace.origin, subject.genome
    return origin is not None and (origin.robot_digest, origin.genome) == (
        subject.robot.digest,
        genome.digest if genome else None,
    )


def passes(subject: Subject, target: Target) -> None:
    for trace in traces_of(subject):
        result = replay(subject, target, trace)
        assert result.verdict == "PASS", result.reason
        assert result.decisions + result.left_out == len(trace.samples)


def test_traces_replay_on_the_simulator(hil_subject: Subject) -> None:
    passes(hil_subject, SimulatedTarget(hil_subject))


def test_traces_replay_from_registers(hil_subject: Subject, hil_registers: RegisterTarget) -> None:
    passes(hil_subject, hil_registers)


def test_traces_replay_on_the_target(
    hil_subject: Subject, hil_target: Target, hil_config: Any, hil_check: Check
) -> None:
    """The recorded ones, or those of `--hil-trace`."""
    traces = traces_of(hil_subject)
    if hil_config.traces:
        traces = [one for path in hil_config.traces for one in named(path, hil_subject)]
    if not traces:
        pytest.skip(f"no trace of a {hil_subject.role} was named")
    for trace in traces:
        trial = hil_check(hil_target, trace)
        assert trial.decisions + trial.left_out == len(trace.samples)


def named(path: Path, subject: Subject) -> list[Trace]:
    """Return the trace in a file, unless it is of the other kind of robot."""
    origin = read_origin(path, str(path))
    other = origin is not None and origin.role is not subject.role
    return [] if other else [read_trace(path, subject.robot)]


@pytest.mark.skipif(not FIRMWARE.is_dir(), reason="the reference firmware is in a checkout only")
def test_recording_again_gives_the_same_bytes(tmp_path: Path) -> None:
    """`python -m hil.traces.shipped` is what recorded them."""
    for path in FOLDER.glob("*.csv"):
        (tmp_path / path.name).write_bytes(path.read_bytes())
    write_all(tmp_path, reference())
    again = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    there = {
        path.name: path.read_bytes()
        for path in FOLDER.iterdir()
        if path.suffix in (".log", ".csv", ".json", ".dbc")
    }
    assert set(again) == set(there)
    wrong = [name for name in there if again[name] != there[name]]
    assert not wrong, f"{', '.join(wrong)}: record them anew with python -m hil.traces.shipped"


def test_the_traces_meet_walls_prey_and_touch() -> None:
    """What they are for: a hunt up to the capture, a wall that is touched, every sensor swept."""
    robot = load_robot("servobot-predator")
    hunt, wall, sweep = (
        read_trace(FOLDER / f"{name}.log", robot) for name in ("hunt", "wall", "sweep")
    )
    assert {one.command for one in hunt.samples} > {0}
    assert any(any(one.stimulus.lights) for one in hunt.samples)
    assert any(any(one.stimulus.touched) for one in wall.samples)
    states = [one.state or 0 for one in sweep.samples]
    assert {state // 8 for state in states} == {state % 8 for state in states} == set(range(8))
