"""The target behind a rig: frames that are lost, and rigs that fall silent."""

import time
from collections.abc import Callable, Iterable, Iterator

import can
import pytest

from cgagen.errors import RigError, TargetTimeout
from hil import can_session
from hil.equivalence import Verdict, compare
from hil.frames import Frame, frame
from hil.messages import (
    OBS_DECISION,
    OBS_SERVOS,
    RIG_CMD,
    RIG_STATUS,
    STIM_APPLY,
    STIM_SONARS,
    Op,
    State,
    pack,
    unpack,
)
from hil.rig import HEARTBEAT_S, RigOnBus
from hil.rig_protocol import Rig
from hil.verify import try_target
from tests.predator_rig import PREDATOR, losing, readings, rig, spoilt, target
from tests.rig_cases import Hearing, Spoiled, channel, nothing, ready
from tests.subjects import subject


def hearing(hear: Callable[[Frame], Iterable[Frame]]) -> Spoiled:
    return Spoiled(ready(Hearing(subject(PREDATOR), hear)))


@pytest.mark.parametrize("lost", [STIM_SONARS[1].id, STIM_APPLY.id])
def test_a_question_that_is_lost_is_asked_again(lost: int) -> None:
    with hearing(losing(lost, 2)) as bus, target(bus) as one:
        trial = compare(subject(PREDATOR), one, readings(2))
    assert (trial.verdict, trial.decisions) == (Verdict.PASS, 2)
    assert one.unheard >= 2


def test_an_answer_that_is_lost_is_asked_for_again() -> None:
    with spoilt(losing(OBS_DECISION.id, 2)) as bus, target(bus) as one:
        trial = compare(subject(PREDATOR), one, readings(2))
    assert (trial.verdict, trial.decisions, one.unheard) == (Verdict.PASS, 2, 2)


def test_what_is_lost_again_and_again_is_blocked() -> None:
    with spoilt(losing(OBS_DECISION.id, -1)) as bus:
        trial = try_target(subject(PREDATOR), lambda: target(bus), readings())
    assert trial.verdict is Verdict.BLOCKED
    assert "question or answer was lost 3 times in a row" in trial.reason


def test_a_hello_that_is_lost_is_said_again(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(can_session, "TRY_S", 0.1)
    with hearing(losing(RIG_CMD.id, 2)) as bus, target(bus) as one:
        assert one.identity().nonce


def test_a_servo_frame_that_is_lost_is_missed() -> None:
    with spoilt(losing(OBS_SERVOS[2].id, 1)) as bus, target(bus) as one:
        one.decide(nothing(PREDATOR))
        with pytest.raises(RigError, match="servo frames were lost on the bus"):
            one.servos(3)
        assert len(one.servos(3)) == 3
        with pytest.raises(RigError, match="SERVOS: the rig cannot present it"):
            one.servos(0)


class Mute(Rig):
    """Falls silent, or goes on with its heart alone, at a frame."""

    beats = False
    at = STIM_APPLY.id

    def receive(self, given: Frame) -> Iterator[Frame]:
        if given.id != self.at:
            yield from super().receive(given)
        elif self.beats:
            yield frame(
                RIG_STATUS, STATE=State.RUNNING, SEQ=int.from_bytes(given.data[6:], "little")
            )


class Dying(RigOnBus):
    """Its heart stops with its first question."""

    dead = False

    def send(self, one: Frame) -> None:
        if not self.dead:
            super().send(one)


@pytest.mark.usefixtures("short_life")
def test_a_rig_that_dies_at_a_question_is_blocked() -> None:
    class Dead(Mute):
        def receive(self, given: Frame) -> Iterator[Frame]:
            bus.dead = bus.dead or given.id == self.at
            yield from super().receive(given)

    bus = Dying(ready(Dead(subject(PREDATOR))), channel())
    with bus:
        trial = try_target(subject(PREDATOR), lambda: target(bus), readings())
    assert trial.verdict is Verdict.BLOCKED
    assert "takes no question, and no status comes either" in trial.reason


@pytest.mark.usefixtures("short_take")
def test_a_rig_that_lives_and_takes_no_question_is_blocked() -> None:
    """Then nothing is known of the program, however long it takes."""
    with RigOnBus(ready(Mute(subject(PREDATOR))), channel()) as bus:
        trial = try_target(subject(PREDATOR), lambda: target(bus), readings())
    assert trial.verdict is Verdict.BLOCKED
    assert "lost 3 times in a row" in trial.reason


def test_a_rig_that_asks_a_program_that_does_not_decide_has_failed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(can_session, "ANSWER_S", 1.0)
    one = ready(Mute(subject(PREDATOR)))
    one.beats = True  # type: ignore[attr-defined]
    with RigOnBus(one, channel()) as bus, target(bus) as asked:
        with pytest.raises(TargetTimeout, match="though the rig lives; the program hangs"):
            asked.decide(nothing(PREDATOR))


def test_a_rig_that_reports_no_decision_has_failed_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    for lost in (-1, 0):  # with its answer lost, too
        one = rig()
        monkeypatch.setattr(one.robot, "look", lambda: None)
        with Spoiled(one, losing(OBS_DECISION.id, lost)) as bus:
            trial = try_target(subject(PREDATOR), lambda: target(bus), readings())
        assert trial.verdict is Verdict.FAIL
        assert "the rig saw no decision on the reading" in trial.reason


def test_a_rig_that_reports_what_nobody_knows_is_blocked() -> None:
    def odd(one: Frame) -> list[Frame]:
        if one.id == RIG_STATUS.id and unpack(RIG_STATUS, one.data)["STATE"] == State.RUNNING:
            return [Frame(one.id, pack(RIG_STATUS, unpack(RIG_STATUS, one.data) | {"ERROR": 99}))]
        return [one]

    with spoilt(odd) as bus:
        trial = try_target(subject(PREDATOR), lambda: target(bus), readings())
    assert trial.verdict is Verdict.BLOCKED
    assert "report 99 of the rig" in trial.reason


def test_a_command_that_is_never_done_is_blocked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(can_session, "ANSWER_S", 0.5)

    def undone(one: Frame) -> list[Frame]:
        return [] if one.id == RIG_CMD.id and one.data[0] == Op.RESET else [one]

    with hearing(undone) as bus, target(bus) as one:
        with pytest.raises(RigError, match="RESET is not done in") as caught:
            one.reset()
    assert not isinstance(caught.value, TargetTimeout)


def test_a_rig_on_a_busy_bus_gives_signs_of_life() -> None:
    """Others talk all the time; no answer of ours is among what is counted."""
    signs = 0
    with RigOnBus(rig(), "busy"):
        with can.Bus(interface="virtual", channel="busy", ignore_config=True) as other:
            until_s = time.monotonic() + 6 * HEARTBEAT_S
            while time.monotonic() < until_s:
                other.send(can.Message(arbitration_id=0x7FF, is_extended_id=False))
                message = other.recv(HEARTBEAT_S / 8)
                signs += message is not None and message.arbitration_id == RIG_STATUS.id
    assert signs >= 3
