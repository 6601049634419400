"""A serial device that is opened as quietly as the system lets a program do it.

Most systems raise DTR when a port is opened, before a program can say anything, and a board that
leads DTR to ATN may take that for a reset. No program can prevent it; what is left is to make the
pulse short and to have one of them (DECISIONS.md 43):

* DTR and RTS are lowered as the very first thing, before the port's speed is set;
* one open file for the whole session, because each opening raises DTR anew;
* HUPCL is cleared, so that closing the port changes no line;
* the port is claimed for this program alone (flock, and TIOCEXCL where it has modem lines): another
  one that opens it would raise DTR in the middle of the session.
"""

import fcntl
import struct
import termios
from contextlib import suppress

import serial

LINES = struct.pack("I", termios.TIOCM_DTR | termios.TIOCM_RTS)
"""DTR and RTS, as the system takes them."""


class QuietSerial(serial.Serial):  # type: ignore[misc]  # pyserial has no types
    """pyserial's port, with its lines lowered first; see the module.

    pyserial 3.5 lowers them only behind the change of speed, which takes an adapter on USB
    milliseconds. Should another version not call what is overridden here, its own order remains.
    """

    def _reconfigure_port(self, force_update: bool = False) -> None:
        if force_update and self.fd is not None and _locked(self.fd):  # this is the opening
            _lower(self.fd)
        super()._reconfigure_port(force_update)

    def close(self) -> None:
        """Close the port with DTR and RTS off; harmless when repeated."""
        if self.is_open and self.fd is not None:
            _lower(self.fd)
            with suppress(OSError):  # one that has vanished has nothing to give back
                fcntl.ioctl(self.fd, termios.TIOCNXCL)
        super().close()


def _locked(handle: int) -> bool:
    """Take pyserial's own lock before anything is touched: another program may be at work."""
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False  # pyserial says so right after
    return True


def _lower(handle: int) -> None:
    """Lower DTR and RTS, and leave them alone when the port is closed; a pty has neither."""
    with suppress(OSError):
        fcntl.ioctl(handle, termios.TIOCMBIC, LINES)
    with suppress(OSError, termios.error):
        settings = termios.tcgetattr(handle)
        if settings[2] & termios.HUPCL:
            settings[2] &= ~termios.HUPCL
            termios.tcsetattr(handle, termios.TCSANOW, settings)


def claim(port: serial.Serial) -> None:
    """Let nobody else open a port from now on, if it has lines that opening would raise."""
    with suppress(OSError):
        fcntl.ioctl(port.fileno(), termios.TIOCMGET, struct.pack("I", 0))
        fcntl.ioctl(port.fileno(), termios.TIOCEXCL)
