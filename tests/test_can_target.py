"""The target behind a rig: what it can show, and what else comes on a bus."""

import can
import pytest

from cgagen.errors import RigError
from hil.emulated import PinsTarget
from hil.equivalence import Verdict, compare
from hil.frames import Frame
from hil.messages import OBS_DECISION, STIM_APPLY, Fault, pack, unpack
from hil.target import LATENCY, PINS, POWER, SERVOS, STATE, Stimulus
from hil.verify import try_target
from tests.predator_rig import PREDATOR, readings, spoilt, target
from tests.rig_cases import nothing
from tests.subjects import subject


def test_a_target_says_what_it_can_and_cannot_show() -> None:
    with spoilt(lambda one: [one]) as bus, target(bus) as one:
        seen = one.identity()
        assert (seen.robot, seen.genome) == ("servobot-predator", subject(PREDATOR).genome_digest)
        assert seen.images == {}
        assert len(seen.nonce) == 8
        assert one.exact_image is False
        assert one.caps == {STATE, PINS, LATENCY, POWER, SERVOS}
        assert "sees no EEPROM; by its own banner the program is of genome" in one.note
        answer = one.decide(nothing(PREDATOR))
        trial = compare(subject(PREDATOR), one, readings(2))
    pins = PinsTarget(subject(PREDATOR))
    with pins:
        wanted = pins.decide(nothing(PREDATOR))
    assert (answer.command, answer.state) == (wanted.command, wanted.state)
    assert answer.latency_ns is not None
    assert wanted.latency_ns is not None
    assert abs(answer.latency_ns - wanted.latency_ns) < 50
    assert trial.note == one.note


def test_numbers_go_on_behind_the_last_of_16_bits(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hil.can_session.secrets.randbelow", lambda most: 65_533)
    with spoilt(lambda one: [one]) as bus, target(bus) as one:
        trial = compare(subject(PREDATOR), one, readings(6))
    assert (trial.verdict, trial.decisions, one.unheard) == (Verdict.PASS, 6, 0)


def test_servo_pulses_are_the_emulators() -> None:
    with spoilt(lambda one: [one]) as bus, target(bus) as one:
        one.decide(nothing(PREDATOR))
        rows = one.servos(4) + one.servos(2)
    pins = PinsTarget(subject(PREDATOR))
    with pins:
        pins.decide(nothing(PREDATOR))
        servos = [
            pins.bench.parts[f"servo_{servo.leg}_{servo.joint}"]
            for servo in subject(PREDATOR).robot.servo_set.servos
        ]
        pins.bench.run(pins.bench.clock.now_ns + 40_000_000)
        wanted = tuple(servo.width_ns for servo in servos)  # type: ignore[attr-defined]
    assert len(rows) == 6
    assert wanted in rows
    unit_ns = subject(PREDATOR).robot.locomotion.pulsout_unit_ns
    assert all(width % unit_ns == 0 and width for row in rows for width in row)


def test_reset_and_power() -> None:
    with spoilt(lambda one: [one]) as bus, target(bus) as one:
        before = one.decide(nothing(PREDATOR))
        one.reset()
        one.power(False)
        with pytest.raises(RigError, match="0,0,0/--/0,0: the robot is off; switch it on"):
            one.decide(nothing(PREDATOR))
        with pytest.raises(RigError, match="RESET: the robot is off"):
            one.reset()
        one.power(True)
        after = one.decide(nothing(PREDATOR))
    assert (before.command, before.state) == (after.command, after.state)
    assert after.seq > before.seq


def test_a_fault_that_is_asked_for_fires_or_does_not() -> None:
    near = Stimulus((1_000, 9_000, 9_000), lights=(0, 0))
    with spoilt(lambda one: [one]) as bus, target(bus) as one:
        assert one.decide(near).state != 0
        assert one.fired is None
        assert one.decide(near, Fault.NO_ECHO_0).state == 0
        assert one.fired is True
        one.decide(near, Fault.TORN_L)
        assert one.fired is False
        with pytest.raises(RigError, match="the rig cannot make that fault"):
            one.decide(near, Fault.NO_ECHO_4)


def test_repeated_and_late_answers_are_discarded_and_counted() -> None:
    old: list[Frame] = []

    def repeat(one: Frame) -> list[Frame]:
        if one.id != OBS_DECISION.id:
            return [one]
        late, old[:] = list(old), [one]
        return [*late, one, one]

    with spoilt(repeat) as bus, target(bus) as one:
        trial = compare(subject(PREDATOR), one, readings())
    assert (trial.verdict, trial.decisions, trial.reason) == (Verdict.PASS, 5, "")
    assert trial.stale == 2 * 4  # the last one comes when nobody asks any more


def test_a_wrong_answer_of_an_old_question_is_not_taken() -> None:
    """An answer to question n - 1 that comes after question n was asked decides nothing."""

    def lag(one: Frame) -> list[Frame]:
        if one.id != OBS_DECISION.id:
            return [one]
        values = unpack(OBS_DECISION, one.data)
        wrong = {**values, "COMMAND": values["COMMAND"] ^ 7, "SEQ": (values["SEQ"] - 1) & 0xFFFF}
        return [Frame(one.id, pack(OBS_DECISION, wrong)), one]

    with spoilt(lag) as bus:
        trial = try_target(subject(PREDATOR), lambda: target(bus), readings())
    assert (trial.verdict, trial.stale) == (Verdict.PASS, 5)


def test_a_wrong_answer_fails() -> None:
    def lie(one: Frame) -> list[Frame]:
        if one.id != OBS_DECISION.id:
            return [one]
        values = unpack(OBS_DECISION, one.data)
        return [Frame(one.id, pack(OBS_DECISION, {**values, "COMMAND": values["COMMAND"] ^ 1}))]

    with spoilt(lie) as bus:
        trial = try_target(subject(PREDATOR), lambda: target(bus), readings())
    assert trial.verdict is Verdict.FAIL
    assert trial.smallest is not None


def test_frames_of_others_are_ignored_and_counted() -> None:
    def noise(one: Frame) -> list[Frame | can.Message]:
        others = [
            can.Message(arbitration_id=0x321, data=b"other", is_extended_id=False),
            can.Message(arbitration_id=OBS_DECISION.id, data=bytes(8), is_extended_id=True),
            can.Message(arbitration_id=OBS_DECISION.id, is_remote_frame=True, is_extended_id=False),
            can.Message(arbitration_id=STIM_APPLY.id, data=bytes(8), is_extended_id=False),
            can.Message(arbitration_id=0x004, is_error_frame=True, is_extended_id=False),
            can.Message(arbitration_id=OBS_DECISION.id, data=bytes(7), is_extended_id=False),
        ]
        return [*others, one] if one.id == OBS_DECISION.id else [one]

    with spoilt(noise) as bus, target(bus) as one:
        trial = compare(subject(PREDATOR), one, readings(3))
        assert one.foreign == "3 error frames, 12 of other devices, 3 of a wrong length"
    assert (trial.verdict, trial.stale, one.unheard) == (Verdict.PASS, 0, 0)


def test_a_controller_off_the_bus_is_blocked() -> None:
    off = can.Message(arbitration_id=0x040, is_error_frame=True, is_extended_id=False)
    with spoilt(lambda one: [off] if one.id == OBS_DECISION.id else [one]) as bus:
        trial = try_target(subject(PREDATOR), lambda: target(bus), readings())
    assert trial.verdict is Verdict.BLOCKED
    assert "the adapter is off the bus after too many errors; look at the wiring" in trial.reason
