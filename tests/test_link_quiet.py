"""What is said to a serial device when it is opened and closed, and in which order."""

import fcntl
import os
import pty
import struct
import sys
import termios
from collections.abc import Iterator
from typing import Any, NamedTuple

import pytest
import serial
from serial import serialposix

from cgagen.errors import RigError
from cgagen.link.port import close_port, open_port
from cgagen.link.quiet import LINES, QuietSerial
from cgagen.serve import serve
from tests.other_program import opened_by_another
from tests.serve_clients import erased


class Line(NamedTuple):
    """The two ends of a pty: it carries bytes and settings, and has no DTR."""

    name: str
    handle: int


@pytest.fixture
def line() -> Iterator[Line]:
    master, slave = pty.openpty()
    yield Line(os.ttyname(slave), slave)
    os.close(slave)
    os.close(master)


def hangs_up(handle: int) -> bool:
    return bool(termios.tcgetattr(handle)[2] & termios.HUPCL)


def set_hang_up(handle: int) -> None:
    settings = termios.tcgetattr(handle)
    settings[2] |= termios.HUPCL
    termios.tcsetattr(handle, termios.TCSANOW, settings)


class Adapter:
    """A device with modem lines, as far as ioctl and tcsetattr tell: it writes down what is said.

    Like Linux it raises DTR and RTS at each opening, whatever has been said before.
    """

    def __init__(self, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
        self.said: list[str] = []
        self.raised = False
        self.exclusive = False
        real_open, real_ioctl, real_set = os.open, fcntl.ioctl, termios.tcsetattr
        self._handles: set[int] = set()

        def opened(path: Any, flags: int, *rest: Any, **words: Any) -> int:
            handle = real_open(path, flags, *rest, **words)
            if str(path) == name:
                self.said.append("open")
                self.raised = True
                self._handles.add(handle)
            return handle

        def ioctl(handle: int, request: int, argument: Any = 0, *rest: Any) -> Any:
            if handle not in self._handles:
                return real_ioctl(handle, request, argument, *rest)
            if request == termios.TIOCMBIC:
                self.said.append("lower")
                if argument == LINES:
                    self.raised = False
            elif request == termios.TIOCMBIS:
                self.said.append("raise")
                self.raised = True
            elif request in (termios.TIOCEXCL, termios.TIOCNXCL):
                self.exclusive = request == termios.TIOCEXCL
            elif request == termios.TIOCMGET:
                return struct.pack("I", 0)
            else:
                return real_ioctl(handle, request, argument, *rest)
            return 0

        def set_attributes(handle: int, when: int, settings: Any) -> None:
            if handle in self._handles:
                self.said.append("settings")
            real_set(handle, when, settings)

        monkeypatch.setattr(os, "open", opened)
        for module in (fcntl, serialposix.fcntl):
            monkeypatch.setattr(module, "ioctl", ioctl)
        monkeypatch.setattr(termios, "tcsetattr", set_attributes)


def test_the_lines_fall_before_anything_else_is_done(
    line: Line, monkeypatch: pytest.MonkeyPatch
) -> None:
    adapter = Adapter(monkeypatch, line.name)
    port = open_port(line.name)
    assert adapter.said[:2] == ["open", "lower"]
    assert adapter.said.count("open") == 1  # each would raise DTR anew
    assert "raise" not in adapter.said
    assert not adapter.raised
    assert adapter.exclusive
    adapter.said.clear()
    close_port(port)
    assert adapter.said[0] == "lower"
    assert (adapter.raised, adapter.exclusive) == (False, False)


def test_pyserial_itself_is_later(line: Line, monkeypatch: pytest.MonkeyPatch) -> None:
    """Why there is a class of ours: with DTR off beforehand it sets the speed first."""
    adapter = Adapter(monkeypatch, line.name)
    port = serial.Serial()
    port.port, port.dtr, port.rts = line.name, False, False
    port.open()
    port.close()
    assert adapter.said[:2] == ["open", "settings"]


def test_closing_changes_no_line(line: Line) -> None:
    """HUPCL, which most systems set, is off during the session and behind it."""
    set_hang_up(line.handle)
    port = open_port(line.name)
    assert not hangs_up(line.handle)
    close_port(port)
    assert not hangs_up(line.handle)
    close_port(port)


TIOCGEXCL = 0x80045440
"""Linux: whether a terminal is claimed; root is let in all the same."""


@pytest.mark.skipif(sys.platform != "linux", reason="no other system can be asked")
def test_a_pty_stays_free_for_the_next_one(line: Line) -> None:
    """It has no lines to keep quiet, and whoever serves it keeps it open."""
    port = open_port(line.name)
    assert isinstance(port, QuietSerial)
    assert fcntl.ioctl(line.handle, TIOCGEXCL, bytes(4)) == bytes(4)
    close_port(port)


def test_a_port_at_work_is_left_as_it_is(line: Line, monkeypatch: pytest.MonkeyPatch) -> None:
    """Another program has locked it: nothing is said to it."""
    monkeypatch.setattr("cgagen.link.port.holders", lambda _: [])
    set_hang_up(line.handle)
    with opened_by_another(line.name, "serial.Serial(sys.argv[1], exclusive=True)"):
        adapter = Adapter(monkeypatch, line.name)
        with pytest.raises(RigError, match="another program has it open"):
            open_port(line.name)
    assert adapter.said == ["open"]
    assert hangs_up(line.handle)


@pytest.mark.parametrize("place", ["rfc2217:0", "tcp:0", "pty"])
def test_ports_without_a_device_open_as_before(place: str) -> None:
    with serve(erased(), place) as server:
        for _ in range(2):
            port = open_port(server.url)
            port.write(b"x")
            close_port(port)
        assert server.failure is None


def test_a_port_that_vanishes_closes() -> None:
    master, slave = pty.openpty()
    port = open_port(os.ttyname(slave))
    os.close(slave)
    os.close(master)
    close_port(port)
    assert not port.is_open
