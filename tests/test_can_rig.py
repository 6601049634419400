"""The emulated rig itself: its answers, frame by frame."""

from dataclasses import replace
from typing import Any

import pytest

from cgagen.errors import ExecutionError
from cgagen.stamp.chips import EEPROM_BYTES
from cgagen.stamp.image import Image
from hil.frames import Frame, Question, Units, decision_of, frame, frames_of, question_frames
from hil.messages import (
    BY_ID,
    OBS_DECISION,
    OBS_SERVOS,
    RIG_BANNER,
    RIG_CMD,
    RIG_IDENTITY,
    RIG_STATUS,
    STIM_APPLY,
    Fault,
    Op,
    Report,
    State,
    unpack,
)
from hil.rig_protocol import Rig
from hil.simulated import SimulatedTarget
from hil.target import Stimulus
from tests.rig_cases import command, greeted, nothing, opened
from tests.subjects import subject

BS2P = Units(750, 750)
NEAR = Stimulus((1_000, 9_000, 9_000), lights=(0, 0))


@pytest.fixture
def rig() -> Rig:
    return greeted()


def said(rig: Rig, *frames: Frame) -> list[tuple[str, dict[str, int]]]:
    """All that the rig answers."""
    answers = [answer for one in frames for answer in rig.receive(one)]
    return [(BY_ID[one.id].name, unpack(BY_ID[one.id], one.data)) for one in answers]


def reports(rig: Rig, *frames: Frame) -> list[Report]:
    return [Report(v["ERROR"]) for name, v in said(rig, *frames) if name == RIG_STATUS.name]


def decisions(rig: Rig, *frames: Frame) -> list[dict[str, int]]:
    return [values for name, values in said(rig, *frames) if name == OBS_DECISION.name]


def test_hello_is_answered_with_the_nonce_and_the_banner(rig: Rig) -> None:
    identity, banner, status = said(rig, command(Op.HELLO, 7, 0xDEADBEEF))
    assert identity == (
        RIG_IDENTITY.name,
        {
            "NONCE": 0xDEADBEEF,
            "PROTOCOL": 1,
            "SONARS": 3,
            "LIGHTS": 2,
            "HEARS": 1,
            "SWITCHES_POWER": 1,
            "SEES_SERVOS": 1,
            "JITTER": 0,
        },
    )
    assert banner[0] == RIG_BANNER.name
    assert f"{banner[1]['GENOME']:08x}" == subject("predator").genome_digest
    assert status[1]["SEQ"] == 7
    assert status[1]["STATE"] == State.IDLE


def test_a_question_has_one_answer_between_running_and_idle(rig: Rig) -> None:
    heard = said(rig, *frames_of(NEAR, 5, BS2P))
    assert [name for name, _ in heard] == ["RIG_STATUS", "OBS_DECISION", "RIG_STATUS"]
    assert [heard[0][1][key] for key in ("STATE", "SEQ", "ERROR")] == [State.RUNNING, 5, 0]
    assert [heard[2][1][key] for key in ("STATE", "SEQ", "ERROR")] == [State.IDLE, 5, 0]
    wanted = SimulatedTarget(subject("predator")).decide(NEAR)
    assert (heard[1][1]["COMMAND"], heard[1][1]["STATE"]) == (wanted.command, wanted.state)
    assert heard[1][1]["LATENCY"] * 50 > 70_000_000


def test_the_same_questions_get_the_same_frames() -> None:
    questions = [*frames_of(NEAR, 1, BS2P), *frames_of(nothing("predator"), 2, BS2P)]
    first, second = (said(opened(Rig(subject("predator"))), *questions) for _ in range(2))
    assert first == second
    times = [values["RIG_TIME_MS"] for name, values in first if name == "RIG_STATUS"]
    assert times == sorted(times)
    assert times[-1] > times[0] > 0


def test_a_threshold_lies_between_two_raw_counts(rig: Rig) -> None:
    """The chip counts whole units: one raw count of 50 ns below a threshold is below it."""
    limit = subject("predator").robot.situation_counts.front_near
    answers = []
    for seq, ticks in enumerate((15 * limit - 1, 15 * limit), 1):
        question = Question(seq, (ticks, 0, 0), (False, False), (0, 0))
        answers += decisions(rig, *question_frames(question))
    simulator = SimulatedTarget(subject("predator"))
    wanted = [
        simulator.decide(Stimulus((count, 0, 0), lights=(0, 0))).state
        for count in (limit - 1, limit)
    ]
    assert [one["STATE"] for one in answers] == wanted
    assert wanted[0] != wanted[1]


def test_a_repeated_question_is_not_answered_again(rig: Rig) -> None:
    question = frames_of(NEAR, 40_000, BS2P)
    assert len(decisions(rig, *question)) == 1
    assert set(reports(rig, *question)) == {Report.OLD_SEQ}
    assert set(reports(rig, *frames_of(NEAR, 39_999, BS2P))) == {Report.OLD_SEQ}
    assert len(decisions(rig, *frames_of(NEAR, 40_001, BS2P))) == 1


def test_numbers_go_on_after_the_last(rig: Rig) -> None:
    for seq in (65_535, 0, 1):
        assert [one["SEQ"] for one in decisions(rig, *frames_of(NEAR, seq, BS2P))] == [seq]


def test_frames_of_a_question_come_in_any_order_before_apply(rig: Rig) -> None:
    a, b, light, apply = frames_of(NEAR, 1, BS2P)
    assert len(decisions(rig, light, b, a, apply)) == 1


def test_an_incomplete_question_is_not_asked(rig: Rig) -> None:
    a, b, light, apply = frames_of(NEAR, 1, BS2P)
    assert reports(rig, a, light, apply) == [Report.INCOMPLETE]
    assert len(decisions(rig, b, apply)) == 1  # what was missing may follow
    other = frames_of(NEAR, 3, BS2P)
    assert reports(rig, *frames_of(NEAR, 2, BS2P)[:3], other[0], other[3]) == [Report.INCOMPLETE]


def test_what_the_rig_cannot_present_is_refused(rig: Rig) -> None:
    six = Stimulus((1,) * 6)
    assert reports(rig, *frames_of(six, 1, BS2P)) == [Report.BAD_FRAME]
    assert reports(rig, *frames_of(NEAR, 2, BS2P, 0x0999)) == [Report.UNKNOWN_FAULT]
    assert reports(rig, *frames_of(NEAR, 3, BS2P, Fault.NO_ECHO_5)) == [Report.UNKNOWN_FAULT]
    assert reports(rig, Frame(STIM_APPLY.id, bytes(7))) == [Report.BAD_FRAME]
    assert reports(rig, Frame(RIG_CMD.id, b"")) == [Report.BAD_FRAME]
    assert reports(rig, command(77)) == [Report.BAD_FRAME]
    assert said(rig, Frame(0x123, bytes(8)), frame(OBS_DECISION), frame(RIG_STATUS)) == []


def test_an_armed_rig_says_so(rig: Rig) -> None:
    assert said(rig, frames_of(NEAR, 1, BS2P)[0]) == []
    assert unpack(RIG_STATUS, rig.heartbeat().data)["STATE"] == State.ARMED
    assert said(rig, command(Op.HELLO))[-1][1]["STATE"] == State.IDLE


def test_a_robot_without_power_does_nothing(rig: Rig) -> None:
    assert said(rig, command(Op.POWER_OFF))[-1][1]["STATE"] == State.OFF
    assert reports(rig, *frames_of(NEAR, 1, BS2P)) == [Report.NO_POWER]
    assert reports(rig, command(Op.RESET)) == [Report.NO_POWER]
    assert reports(rig, command(Op.SERVOS, 3, 1)) == [Report.NO_POWER]
    assert said(rig, command(Op.POWER_ON))[-1][1]["STATE"] == State.IDLE
    assert len(decisions(rig, *frames_of(NEAR, 1, BS2P))) == 1


def test_servo_frames_are_numbered_on(rig: Rig) -> None:
    assert reports(rig, command(Op.SERVOS, 1, 3)) == [Report.NO_SERVOS]  # nothing was asked yet
    list(said(rig, *frames_of(NEAR, 1, BS2P)))
    assert reports(rig, command(Op.SERVOS, 2, 0)) == [Report.BAD_FRAME]
    heard = said(rig, command(Op.SERVOS, 3, 3))
    names = [name for name, _ in heard]
    assert names == ["RIG_STATUS", *[message.name for message in OBS_SERVOS] * 3, "RIG_STATUS"]
    numbers = [values["FRAME"] for name, values in heard if name.startswith("OBS_SERVO")]
    first = numbers[0]
    assert numbers == [first + n // 4 for n in range(12)]
    assert heard[-1][1]["SEQ"] == 3
    assert [values["FRAME"] for _, values in said(rig, command(Op.SERVOS, 4, 1))[1:5]] == [
        first + 3
    ] * 4


@pytest.mark.parametrize(
    ("fault", "stimulus", "fires"),
    [
        (Fault.NO_ECHO_0, NEAR, True),
        (Fault.NO_ECHO_0, Stimulus((0, 1_000, 9_000), lights=(0, 0)), False),
        (Fault.TOUCHED_L, NEAR, True),
        (Fault.TOUCHED_L, Stimulus(NEAR.sonars, (True, False), (0, 0)), False),
        (Fault.TORN_R, Stimulus(NEAR.sonars, (False, True), (0, 0)), True),
        (Fault.TORN_R, NEAR, False),
        (Fault.DARK_R, Stimulus(NEAR.sonars, lights=(0, 170)), True),
        (Fault.COMMAND_CUT_0, NEAR, True),
        (Fault.COMMAND_CUT_2, NEAR, True),
    ],
)
def test_a_fault_says_whether_it_fired_and_is_gone_afterwards(
    rig: Rig, fault: Fault, stimulus: Stimulus, fires: bool
) -> None:
    spoilt = said(rig, *frames_of(stimulus, 1, BS2P, fault))
    assert [Report(v["ERROR"]) for n, v in spoilt if n == "RIG_STATUS"] == [
        Report.NONE,
        Report.FAULT_FIRED if fires else Report.FAULT_SILENT,
        Report.NONE,
    ]
    decided = next(values for name, values in spoilt if name == "OBS_DECISION")
    simulator = SimulatedTarget(subject("predator"))
    assert decided["STATE"] == simulator.decide(as_spoilt(stimulus, fault)).state
    wanted = simulator.decide(as_spoilt(stimulus, fault)).command
    if fault in (Fault.COMMAND_CUT_0, Fault.COMMAND_CUT_2):
        wanted &= ~(1 << fault - Fault.COMMAND_CUT_0)
    assert decided["COMMAND"] == wanted
    after = decisions(rig, *frames_of(stimulus, 2, BS2P))
    assert after[0]["STATE"] == simulator.decide(stimulus).state
    assert after[0]["COMMAND"] == simulator.decide(stimulus).command


def as_spoilt(stimulus: Stimulus, fault: Fault) -> Stimulus:
    """What a robot with the fault senses."""
    sonars, touched, lights = list(stimulus.sonars), list(stimulus.touched), list(stimulus.lights)
    part = fault & 0xFF
    match fault & 0xFF00:
        case 0x0100:
            sonars[part] = 0
        case 0x0200:
            touched[part] = True
        case 0x0300:
            touched[part] = False
        case 0x0400:
            lights[part] = 0
    return Stimulus(tuple(sonars), (touched[0], touched[1]), tuple(lights))


def test_a_robot_without_telemetry_shows_no_state(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rig.robot, "told", lambda: None)
    answer = decisions(rig, *frames_of(NEAR, 1, BS2P))[0]
    assert (answer["VALID"], answer["STATE_VALID"], answer["STATE"]) == (1, 0, 0)


def test_a_program_that_hangs_gives_an_answer_without_decision(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rig.robot, "look", lambda: None)
    heard = said(rig, *frames_of(NEAR, 1, BS2P))
    assert decision_of(frame(OBS_DECISION, **heard[1][1]).data) is None
    assert heard[2][1]["ERROR"] == Report.NO_DECISION


def test_a_program_that_never_looks_gives_no_decision() -> None:
    """A chip full of zeros: there is no first look, and the rig says so at each question."""
    one = subject("predator")
    empty = Image(one.images["main"].model, bytes(EEPROM_BYTES))
    rig = opened(Rig(replace(one, images={**one.images, "main": empty})))
    identity, banner, _ = said(rig, command(Op.HELLO))
    assert (identity[1]["HEARS"], banner[1]) == (1, {"GENOME": 0, "SOURCE": 0})
    heard = decisions(rig, *frames_of(NEAR, 1, BS2P))
    assert [(answer["SEQ"], answer["VALID"]) for answer in heard] == [(1, 0)]


def test_a_rig_that_fails_says_so_until_it_is_reset(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: Any) -> None:
        raise ExecutionError("an opcode that is none")

    with monkeypatch.context() as patch:
        patch.setattr(rig.robot, "look", broken)
        assert reports(rig, *frames_of(NEAR, 1, BS2P)) == [Report.NONE, Report.SICK]
    assert reports(rig, *frames_of(NEAR, 2, BS2P)) == [Report.SICK]
    assert unpack(RIG_STATUS, rig.heartbeat().data)["STATE"] == State.FAULT
    assert reports(rig, command(Op.RESET, 3)) == [Report.NONE]
    assert len(decisions(rig, *frames_of(NEAR, 4, BS2P))) == 1
