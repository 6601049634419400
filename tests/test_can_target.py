"""The target behind a rig: what goes wrong on a bus, and how each of it ends."""

import ast
import os
import pty
import random
import tty
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from itertools import count

import can
import pytest

from cgagen.errors import IdentityError, RigError, TargetTimeout
from cgagen.stamp.image import Image
from hil import can_session
from hil.emulated import PinsTarget
from hil.equivalence import Verdict, compare
from hil.frames import Frame, frame
from hil.guard import beside, is_clear
from hil.messages import (
    OBS_DECISION,
    OBS_SERVOS,
    RIG_BANNER,
    RIG_CMD,
    RIG_IDENTITY,
    RIG_STATUS,
    STIM_APPLY,
    STIM_SONARS,
    Fault,
    Op,
    Report,
    State,
    pack,
    unpack,
)
from hil.rig import RigOnBus, SlcanPort
from hil.rig_protocol import Rig
from hil.rig_url import rig_url
from hil.simulated import states_of
from hil.stimuli import (
    Level,
    around,
    every_state,
    light_limits,
    sonar_limits,
    stimuli_of,
    thresholds,
    with_values,
)
from hil.target import LATENCY, PINS, POWER, SERVOS, STATE, Stimulus
from hil.targets import make_target
from hil.verify import try_target
from tests.rig_cases import (
    FIRMWARE,
    Hearing,
    Spoiled,
    Target,
    channel,
    nothing,
    opened,
    ready,
    subject,
)

PREDATOR = "predator"


@pytest.fixture
def short_hello(monkeypatch: pytest.MonkeyPatch) -> None:
    """For greetings that shall fail."""
    monkeypatch.setattr(can_session, "HELLO_S", 0.5)
    monkeypatch.setattr(can_session, "TRY_S", 0.1)


@pytest.fixture
def short_take(monkeypatch: pytest.MonkeyPatch) -> None:
    """For questions that shall not be taken."""
    monkeypatch.setattr(can_session, "TAKE_S", 0.3)


@pytest.fixture
def short_life(monkeypatch: pytest.MonkeyPatch) -> None:
    """For rigs that shall die."""
    monkeypatch.setattr(can_session, "TAKE_S", 0.3)
    monkeypatch.setattr(can_session, "LIFE_S", 0.5)


def readings(number: int = 5) -> list[Stimulus]:
    return list(every_state(subject(PREDATOR).robot).values())[:number]


def rig(role: str = PREDATOR) -> Rig:
    return ready(Rig(subject(role)), role)


def spoilt(spoil: Callable[[Frame], Iterable[Frame | can.Message]]) -> Spoiled:
    return Spoiled(rig(), spoil)


def hearing(hear: Callable[[Frame], Iterable[Frame]]) -> Spoiled:
    return Spoiled(ready(Hearing(subject(PREDATOR), hear)))


def target(service: RigOnBus | SlcanPort, role: str = PREDATOR) -> Target:
    return Target(service.url, subject(role))


# -- As it should be -----------------------------------------------------------------------------


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


def test_numbers_go_on_behind_the_last_of_16_bits() -> None:
    with spoilt(lambda one: [one]) as bus, target(bus) as one:
        one._session._numbers = count(65_533)
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


def test_can_is_imported_when_a_bus_is_opened() -> None:
    """Whoever never names a rig, never loads python-can."""
    for path in (FIRMWARE.parent / "hil").glob("*.py"):
        top = ast.parse(path.read_text("utf-8")).body
        names = {one.name for node in top if isinstance(node, ast.Import) for one in node.names}
        names |= {str(node.module) for node in top if isinstance(node, ast.ImportFrom)}
        assert not {"can", "cantools"} & names, path


# -- Names ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("url", "why"),
    [
        ("can:", "no name of a rig; say can:INTERFACE:CHANNEL"),
        ("can:virtual", "no name of a rig"),
        ("can:virtual:", "no name of a rig"),
        ("can::x", "no name of a rig"),
        ("can:virtual:x?", "nothing behind the question mark"),
        ("can:virtual:x?guard", "guard behind the question mark"),
        ("can:virtual:x?guard=", "it may be guard=0 to guard=1000"),
        ("can:virtual:x?guard=-1", "it may be guard=0"),
        ("can:virtual:x?guard=1001", "it may be guard=0"),
        ("can:virtual:x?guard=²", "it may be guard=0"),
        ("can:virtual:x?speed=2", "speed=2 behind the question mark"),
    ],
)
def test_a_malformed_name_is_a_sentence(url: str, why: str) -> None:
    with pytest.raises(RigError) as caught:
        make_target(url, subject(PREDATOR))
    assert str(caught.value).startswith(f"{url}: ")
    assert why in str(caught.value)
    assert caught.value.exit_code == 7


@pytest.mark.parametrize(
    "url", ["can:nosuch:x", "can:slcan:/dev/no-such-port", "can:slcan:x://y", "can:socketcan:none0"]
)
def test_an_adapter_that_is_not_there_is_a_sentence(url: str) -> None:
    trial = try_target(subject(PREDATOR), lambda: make_target(url, subject(PREDATOR)), readings())
    assert trial.verdict is Verdict.BLOCKED
    assert trial.reason.startswith(f"{url}: cannot be opened (")
    assert "look at the adapter" in trial.reason
    assert "\n" not in trial.reason


def test_a_configuration_of_others_does_not_leak_in(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CAN_INTERFACE", "nosuch")
    monkeypatch.setenv("CAN_CHANNEL", "elsewhere")
    with spoilt(lambda one: [one]) as bus, target(bus) as one:
        assert one.decide(nothing(PREDATOR)).command in range(8)


def test_an_adapter_on_a_port_shares_the_port_s_lock() -> None:
    """A Stamp's cable and an adapter cannot be one device; virtual buses are a process's own."""
    assert rig_url("can:slcan:/dev/ttyACM0@115200?guard=1").lock_name == "/dev/ttyACM0"
    assert rig_url("can:socketcan:can0").lock_name == "can://socketcan/can0"
    assert rig_url("can:virtual:x").lock_name == f"can://virtual/{os.getpid()}/x"


def test_a_channel_has_one_session_at_a_time() -> None:
    with spoilt(lambda one: [one]) as bus, target(bus) as first:
        with pytest.raises(RigError, match="another session of cgagen has this port"):
            target(bus).open()
        first.close()
        first.close()
        with target(bus) as second:
            second.decide(nothing(PREDATOR))
        with pytest.raises(RigError, match="is not open; open it first"):
            second.decide(nothing(PREDATOR))
    with pytest.raises(RigError, match="is not open"):
        target(bus).identity()


# -- What else comes on a bus ---------------------------------------------------------------------


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
        line = one._session.line
        assert (line.errors, line.foreign, line.malformed) == (3, 12, 3)
        assert one.foreign == "3 error frames, 12 of other devices, 3 of a wrong length"
    assert (trial.verdict, trial.stale, one.unheard) == (Verdict.PASS, 0, 0)


def test_a_controller_off_the_bus_is_blocked() -> None:
    off = can.Message(arbitration_id=0x040, is_error_frame=True, is_extended_id=False)
    with spoilt(lambda one: [off] if one.id == OBS_DECISION.id else [one]) as bus:
        trial = try_target(subject(PREDATOR), lambda: target(bus), readings())
    assert trial.verdict is Verdict.BLOCKED
    assert "the adapter is off the bus after too many errors; look at the wiring" in trial.reason


# -- What is lost ---------------------------------------------------------------------------------


def losing(wanted: int, times: int) -> Callable[[Frame], list[Frame]]:
    """Loses frames of an identifier so many times."""
    left = [times]

    def lose(one: Frame) -> list[Frame]:
        if one.id == wanted and left[0]:
            left[0] -= 1
            return []
        return [one]

    return lose


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


# -- Who is there ---------------------------------------------------------------------------------


@pytest.mark.usefixtures("short_hello")
def test_nobody_on_the_bus_is_blocked() -> None:
    url = f"can:virtual:{channel()}"
    with pytest.raises(RigError, match="does not say hello, and no status comes either") as caught:
        make_target(url, subject(PREDATOR)).open()
    assert "0 error frames, 0 of other devices" in str(caught.value)
    assert not isinstance(caught.value, TargetTimeout)


@pytest.mark.usefixtures("short_hello")
def test_another_nonce_is_not_ours() -> None:
    def other(one: Frame) -> list[Frame]:
        if one.id != RIG_IDENTITY.id:
            return [one]
        values = unpack(RIG_IDENTITY, one.data)
        return [Frame(one.id, pack(RIG_IDENTITY, {**values, "NONCE": values["NONCE"] ^ 1}))]

    with (
        spoilt(other) as bus,
        pytest.raises(RigError, match="greets with another nonce than ours"),
    ):
        target(bus).open()


@pytest.mark.usefixtures("short_hello")
def test_a_rig_that_lives_and_does_not_greet_is_no_hanging_program() -> None:
    with spoilt(losing(RIG_IDENTITY.id, -1)) as bus:
        trial = try_target(subject(PREDATOR), lambda: target(bus), readings())
    assert trial.verdict is Verdict.BLOCKED
    assert "does not say hello, though the rig lives; restart it" in trial.reason


def spoilt_identity(**changes: int) -> Spoiled:
    def change(one: Frame) -> list[Frame]:
        if one.id != RIG_IDENTITY.id:
            return [one]
        return [Frame(one.id, pack(RIG_IDENTITY, unpack(RIG_IDENTITY, one.data) | changes))]

    return spoilt(change)


def test_a_rig_of_other_messages_is_refused() -> None:
    with (
        spoilt_identity(PROTOCOL=2) as bus,
        pytest.raises(RigError, match="speaks version 2 of the messages, we speak version 1"),
    ):
        target(bus).open()


def test_the_rig_of_another_robot_is_refused() -> None:
    with (
        RigOnBus(rig("prey"), channel()) as bus,
        pytest.raises(IdentityError, match="6 sonars and 0 light sensors, servobot-predator has 3"),
    ):
        target(bus).open()


def test_another_program_in_the_chip_is_refused() -> None:
    """By its banner; that is all that a rig can hear of it."""
    one = subject(PREDATOR)
    eeprom = one.images["main"].eeprom.replace(one.genome_digest.encode(), b"0badcafe")
    assert eeprom != one.images["main"].eeprom
    other = replace(one, images={**one.images, "main": Image(one.images["main"].model, eeprom)})
    with (
        RigOnBus(opened(Rig(other)), channel()) as bus,
        pytest.raises(IdentityError, match="the chip says genome 0badcafe, source"),
    ):
        target(bus).open()


@pytest.mark.parametrize("deaf", [True, False])
def test_a_rig_that_heard_no_banner_does_not_know_the_program(deaf: bool) -> None:
    """It has no ear, or was switched on after the robot. Nothing is claimed then."""

    def hush(one: Frame) -> list[Frame]:
        if one.id == RIG_IDENTITY.id and deaf:
            return [Frame(one.id, pack(one_of := RIG_IDENTITY, unpack(one_of, one.data) | NO_EAR))]
        if one.id == RIG_BANNER.id:
            return [] if deaf else [frame(RIG_BANNER)]
        if one.id == OBS_DECISION.id and deaf:
            values = unpack(OBS_DECISION, one.data) | {"STATE_VALID": 0, "STATE": 0}
            return [Frame(one.id, pack(OBS_DECISION, values))]
        return [one]

    with spoilt(hush) as bus, target(bus) as one:
        assert one.identity().genome == ""
        assert "heard no banner: the program is not known" in one.note
        assert (STATE in one.caps) is not deaf
        trial = compare(subject(PREDATOR), one, readings(3))
        assert one.decide(nothing(PREDATOR)).state == (None if deaf else 0)
    assert trial.verdict is Verdict.PASS


NO_EAR = {"HEARS": 0}


def test_what_a_rig_cannot_do_is_a_sentence() -> None:
    with spoilt_identity(SWITCHES_POWER=0, SEES_SERVOS=0) as bus, target(bus) as one:
        assert one.caps == {STATE, PINS, LATENCY}
        with pytest.raises(RigError, match="cannot switch the supply"):
            one.power(False)
        with pytest.raises(RigError, match="does not see the servos"):
            one.servos(1)


# -- Who falls silent -----------------------------------------------------------------------------


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


# -- An adapter that goes -------------------------------------------------------------------------


# pyserial's socket port does not close what it cannot shut down because its other end has gone
@pytest.mark.filterwarnings("ignore:.*unclosed <socket:pytest.PytestUnraisableExceptionWarning")
@pytest.mark.filterwarnings("ignore:unclosed <socket:ResourceWarning")
@pytest.mark.parametrize("kind", ["pty", "tcp"])
@pytest.mark.usefixtures("short_life")
def test_an_adapter_that_is_pulled_out_in_a_question_is_blocked(kind: str) -> None:
    class Unplugged(SlcanPort):
        def write(self, handle: int, data: bytes) -> None:
            if b"t2008" in data:
                self._ended.set()
                raise OSError("pulled out")
            super().write(handle, data)

        def _run(self) -> None:
            super()._run()
            self._let_go()

    with Unplugged(rig(), kind) as port, target(port) as one:
        trial = compare(subject(PREDATOR), one, readings())
    assert trial.verdict is Verdict.BLOCKED
    assert "lost while" in trial.reason or "no status comes" in trial.reason


def test_a_closed_bus_is_a_sentence() -> None:
    with spoilt(lambda one: [one]) as bus, target(bus) as one:
        line = one._session.line
        assert line._bus is not None
        line._bus.shutdown()
        with pytest.raises(RigError, match="lost while sending"):
            one.decide(nothing(PREDATOR))


@pytest.mark.usefixtures("short_hello")
def test_an_adapter_where_nobody_answers_and_one_that_babbles() -> None:
    master, slave = pty.openpty()
    tty.setraw(slave)
    try:
        one = make_target(f"can:slcan:{os.ttyname(slave)}", subject(PREDATOR))
        with pytest.raises(RigError, match="does not say hello"):
            one.open()
        os.write(master, bytes(range(256)) + b"t2\rt9998\rtxyz8zz\r" * 20)
        with pytest.raises(RigError, match=r"lost while listening|does not say hello"):
            one.open()
    finally:
        os.close(master)
        os.close(slave)


# -- The guard band -------------------------------------------------------------------------------


def test_a_rig_that_is_exact_is_given_everything_that_goes_through_pins() -> None:
    robot = subject(PREDATOR).robot
    every = stimuli_of(robot, Level.BOUNDARY)
    left = [one for one in every if not is_clear(robot, one, 0)]
    assert {max((*one.sonars, *one.lights)) for one in left} == {65_535}


@pytest.mark.parametrize("role", ["predator", "prey"])
def test_what_is_admitted_decides_alike_however_the_timers_err(role: str) -> None:
    robot, guard, chance = subject(role).robot, 3, random.Random(4)
    limits = [*sonar_limits(robot), *[light_limits(robot)] * len(nothing(role).lights)]
    sonars = len(robot.sonars)

    def some(rows: tuple[int, ...]) -> int:
        return chance.choice(
            [0, chance.randrange(30_000), *(n + chance.randint(-9, 9) for n in rows)]
        )

    def off(one: int) -> int:
        return max(one + chance.choice((-guard, guard, chance.randint(-guard, guard))), 1)

    clear, presented = [], []
    for _ in range(4_000):
        counts = [max(some(rows), 0) for rows in limits]
        touched = (chance.random() < 0.3, chance.random() < 0.3)
        one = Stimulus(tuple(counts[:sonars]), touched, tuple(counts[sonars:]))
        if is_clear(robot, one, guard):
            wrong = [off(count) if count else 0 for count in counts]
            clear.append(one)
            presented.append(Stimulus(tuple(wrong[:sonars]), touched, tuple(wrong[sonars:])))
    assert 400 < len(clear) < 4_000
    assert states_of(robot, presented).tolist() == states_of(robot, clear).tolist()


def test_the_band_ends_where_it_says() -> None:
    robot = subject(PREDATOR).robot
    limit = sonar_limits(robot)[0][0]

    def clear(count: int) -> bool:
        return is_clear(robot, Stimulus((count, 0, 0), lights=(0, 0)), 2)

    inside = [count for count in range(limit - 9, limit + 9) if not clear(count)]
    assert inside == [limit - 2, limit - 1, limit, limit + 1]


@pytest.mark.parametrize("role", ["predator", "prey"])
def test_the_nearest_on_both_sides_of_a_threshold_are_tried_instead(role: str) -> None:
    robot = subject(role).robot
    readings = beside(robot, 2)
    assert all(is_clear(robot, one, 2) and not is_clear(robot, one, 3) for one in readings)
    limits = [*sonar_limits(robot), *[light_limits(robot)] * len(nothing(role).lights)]
    states = dict(zip(readings, states_of(robot, readings).tolist(), strict=True))
    for index, row in enumerate(limits):
        for limit in row:
            pairs = [
                (state, states.get(with_values(one, {index: limit + 2})))
                for one, state in states.items()
                if (*one.sonars, *one.lights)[index] == limit - 3
            ]
            assert any(above not in (None, below) for below, above in pairs), (index, limit)


def test_what_is_too_near_is_left_out_and_counted() -> None:
    one = subject(PREDATOR)
    near = [stimulus for stimulus in thresholds(one.robot) if not is_clear(one.robot, stimulus, 2)]
    with spoilt(lambda one: [one]) as bus:
        guarded = Target(f"{bus.url}?guard=2", one)
        with guarded:
            trial = compare(one, guarded, [nothing(PREDATOR), *near])
        only = try_target(one, lambda: Target(f"{bus.url}?guard=2", one), near)
        wide = try_target(one, lambda: Target(f"{bus.url}?guard=2", one), near, widened=True)
        exact = try_target(one, lambda: Target(bus.url, one), near[:1], widened=True)
    assert (trial.verdict, trial.decisions, trial.left_out) == (Verdict.PASS, 1, len(near))
    assert len(near) >= len(around(sonar_limits(one.robot)[0]))
    assert only.verdict is Verdict.UNPROVEN
    assert (wide.verdict, wide.decisions) == (Verdict.PASS, len(beside(one.robot, 2)))
    assert exact.decisions == 1


@pytest.mark.parametrize(("jitter", "guard"), [(0, 0), (1, 1), (15, 1), (16, 2), (255, 17)])
def test_a_rig_that_says_how_far_it_is_off_is_believed(jitter: int, guard: int) -> None:
    with spoilt_identity(JITTER=jitter) as bus:
        with target(bus) as one:
            assert one.guard_counts == guard
        with Target(f"{bus.url}?guard=1", subject(PREDATOR)) as told:
            assert told.guard_counts == 1


def test_reports_have_words() -> None:
    quiet = {Report.NONE, Report.INCOMPLETE, Report.OLD_SEQ, Report.NO_DECISION}
    quiet |= {Report.FAULT_FIRED, Report.FAULT_SILENT}
    assert set(can_session.REFUSALS) == set(Report) - quiet
