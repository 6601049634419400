"""Traces replayed and recorded: on every target, with faults planted, from a robot at work."""

import dataclasses
from collections.abc import Callable
from itertools import count
from pathlib import Path
from typing import Any

import can
import pytest

from cgagen.emulator.parts.sonar import Sonar
from cgagen.errors import IdentityError, RigError, RobotError, TraceError
from cgagen.stamp.image import Image
from cgagen.tokenizer import Tokenizer
from cgagen.words import Role
from hil.canbus import CanTarget
from hil.emulated import PinsTarget, robot_bench
from hil.equivalence import Verdict
from hil.explainers import explainer
from hil.outcome import finding_lines
from hil.pipe import BytePipe
from hil.registers import RegisterTarget
from hil.rig import RigOnBus
from hil.rig_protocol import Rig
from hil.simulated import SimulatedTarget
from hil.subject import Subject
from hil.target import Observation, Stimulus
from hil.traces import Origin, Replay, Trace, listening, read_trace, replay, write_trace
from hil.traces.listening import Listener, record_telemetry
from hil.traces.recording import origin_of, record_readings, without_decisions
from hil.traces.vectors import parse_vectors
from hil.wired import WiredTarget
from tests.rig_cases import channel
from tests.subjects import subject
from tests.trace_cases import CALM, HEAD, PREDATOR, some


@pytest.fixture(scope="module")
def predator() -> Subject:
    return subject("predator")


def test_a_replay_passes_on_the_simulator_and_through_the_pins(predator: Subject) -> None:
    trace = some(predator)
    for target in (SimulatedTarget(predator), PinsTarget(predator)):
        target.open()
        result = replay(predator, target, trace)
        assert (result.verdict, result.reason, result.index) == (Verdict.PASS, "", None)
        assert result.decisions == len(trace.samples)
        assert result.unproven == ()


def test_what_cannot_be_given_is_unproven(predator: Subject) -> None:
    plain = parse_vectors(f"{HEAD}\n0,{CALM},,,\n1,65535{CALM[1:]},,,", "v.csv", PREDATOR)
    with PinsTarget(predator) as target:
        result = replay(predator, target, plain)
        assert (result.verdict, result.decisions, result.unproven) == (Verdict.PASS, 1, (1,))
        alone = dataclasses.replace(plain, samples=plain.samples[1:])
        assert replay(predator, target, alone).verdict is Verdict.UNPROVEN


def with_sample(trace: Trace, index: int, **changes: Any) -> Trace:
    samples = list(trace.samples)
    samples[index] = dataclasses.replace(samples[index], **changes)
    return dataclasses.replace(trace, samples=tuple(samples))


def test_the_first_wrong_recording_is_named(predator: Subject) -> None:
    trace = with_sample(some(predator), 4, command=(some(predator).samples[4].command or 0) ^ 1)
    trace = with_sample(trace, 2, state=63, where="line 14")
    result = replay(predator, SimulatedTarget(predator), trace)
    assert (result.verdict, result.index, result.time_ns) == (Verdict.FAIL, 2, 2 * 10**9)
    assert result.contradicted == ("recording",)
    assert "line 14: reading 3 at 2.000000 s" in result.reason
    assert "the trace has state 63" in result.reason
    assert result.smallest is not None
    assert result.smallest.stimulus == trace.samples[2].stimulus
    assert result.agreed == result.tried  # the target itself is right
    assert finding_lines(result.smallest, predator)[2].startswith("recorded: state 63, command ")
    alone = with_sample(some(predator), 2, state=63, command=None)
    small = replay(predator, SimulatedTarget(predator), alone).smallest
    assert small is not None
    assert finding_lines(small, predator)[2] == "recorded: state 63"


def other_gene(subject: Subject, state: int) -> Image:
    """Return the main controller's image with another answer to a state."""
    image = subject.images["main"]
    assert subject.genome is not None
    eeprom = bytearray(image.eeprom)
    eeprom[bytes(eeprom).index(bytes(subject.genome.commands())) + state] ^= 1
    return Image(image.model, bytes(eeprom))


def test_a_wrong_gene_is_found_where_it_shows_first(
    predator: Subject, tokenizer: Tokenizer
) -> None:
    trace = some(predator, 8)
    state = trace.samples[5].state
    assert state is not None
    images = {**predator.images, "main": other_gene(predator, state)}
    with RegisterTarget(predator, tokenizer.compile, images) as target:
        result = replay(predator, target, trace, explainer(predator, target))
    assert (result.verdict, result.index) == (Verdict.FAIL, 5)
    assert result.contradicted == ("target",)
    assert f"answers state {state} with command" in result.reason
    assert f"decided in {predator.files['main']}:" in result.reason
    line = result.findings[0].lines[0]
    assert predator.sources["main"].splitlines()[line.number - 1] == line.text
    assert result.agreed[state] == 0
    assert isinstance(result, Replay)
    wrong = with_sample(trace, 5, command=(trace.samples[5].command or 0) ^ 2)
    with RegisterTarget(predator, tokenizer.compile, images) as target:
        assert replay(predator, target, wrong).contradicted == ("target", "recording")
        early = with_sample(trace, 1, command=(trace.samples[1].command or 0) ^ 1)
        late = replay(predator, target, early)
    assert (late.index, late.contradicted) == (1, ("recording",))


class Sick(SimulatedTarget):
    """Falls silent at its third question."""

    asked = 0

    def decide(self, stimulus: Stimulus) -> Observation:
        self.asked += 1
        if self.asked == 3:
            raise RigError("the cable is torn")
        return super().decide(stimulus)


def test_a_sick_target_is_blocked_and_a_wrong_recording_still_fails(predator: Subject) -> None:
    trace = some(predator)
    result = replay(predator, Sick(predator), trace)
    assert (result.verdict, result.reason) == (Verdict.BLOCKED, "the cable is torn")
    wrong = with_sample(trace, 5, state=63)
    assert replay(predator, Sick(predator), wrong).verdict is Verdict.FAIL


def test_decisions_of_another_genome_are_no_evidence(predator: Subject, tmp_path: Path) -> None:
    trace = some(predator)
    assert trace.origin is not None
    other = dataclasses.replace(trace, origin=dataclasses.replace(trace.origin, genome="ab" * 32))
    with pytest.raises(TraceError, match=r"decisions are those of genome abababab.*readings-only"):
        replay(predator, SimulatedTarget(predator), other)
    readings = without_decisions(other)
    assert replay(predator, SimulatedTarget(predator), readings).verdict is Verdict.PASS


def test_a_trace_of_the_other_robot_is_not_replayed() -> None:
    prey, hunter = subject("prey"), subject("predator")
    trace = Trace("x.csv", without_decisions(some(prey)).samples)
    with pytest.raises(TraceError, match="the reading has 6 sonars and 0 light sensors"):
        replay(hunter, SimulatedTarget(hunter), trace)


def test_a_trace_is_replayed_over_the_bench_hook(predator: Subject, tmp_path: Path) -> None:
    """And recorded there, by a target that is reset when it is opened."""
    trace = some(predator, 4)
    with BytePipe(robot_bench(predator.robot, predator.images), "main", "rfc2217") as pipe:
        target = WiredTarget(pipe.url, predator, gaps=False, reset=True)
        target.open()
        result = replay(predator, target, trace)
        again, left_out = record_readings(predator, target, trace.stimuli, {})
        target.close()
    assert (result.verdict, result.decisions) == (Verdict.PASS, 4)
    assert (again.samples, left_out) == (trace.samples, 0)
    write_trace(tmp_path / "again.log", again, predator.robot)
    origin = read_trace(tmp_path / "again.log", predator.robot).origin
    assert origin is not None
    assert (origin.target, origin.images) == ("serial", {"main": predator.images["main"].digest})


def test_a_trace_is_replayed_and_recorded_on_a_rig(predator: Subject, tmp_path: Path) -> None:
    """What was on the bus meanwhile is a trace, too, commands of the host and all."""
    trace = some(predator, 4)
    rig = Rig(predator)
    rig.open()
    with RigOnBus(rig, channel()) as served:
        tap = can.Bus(interface="virtual", channel=served.url.split(":", 2)[2], ignore_config=True)
        target = CanTarget(served.url, predator)
        target.open()
        result = replay(predator, target, trace)
        target.reset()
        again, _ = record_readings(predator, target, trace.stimuli, {})
        target.close()
    frames = list(iter(lambda: tap.recv(0), None))
    tap.shutdown()
    assert (result.verdict, result.decisions) == (Verdict.PASS, 4)
    assert again.origin is not None
    assert (again.origin.target, again.origin.images) == ("can", {})
    decided = [(one.stimulus, one.state, one.command) for one in trace.samples]
    assert [(one.stimulus, one.state, one.command) for one in again.samples] == decided
    with can.Logger(tmp_path / "bus.log") as writer:
        for one in sorted(frames, key=lambda message: message.timestamp):
            writer.on_message_received(one)
    heard = read_trace(tmp_path / "bus.log", PREDATOR)
    assert [(one.stimulus, one.state, one.command) for one in heard.samples] == decided * 2
    assert heard.samples[0].time_ns == 0
    assert [one.seq for one in heard.samples] == list(range(1, 9))


# -- Recording


def test_recording_twice_gives_the_same_bytes(predator: Subject, tmp_path: Path) -> None:
    files = []
    for folder in ("one", "two"):
        (tmp_path / folder).mkdir()
        with PinsTarget(predator) as target:
            stimuli = [*some(predator).stimuli, Stimulus((65_535, 0, 0), lights=(0, 0))]
            trace, left_out = record_readings(predator, target, stimuli, {"level": "x"}, 1)
        assert left_out == 1
        assert all(one.latency_ns for one in trace.samples)
        write_trace(tmp_path / folder / "a.log", trace, PREDATOR)
        files.append({one.name: one.read_bytes() for one in (tmp_path / folder).iterdir()})
    assert files[0] == files[1]
    assert set(files[0]) == {"a.log", "a.log.json", "rig.dbc"}


def hunting(subject: Subject) -> Any:
    """Return the bench of a robot whose first sonar sees something nearer each time."""
    bench = robot_bench(subject.robot, subject.images)
    first = bench.parts_of(Sonar)[f"sonar_{subject.robot.sonars[0].name}"]

    class Nearing:
        width_ns = 4_000_000

        def spoil(self, answer: Any) -> Any:
            self.width_ns -= 300_000
            return answer._replace(width_ns=self.width_ns)

    first.spoilers.append(Nearing())
    return bench


@pytest.mark.parametrize(("role", "kind"), [(Role.PREDATOR, "socket"), (Role.PREY, "pty")])
def test_a_robot_at_work_is_recorded_and_replayed(role: Role, kind: str) -> None:
    one = subject(str(role))
    ticks = iter(range(10**9, 10**12, 1_234_567))
    with BytePipe(hunting(one), kind=kind) as pipe:
        trace, heard = record_telemetry(one, pipe.url, 4, 500.0, lambda: next(ticks))
    assert (heard.lost, heard.spoiled, len(trace.samples)) == (0, 0, 4)
    counts = [one.stimulus.sonars[0] for one in trace.samples]
    assert counts == sorted(counts, reverse=True)
    assert len(set(counts)) == 4
    assert [one.time_ns for one in trace.samples] == [0, 1_234_000, 2_469_000, 3_703_000]
    assert trace.origin is not None
    assert (trace.origin.clock, trace.origin.target) == ("host", "serial")
    told = {"lost": 0, "spoiled": 0, "banner": heard.greeted}
    assert trace.origin.source == {"telemetry": told}
    with PinsTarget(one) as target:
        result = replay(one, target, trace)
    assert (result.verdict, result.decisions) == (Verdict.PASS, 4)


def listener(subject: Subject) -> Listener:
    ticks = iter(range(0, 10**12, 10**9))
    return Listener(subject, "P", lambda: next(ticks))


LINE = ":{} F1843 R0 L23125 LL170 LR0 AL1 AR0 S15 C3\r"


def test_lost_and_spoiled_lines_are_counted(predator: Subject) -> None:
    one = listener(predator)
    one.take(b"*BUSY\r43 R0 L1\r")
    for text in (LINE.format(254), LINE.format(255), LINE.format(3), ":4 F18R0\r"):
        for letter in text.encode():
            one.take(bytes([letter]))
    one.take(b"\xff\x00" * 2_000 + b"\r:5 F1 R1 L1 LL1 LR1 AL1 AR1 S64 C3\r")
    assert [sample.seq for sample in one.samples] == [1, 2, 3]
    assert (one.lost, one.spoiled, one.greeted) == (3, 2, False)
    banner = f"#1 M {predator.robot.name} {predator.genome_digest} 00000000\r"
    one.take((banner + LINE.format(0)).encode())
    assert (len(one.samples), one.lost, one.greeted) == (4, 3, True)


def test_another_robot_at_work_is_refused(predator: Subject) -> None:
    with pytest.raises(IdentityError, match="P: servobot-prey with genome 12345678 is at work"):
        listener(predator).take(b"#1 M servobot-prey 12345678 9abcdef0\r")


def test_a_robot_that_says_nothing(predator: Subject, monkeypatch: pytest.MonkeyPatch) -> None:
    silent = dataclasses.replace(predator.robot, telemetry=False)
    with pytest.raises(RobotError, match="telemetry: is false"):
        record_telemetry(dataclasses.replace(predator, robot=silent), "loop://", 1, 1.0)
    monkeypatch.setattr(listening, "SILENCE_S", 0.1)
    with pytest.raises(RigError, match=r"loop://: no telemetry in 0\.1 s"):
        record_telemetry(predator, "loop://", 1, 60.0)
    with pytest.raises(RigError, match="cannot be opened"):
        record_telemetry(predator, "/dev/no-such-port", 1, 1.0)


def test_why_nothing_was_heard(predator: Subject) -> None:
    one = listener(predator)
    assert "P: no telemetry in 8 s; switch the robot on" in one.why_nothing(8)
    one.take(b">>*BUSY\r*NONSENSE\r")
    assert "in 8 s (fault BUSY: the step line has been low for longer" in one.why_nothing(8)
    one.take(b":0 FL1 FR2 L3 R4 RL5 RR6 AL1 AR1 S0 C1\r")
    assert "1 lines of telemetry came and none is a servobot-predator's" in one.why_nothing(8)


def test_what_was_heard_before_ctrl_c_is_kept(predator: Subject) -> None:
    def pressed_after(lines: int) -> Callable[[], int]:
        """A clock, which is asked once for each line, on which Ctrl-C comes."""
        ticks = count()

        def now_ns() -> int:
            if next(ticks) == lines:
                raise KeyboardInterrupt
            return 0

        return now_ns

    with BytePipe(hunting(predator)) as pipe:
        trace, _ = record_telemetry(predator, pipe.url, 5, 500.0, pressed_after(2))
        assert len(trace.samples) == 2
        with pytest.raises(KeyboardInterrupt):
            record_telemetry(predator, pipe.url, 5, 500.0, pressed_after(0))


def test_the_origin_of_a_prey_names_no_genome() -> None:
    origin = origin_of(subject("prey"), "simulator")
    assert (origin.genome, origin.role) == (None, Role.PREY)
    assert isinstance(origin, Origin)
