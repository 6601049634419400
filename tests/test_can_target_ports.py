"""The target behind a rig: names of buses, who has one, and adapters that go."""

import ast
import os
import pty
import tty

import can
import pytest

from cgagen.errors import RigError
from hil.equivalence import Verdict, compare
from hil.rig import SlcanPort
from hil.rig_url import rig_url
from hil.targets import make_target
from hil.verify import try_target
from tests.predator_rig import PREDATOR, readings, rig, spoilt, target
from tests.rig_cases import nothing
from tests.subjects import FIRMWARE, subject


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
                self.stop()
                raise OSError("pulled out")
            super().write(handle, data)

    with Unplugged(rig(), kind) as port, target(port) as one:
        trial = compare(subject(PREDATOR), one, readings())
    assert trial.verdict is Verdict.BLOCKED
    assert "lost while" in trial.reason or "no status comes" in trial.reason


def test_a_closed_bus_is_a_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[can.BusABC] = []
    bus_of = can.Bus
    with spoilt(lambda one: [one]) as bus:
        monkeypatch.setattr(can, "Bus", lambda **how: opened.append(bus_of(**how)) or opened[-1])
        one = target(bus)
        one.open()
        opened[0].shutdown()
        with pytest.raises(RigError, match="lost while sending"):
            one.decide(nothing(PREDATOR))
        one.close()


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
