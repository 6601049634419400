"""Ports by name, why one does not open, and who has it."""

import errno
import os
import pty
import termios
import time
from pathlib import Path

import pytest
import serial
from serial.tools import list_ports
from serial.tools.list_ports_common import ListPortInfo

from cgagen.errors import RigError
from cgagen.link import why
from cgagen.link.lock import PortLock
from cgagen.link.port import open_port, reset_by_dtr
from cgagen.link.ports import PortInfo, all_ports, choose_port
from cgagen.link.prompted import PromptedPort
from tests.other_program import opened_by_another

ONE = PortInfo("/dev/ttyUSB0", 0x0403, 0x6001, "A1", "FT232R")
TWO = PortInfo("/dev/ttyUSB1", 0x0403, 0x6001, "B2")
BOARD = PortInfo("/dev/ttyS0")


def usb(device: str, number: str | None) -> ListPortInfo:
    port = ListPortInfo(device)
    if number:
        port.vid, port.pid, port.serial_number, port.product = 0x0403, 0x6001, number, "FT232R"
    return port


@pytest.mark.parametrize("scheme", ["spy", "SPY"])
def test_no_port_writes_over_a_file(tmp_path: Path, scheme: str) -> None:
    mine = tmp_path / "mine.txt"
    mine.write_text("mine")
    with pytest.raises(RigError, match="writes over any file that it is told"):
        open_port(f"{scheme}://loop://?file={mine}")
    assert mine.read_text() == "mine"


def test_ports_on_usb_come_first(monkeypatch: pytest.MonkeyPatch) -> None:
    found = [usb("/dev/ttyS0", None), usb("/dev/ttyUSB1", "B2"), usb("/dev/ttyUSB0", "A1")]
    monkeypatch.setattr(list_ports, "comports", lambda: found)
    assert [port.device for port in all_ports()] == ["/dev/ttyUSB0", "/dev/ttyUSB1", "/dev/ttyS0"]
    assert all_ports()[2] == BOARD
    assert all_ports()[0] == ONE


def test_auto_is_the_only_one_on_usb() -> None:
    assert choose_port("auto", ports=[BOARD, ONE]) == "/dev/ttyUSB0"
    for answers in (None, lambda name: True):
        with pytest.raises(RigError, match=r"no USB adapter .*ports are /dev/ttyS0; name one with"):
            choose_port("auto", answers, [BOARD])


def test_auto_is_the_only_one_that_answers() -> None:
    assert choose_port("auto", lambda name: name == TWO.device, [ONE, TWO]) == TWO.device
    with pytest.raises(RigError, match="auto: more than one USB adapter answers"):
        choose_port("auto", lambda name: True, [ONE, TWO])
    with pytest.raises(RigError, match=r"auto: no USB adapter answers; .* are /dev/ttyUSB0 \(0403"):
        choose_port("auto", lambda name: False, [ONE, TWO])


def test_what_cannot_be_chosen_is_a_sentence() -> None:
    with pytest.raises(RigError, match=r"one USB adapter could be meant \(/dev/ttyUSB0, /dev"):
        choose_port("auto", ports=[ONE, TWO])
    with pytest.raises(RigError, match="no serial port: plug the adapter in"):
        choose_port("auto", ports=[])
    with pytest.raises(RigError, match="id:C3: no adapter has this serial number; the ports"):
        choose_port("id:C3", ports=[ONE, TWO])
    with pytest.raises(RigError, match="id:A1: 2 adapters have"):
        choose_port("id:A1", ports=[ONE, ONE])
    with pytest.raises(RigError, match="id:: no adapter has"):
        choose_port("id:", ports=[BOARD])


@pytest.mark.parametrize(
    ("number", "words"),
    [
        (errno.ENOENT, "it is not there"),
        (errno.EACCES, "you may not; ask"),
        (errno.EBUSY, "another program has it open"),
        (errno.EAGAIN, "another program has it open"),
        (errno.ENOTTY, "it is no serial port"),
        (errno.EIO, "hm; look at the cable"),
    ],
)
def test_every_reason_has_its_words(number: int, words: str) -> None:
    assert why.why_closed("/dev/nothing", OSError(number, "hm")).startswith(words)


def test_the_group_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(why, "group_of", lambda name: "dialout")
    text = why.why_closed("/dev/ttyUSB0", OSError(errno.EACCES, ""))
    assert "sudo usermod -aG dialout $USER" in text


def test_a_port_that_is_none(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.write_text("no port", "utf-8")
    with pytest.raises(RigError, match="file: cannot be opened: it is no serial port"):
        open_port(str(file))
    with pytest.raises(RigError, match="it is not there; look at the cable"):
        open_port(str(tmp_path / "none"))
    with pytest.raises(
        RigError, match=r"rfc2217://127.0.0.1:1: cannot be opened: .*is the other side"
    ):
        open_port("rfc2217://127.0.0.1:1")
    with pytest.raises(RigError, match="bench: cannot be opened: it lacks the number of the sock"):
        open_port("rfc2217://bench")


def test_two_sessions_on_one_port(tmp_path: Path) -> None:
    """Its second name is no way round the lock."""
    device, link = tmp_path / "ttyUSB0", tmp_path / "robot"
    device.touch()
    link.symlink_to(device)
    first, second = PortLock(str(device)), PortLock(str(link))
    first.take()
    with pytest.raises(RigError, match="another session of cgagen has this port"):
        second.take()
    first.release()
    second.take()
    second.release()


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (OSError(errno.ENOTTY, "no such line"), "has no DTR to reset the Stamp with"),
        (OSError(errno.EOPNOTSUPP, "no such line"), "has no DTR to reset the Stamp with"),
        (OSError(errno.EIO, "gone"), "lost .* while resetting; look at the cable"),
        (termios.error(errno.EIO, "gone"), "lost .* while resetting; look at the cable"),
        (serial.SerialException("reader thread died"), "lost .* while resetting"),
    ],
)
def test_a_reset_tells_a_missing_line_from_a_lost_port(error: Exception, words: str) -> None:
    class Failing(serial.SerialBase):
        def reset_input_buffer(self) -> None:
            raise error

    with pytest.raises(RigError, match=words):
        reset_by_dtr("/dev/x", Failing())


@pytest.mark.parametrize("fails", [None, ValueError("no such flag"), NotImplementedError()])
def test_what_an_adapter_hears_is_asked_for_at_once(
    fails: Exception | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where the system has a way to ask."""
    asked: list[bool] = []

    def quick(_: object, wanted: bool) -> None:
        asked.append(wanted)
        if fails:
            raise fails

    monkeypatch.setattr(serial.Serial, "set_low_latency_mode", quick)
    master, slave = pty.openpty()
    open_port(os.ttyname(slave)).close()
    os.close(master)
    os.close(slave)
    assert asked == [True]


def test_a_plain_socket_is_not_reset_in_silence() -> None:
    with pytest.raises(RigError, match=r"carries no DTR .*\?control=HOST:PORT"):
        reset_by_dtr("socket://127.0.0.1:1", serial.SerialBase())


@pytest.mark.parametrize(
    ("way", "seen"),
    [("serial.Serial(sys.argv[1], exclusive=True)", False), ("open(sys.argv[1])", True)],
)
def test_a_port_that_another_program_has_open(
    way: str, seen: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Another user's program is not seen before; it has locked the port, or it cannot be known."""
    if not seen:
        monkeypatch.setattr("cgagen.link.port.holders", lambda _: [])
    master, slave = pty.openpty()
    name = os.ttyname(slave)
    with opened_by_another(name, way) as number:
        with pytest.raises(RigError, match=rf"another program has it open .*process {number}"):
            open_port(name)
    os.close(master)
    os.close(slave)


def test_pyserial_says_why_in_numbers() -> None:
    """The words above hang on it."""
    with pytest.raises(serial.SerialException) as met:
        serial.Serial("/dev/there-is-no-such-port")
    assert met.value.errno == errno.ENOENT


def test_a_prompt_with_something_behind_it_is_old(tmp_path: Path) -> None:
    """A host that was away finds several; behind the first of them it would stay behind."""
    master, host = pty.openpty()
    with PromptedPort(os.ttyname(host)) as port:
        os.write(master, b">>\r:1 F2\r>>")
        soon = time.monotonic() + 60
        assert port.await_prompt(soon)
        assert port.opened().in_waiting == 0
        os.write(master, b">x")
        assert not port.await_prompt(time.monotonic() + 0.1)
    os.close(host)
    os.close(master)
