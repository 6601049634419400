"""A serial port: one session at a time, opened as quietly as the system allows."""

import socket
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress

import serial

from cgagen.bench_protocol import BAUD
from cgagen.errors import RigError
from cgagen.link.lock import PortLock
from cgagen.link.quiet import QuietSerial, claim
from cgagen.link.steered import SIGN, SteeredPort, has_lines, split_control
from cgagen.link.why import LINELESS, LOST, busy, holders, why_closed

READ_S = 0.05
"""How long one read waits. Choice."""

WRITE_S = 2.0
"""How long one write may take. Choice."""

ATN_S = 0.05
"""How long DTR is held for a reset; 2 ms are enough. Choice."""


READER_S = 1.0
"""How long the reader of rfc2217:// may take to see that its port is closed. Choice."""


@contextmanager
def locked_port(
    name: str, baud: int = BAUD, seven_even: bool = False
) -> Iterator[serial.SerialBase]:
    """Lock and open a port, and close it whatever happens; see `open_port`.

    Raises:
        RigError: another session has it, or it cannot be opened.
    """
    lock = PortLock(name)
    lock.take()
    try:
        port = open_port(name, baud, seven_even)
        try:
            yield port
        finally:
            close_port(port)
    finally:
        lock.release()


def open_port(name: str, baud: int = BAUD, seven_even: bool = False) -> serial.SerialBase:
    """Open a port with DTR and RTS off, which leaves a Stamp alone from then on.

    The opening itself raises DTR for a moment on most systems, which may reset a Stamp
    (`cgagen.link.quiet`, DECISIONS.md 43). Ports on a network and ptys have no such moment.

    Args:
        name: device path or URL of pyserial's, with `?control=HOST:PORT` where DTR and BREAK
            are elsewhere (`cgagen.link.steered`).
        baud: bits per second.
        seven_even: seven data bits and even parity instead of eight and none.

    Raises:
        RigError: it cannot be opened, or another program has it open, as far as that can be seen.
    """
    base, control = split_control(name)
    if base.lower().startswith("spy:"):  # its file= replaces what stands there, whosever it is
        raise RigError(
            f"{base}: spy:// writes over any file that it is told; name the port itself, and "
            "write down what it says with `cgagen monitor --log FILE`"
        )
    others = holders(base)
    if others:  # who reads along without a lock would get every other byte
        raise RigError(f"{base}: {busy(others)}")
    try:
        if device := "://" not in base:
            port = QuietSerial()
            port.port, port.exclusive, port.write_timeout = base, True, WRITE_S
        else:
            port = serial.serial_for_url(base, do_not_open=True)
        port.baudrate, port.timeout = baud, READ_S
        if seven_even:
            port.bytesize, port.parity = serial.SEVENBITS, serial.PARITY_EVEN
        with suppress(OSError, ValueError):
            port.dtr, port.rts = False, False
        with warnings.catch_warnings():
            # pyserial 3.5 starts the thread of rfc2217:// in a way that Python 3.10 deprecates.
            warnings.simplefilter("ignore", DeprecationWarning)
            port.open()
        if device:
            claim(port)
        # FTDI adapters otherwise keep what they hear for 16 ms; not every system has that.
        with suppress(OSError, ValueError, AttributeError, NotImplementedError):
            port.set_low_latency_mode(True)
    except LOST as error:
        raise RigError(f"{base}: cannot be opened: {why_closed(base, error)}") from error
    return _steered(port, base, control) if control else port


def _steered(port: serial.SerialBase, base: str, control: str) -> serial.SerialBase:
    try:
        return SteeredPort(port, control)
    except (OSError, ValueError) as error:
        close_port(port)
        raise RigError(
            f"{base}: nobody takes its DTR and BREAK at {control} ({error}); say the address that "
            "its server has printed"
        ) from error


def reset_by_dtr(name: str, port: serial.SerialBase) -> None:
    """Pulse ATN, which resets a Stamp; what was received before is forgotten.

    Raises:
        RigError: this port has no DTR, or is gone.
    """
    if not has_lines(name):
        raise RigError(
            f"{name}: carries no DTR to reset the Stamp with; say {SIGN}HOST:PORT behind it, use "
            "rfc2217://, or reset it by hand"
        )
    try:
        port.reset_input_buffer()
        port.dtr = True
        time.sleep(ATN_S)
        port.dtr = False
    except LOST as error:
        if getattr(error, "errno", None) in LINELESS:
            raise RigError(
                f"{name}: has no DTR to reset the Stamp with; reset it by hand"
            ) from error
        raise RigError(f"{name}: lost ({error}) while resetting; look at the cable") from error


def close_port(port: serial.SerialBase) -> None:
    """Close a port, whatever state it is in; one that is gone closes, too."""
    # pyserial 3.5 closes the socket of rfc2217:// under its own reader, which may then wait for
    # five seconds on whatever file gets its number; and forgets it when the other end has gone.
    forgotten, reader = getattr(port, "_socket", None), getattr(port, "_thread", None)
    if forgotten is not None:
        with suppress(OSError):
            forgotten.shutdown(socket.SHUT_RDWR)
    if reader is not None:
        reader.join(READER_S)
    with suppress(*LOST):
        port.close()
    if forgotten is not None:
        forgotten.close()
