"""The target behind a rig: who is there, and whether it is who it should be."""

from dataclasses import replace

import pytest

from cgagen.errors import IdentityError, RigError, TargetTimeout
from cgagen.stamp.image import Image
from hil.equivalence import Verdict, compare
from hil.frames import Frame, frame
from hil.messages import OBS_DECISION, RIG_BANNER, RIG_IDENTITY, pack, unpack
from hil.rig import RigOnBus
from hil.rig_protocol import Rig
from hil.target import LATENCY, PINS, STATE
from hil.targets import make_target
from hil.verify import try_target
from tests.predator_rig import PREDATOR, losing, readings, rig, spoilt, spoilt_identity, target
from tests.rig_cases import channel, nothing, opened
from tests.subjects import subject


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
