"""What python-can does not look at by itself: how much a .blf unpacks to, and what it skips."""

import logging
import struct
import zlib
from collections.abc import Iterator
from contextlib import contextmanager

from cgagen.inputs import TRACE
from cgagen.shown import short

_HEAD_BYTES = struct.Struct("<4sL")
"""Of a .blf: its mark, and how long its head is."""

_OBJECT = struct.Struct("<4sHHLL")
"""Before each object: its mark, the length of this head, a version, the object's length, kind."""

_CONTAINER = struct.Struct("<H6xL4x")
"""Of a container: how it is packed, and what it says that it unpacks to."""

_CONTAINER_KIND, _ZLIB = 10, 2


def trouble_of_blf(data: bytes) -> str:
    """Return why a .blf is not to be unpacked; "" where that does no harm, or where it is none.

    >>> trouble_of_blf(b"LOGG")
    ''
    """
    if len(data) < _HEAD_BYTES.size:
        return ""
    at, unpacked = _HEAD_BYTES.unpack_from(data)[1], 0
    while 0 <= at <= len(data) - _OBJECT.size:
        mark, _, _, length, kind = _OBJECT.unpack_from(data, at)
        if mark != b"LOBJ" or length < _OBJECT.size:
            return ""  # python-can says what is wrong
        start = at + _OBJECT.size
        if kind == _CONTAINER_KIND and start + _CONTAINER.size <= len(data):
            method, _size = _CONTAINER.unpack_from(data, start)
            packed = data[start + _CONTAINER.size : at + length]
            unpacked += _length(packed, TRACE.most + 1) if method == _ZLIB else len(packed)
            if unpacked > TRACE.most:
                return f"unpacks to more than {TRACE.most:,} bytes"
        at += length + length % 4
    return ""


def _length(packed: bytes, most: int) -> int:
    try:
        return len(zlib.decompressobj().decompress(packed, most))
    except zlib.error:
        return 0


class Skipped(logging.Handler):
    """Keeps what python-can says of lines that it leaves out, and off the terminal.

    Attributes:
        words: of the first such line; "" for none.
    """

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.words = ""

    def emit(self, record: logging.LogRecord) -> None:
        """Take a message of the library's."""
        text = record.getMessage()
        if "Failed to parse" in text and not self.words:
            self.words = short(text, 120)


@contextmanager
def heard() -> Iterator[Skipped]:
    """Hear what python-can says while a file is read."""
    logger, handler = logging.getLogger("can"), Skipped()
    was = logger.propagate
    logger.addHandler(handler)
    logger.propagate = False
    try:
        yield handler
    finally:
        logger.removeHandler(handler)
        logger.propagate = was
