"""Traces: from a recording to a file, and from files of this and other tools to readings."""

import dataclasses
import gzip
import re
from pathlib import Path

import can
import pytest

from cgagen.counts import echo_count, light_count
from cgagen.errors import TraceError
from cgagen.words import Role
from hil.frames import Frame
from hil.simulated import SimulatedTarget
from hil.stimuli import sample
from hil.target import Observation, Stimulus
from hil.traces import Sample, Trace, read_trace, write_trace
from hil.traces.candump import log_text
from hil.traces.questions import frames_of_samples
from hil.traces.recording import record_readings, without_decisions
from hil.traces.shipped import FOLDER
from hil.traces.shown import rows_of
from hil.traces.storage import trace_bytes
from hil.traces.values import sample_of
from hil.traces.vectors import parse_vectors, vectors_text
from tests.subjects import subject
from tests.trace_cases import (
    CALM,
    HEAD,
    PREDATOR,
    log_of,
    messages,
    parsed,
    predator,
    simulated,
    some,
)


@pytest.mark.parametrize("role", list(Role))
@pytest.mark.parametrize("suffix", [".log", ".csv"])
def test_what_is_written_is_read_again(role: Role, suffix: str, tmp_path: Path) -> None:
    one = subject(str(role))
    trace = simulated(one, list(sample(one.robot, 40, 3)))
    late = dataclasses.replace(trace.samples[5], latency_ns=92_400_450)
    bare = dataclasses.replace(trace.samples[6], state=None, command=None)
    blind = dataclasses.replace(trace.samples[7], state=None)
    samples = (*trace.samples[:5], late, bare, blind, *trace.samples[8:])
    trace = dataclasses.replace(trace, samples=samples)
    path = tmp_path / f"a{suffix}"
    write_trace(path, trace, one.robot)
    again = read_trace(path, one.robot)
    assert (again.samples, again.origin, again.stale) == (trace.samples, trace.origin, 0)
    assert trace_bytes(again, one.robot, suffix) == path.read_bytes()


def test_the_log_is_what_python_can_writes(tmp_path: Path) -> None:
    trace = some(predator())
    theirs = tmp_path / "theirs.log"
    with can.CanutilsLogWriter(theirs) as writer:
        for message in messages(trace):
            writer.on_message_received(message)
    assert theirs.read_text() == log_of(trace)
    assert all(
        re.fullmatch(r"\(\d+\.\d{6}\) can0 [0-9A-F]{3}#[0-9A-F]{16} [TR]", line)
        for line in log_of(trace).splitlines()
    )


@pytest.mark.parametrize("suffix", [".asc", ".blf", ".trc", ".log"])
@pytest.mark.parametrize("epoch_s", [0.0, 1_700_000_000.0])
def test_other_tools_files_hold_the_same_readings(
    suffix: str, epoch_s: float, tmp_path: Path
) -> None:
    """Channels come back renumbered, and .asc loses the epoch: neither is part of a trace."""
    trace = some(predator())
    samples = (dataclasses.replace(s, time_ns=s.time_ns // 9_999 * 1_000) for s in trace.samples)
    trace = dataclasses.replace(trace, samples=tuple(samples))
    path = tmp_path / f"a{suffix}"
    channel = "can0" if suffix == ".log" else 0
    with can.Logger(path) as writer:
        for message in messages(trace, epoch_s, channel):
            writer.on_message_received(message)
    again = read_trace(path, PREDATOR)
    assert again.samples == trace.samples
    assert again.origin is None


def test_a_packed_log_is_read(tmp_path: Path) -> None:
    trace = some(predator())
    path = tmp_path / "a.log.gz"
    path.write_bytes(gzip.compress(log_of(trace).encode()))
    assert read_trace(path, PREDATOR).samples == trace.samples
    path.write_bytes(path.read_bytes()[:-20])
    with pytest.raises(TraceError, match="is cut"):
        read_trace(path, PREDATOR)


def test_candumps_own_lines_are_read() -> None:
    """It writes no direction, and ten digits of seconds. Ref: can-utils' candump -L."""
    trace = some(predator())
    text = re.sub(
        r"\((\d+)\.(\d+)\) can0 (.*) [TR]",
        lambda m: f"({int(m[1]) + 1_436_509_052:010d}.{m[2]}) vcan3 {m[3].lower()}",
        log_of(trace),
    )
    assert parsed(text)[0] == trace.samples


def test_numbers_begin_again_at_0() -> None:
    trace = some(predator(), 5)
    samples = tuple(
        dataclasses.replace(one, seq=(65_533 + n) & 0xFFFF) for n, one in enumerate(trace.samples)
    )
    text = log_of(dataclasses.replace(trace, samples=samples))
    assert parsed(text)[0] == trace.samples
    assert "104#000700000000FFFF T" in text
    assert "104#0007000000000000 T" in text


def test_times_that_no_file_can_hold_are_cut_when_recording() -> None:
    """Otherwise a trace in memory and the same trace from its file would differ."""
    plain = Stimulus((0, 0, 0), lights=(0, 0))
    sample = sample_of(1_999, plain, 1, Observation(9, 4, 0, latency_ns=92_400_479))
    assert sample == Sample(1_000, plain, 1, 0, 4, 92_400_450)


def test_what_is_shown_is_what_was_recorded() -> None:
    wrong = Sample(0, Stimulus((0, 0, 0), lights=(0, 0)), 1, 63, 4)
    [row] = rows_of(Trace("x", (wrong,)), PREDATOR)
    assert (row["state"], row["obstacle"], row["target"]) == (63, "far_front", "far_front")


def test_a_decision_comes_when_the_target_had_decided() -> None:
    samples = [
        Sample(0, Stimulus((0, 0, 0), lights=(0, 0)), 1, 0, 4, 92_400_450),
        Sample(1_000_000, Stimulus((0, 0, 0), lights=(0, 0)), 2, 0, 4, 92_400_450),
    ]
    times = [time for time, frame in frames_of_samples(samples, PREDATOR) if frame.id == 0x200]
    assert times == [1_000, 93_400]


def test_inches_are_the_simulators_counts() -> None:
    text = (
        "# a comment\n"
        f"{HEAD.replace('_counts', '_in')}\n"
        "20.5,10,none,9.999999,1,0,12,dark,40,FORWARD,\n"
        "\n"
        "21,0.1,9999,36,0,1,60,1,,,92.05\n"
    )
    trace = parse_vectors(text, "v.csv", PREDATOR)
    limits = [PREDATOR.echo_limits_counts(sonar) for sonar in PREDATOR.sonars]
    per_in, curve = PREDATOR.echo_counts_per_in, PREDATOR.light_curve(0)
    assert trace.samples[0] == Sample(
        0,
        Stimulus(
            (echo_count(10, per_in, *limits[0]), 0, echo_count(9.999999, per_in, *limits[2])),
            (True, False),
            (light_count(12, curve), 0),
        ),
        1,
        40,
        0,
    )
    assert trace.samples[0].stimulus.sonars[0] == PREDATOR.situation_counts.front_near
    assert trace.samples[1].time_ns == 500_000
    assert trace.samples[1].latency_ns == 92_050
    assert trace.samples[1].stimulus.sonars[:2] == (int(limits[0][0]), int(limits[1][1]))
    assert (trace.samples[0].where, trace.samples[1].where) == ("line 3", "line 5")


def test_columns_without_content_are_left_out() -> None:
    bare = without_decisions(some(predator()))
    assert vectors_text(bare, PREDATOR).splitlines()[0] == HEAD.removesuffix(
        ",state,command,latency_us"
    )
    assert bare.origin is not None
    assert bare.origin.genome is None


def test_a_state_alone_has_no_room_in_frames() -> None:
    trace = parse_vectors(f"{HEAD}\n0,{CALM},0,,", "v.csv", PREDATOR)
    with pytest.raises(TraceError, match=r"v\.csv: line 2: a state without a command"):
        trace_bytes(trace, PREDATOR, ".log")


def test_no_name_of_a_machine_or_folder_is_in_a_file(tmp_path: Path) -> None:
    target = SimulatedTarget(predator())
    target.url = "serial:/dev/ttyUSB7"
    trace, _ = record_readings(predator(), target, some(predator()).stimuli, {})
    write_trace(tmp_path / "a.log", trace, PREDATOR)
    text = (tmp_path / "a.log.json").read_text()
    assert '"target": "serial"' in text
    assert "ttyUSB7" not in text
    assert str(tmp_path) not in text


def test_frames_are_named_by_the_table() -> None:
    with pytest.raises(KeyError):
        log_text([(0, Frame(0x7FF, bytes(8)))])


def test_the_recorded_traces_are_beside_the_code() -> None:
    names = {path.name for path in FOLDER.glob("*.log")}
    assert {"hunt.log", "wall.log", "sweep.log"} <= names
    assert list(FOLDER.glob("*.csv"))
