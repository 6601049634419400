"""A CAN adapter on a serial line, as LAWICEL's CANUSB speaks it, with an emulated rig as its bus.

Lines end with CR; CR is yes and BELL is no. What comes from the bus comes as lines between the
answers. Ref: S21.
"""

import re
from collections.abc import Iterator

from hil.frames import Frame
from hil.rig_protocol import Rig

OK, NO = b"\r", b"\a"

LONGEST_LINE = 32
"""Characters of the longest line that makes sense: an extended frame of 8 bytes is 26."""

VERSION, SERIAL_NUMBER, NO_FLAGS = b"V1013\r", b"NCGAG\r", b"F00\r"

_FRAME = re.compile(r"(?:t([0-7][0-9A-F]{2})|T([01][0-9A-F]{7}))([0-8])((?:[0-9A-F]{2})*)", re.I)
_REMOTE = re.compile(r"(?:r[0-7][0-9A-F]{2}|R[01][0-9A-F]{7})[0-8]", re.I)
_BITRATE = re.compile(r"S[0-8]|s[0-9A-F]{4}", re.I)
_FILTER = re.compile(r"[Mm][0-9A-F]{8}", re.I)


class SlcanAdapter:
    """Turns what a host writes into answers and into what a rig has to say.

    Args:
        rig: open; the only other one on this bus.

    Attributes:
        is_open: whether frames come through.
    """

    def __init__(self, rig: Rig) -> None:
        self.rig = rig
        self.is_open = False
        self._listens_only = False
        self._stamps = False
        self._line = bytearray()

    def feed(self, data: bytes) -> Iterator[bytes]:
        """Take bytes from the host; return what it gets, as it comes about."""
        for byte in data:
            if byte != OK[0]:
                self._line.append(byte)
                continue
            line, self._line = bytes(self._line), bytearray()
            if len(line) > LONGEST_LINE:
                yield NO
            else:
                yield from self._obey(line.decode("latin-1"))
        del self._line[LONGEST_LINE + 1 :]  # without end: keep what shows that it was too long

    def heartbeat(self) -> bytes:
        """Return the rig's sign of life; nothing while the channel is closed."""
        return self.line_of(self.rig.heartbeat()) if self.is_open else b""

    def line_of(self, one: Frame) -> bytes:
        """Return a frame as the host gets it."""
        stamp = f"{self.rig.time_ms % 60_000:04X}" if self._stamps else ""
        return f"t{one.id:03X}{len(one.data)}{one.data.hex().upper()}{stamp}\r".encode()

    def _obey(self, line: str) -> Iterator[bytes]:
        if line[:1] in ("t", "T", "r", "R") and line:
            yield from self._send(line)
            return
        if line == "":
            yield OK
        elif line in ("O", "L"):
            yield NO if self.is_open else OK
            self.is_open, self._listens_only = True, line == "L"
        elif line == "C":
            yield OK if self.is_open else NO
            self.is_open = False
        elif line in ("Z0", "Z1") and not self.is_open:
            self._stamps = line == "Z1"
            yield OK
        elif _BITRATE.fullmatch(line) or _FILTER.fullmatch(line):
            yield NO if self.is_open else OK
        else:
            told = {"V": VERSION, "N": SERIAL_NUMBER, "F": NO_FLAGS if self.is_open else NO}
            yield told.get(line, NO)

    def _send(self, line: str) -> Iterator[bytes]:
        found = _FRAME.fullmatch(line)
        if not self.is_open or self._listens_only or not (found or _REMOTE.fullmatch(line)):
            yield NO
            return
        if found is None:
            yield OK  # a remote frame; the rig has no answer to any
            return
        standard, _, length, digits = found.groups()
        data = bytes.fromhex(digits)
        if len(data) != int(length):
            yield NO
            return
        yield OK
        if standard is not None:
            for answer in self.rig.receive(Frame(int(standard, 16), data)):
                yield self.line_of(answer)
