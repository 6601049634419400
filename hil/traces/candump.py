"""Frames with their times: candump's `.log`, written and read here, and what python-can reads.

A line of `.log` is `(seconds.microseconds) channel ID#DATA`, with a T or R behind it for sent and
received, as python-can's CanutilsLogWriter writes it; can-utils demand exactly six decimals.
"""

import io
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

from cgagen.errors import CgagenError
from cgagen.inputs import TRACE, decoded, gunzipped, read_bytes
from hil.frames import Frame
from hil.messages import BY_ID, HOST
from hil.traces.packed import heard, trouble_of_blf
from hil.traces.values import refused

CHANNEL = "can0"
"""What our own files call the bus. Choice."""

SUFFIXES = (".log", ".log.gz", ".asc", ".blf", ".trc")
"""What frames are read from."""

_LINE = re.compile(
    r"\(([0-9]{1,12})\.([0-9]{6})\) (\S{1,64}) ([0-9A-Fa-f]{1,8})#([0-9A-Fa-f#R]*)( [RT])?"
)

_RELATIVE = re.compile(rb"^base\s+\w+\s+timestamps\s+relative", re.IGNORECASE | re.MULTILINE)


class Row(NamedTuple):
    """A frame in a file.

    Attributes:
        time_us: as the file has it.
        frame: identifier and data.
        where: `line 12` or `frame 12`.
    """

    time_us: int
    frame: Frame
    where: str


def log_text(rows: Iterable[tuple[int, Frame]]) -> str:
    r"""Return frames as candump has them.

    Args:
        rows: microseconds, frame.

    >>> log_text([(1_500_000, Frame(0x104, bytes(8)))])
    '(1.500000) can0 104#0000000000000000 T\n'
    """
    return "".join(
        f"({time_us // 1_000_000}.{time_us % 1_000_000:06d}) {CHANNEL} {frame.id:03X}#"
        f"{frame.data.hex().upper()} {'T' if BY_ID[frame.id].sender == HOST else 'R'}\n"
        for time_us, frame in rows
    )


def parse_log(text: str, name: str) -> Iterator[Row]:
    """Read a candump file.

    Raises:
        TraceError: a line that is none of candump's, or no frame of a rig.
    """
    channel = ""
    for number, line in enumerate(text.splitlines(), 1):
        if not line.strip():
            continue
        where = f"line {number}"
        match = _LINE.fullmatch(line)
        if not match:
            raise refused(
                name, where, f"{line[:60]!r} is not like (1.500000) {CHANNEL} 104#0007000000000500"
            )
        channel = channel or match[3]
        if match[3] != channel:
            raise refused(
                name,
                where,
                f"a frame of {match[3]} among those of {channel}",
                "keep one bus in a file",
            )
        if len(match[5]) % 2 and match[5].isalnum() and "R" not in match[5]:
            raise refused(name, where, "ends in the middle of a byte")
        kind, data = _kind_of(len(match[4]) > 3, match[5])
        _check(name, where, kind, int(match[4], 16), len(data))
        time_us = int(match[1]) * 1_000_000 + int(match[2])
        yield Row(time_us, Frame(int(match[4], 16), data), where)


def read_rows(path: Path, name: str) -> Iterator[Row]:
    """Read the frames of a file, by its suffix.

    Raises:
        TraceError: it cannot be read, or holds something else.
    """
    suffix = path.suffix.lower()
    if suffix == ".log":
        yield from parse_log(read_text(path, name), name)
    elif suffix == ".gz":
        yield from parse_log(
            decoded(gunzipped(read_bytes(path, TRACE), name, TRACE), name, TRACE), name
        )
    else:
        yield from _messages(path, name)


def read_text(path: Path, name: str) -> str:
    """Return the text of a file.

    Raises:
        TraceError: it cannot be read, or is no text.
    """
    return decoded(read_bytes(path, TRACE), name, TRACE)


def _kind_of(extended: bool, payload: str) -> tuple[str, bytes]:
    """Return what kind of frame a line of candump holds, "" for a plain one, and its data."""
    if "#" in payload:
        return "a CAN FD frame", b""
    if "R" in payload:
        return "a remote frame", b""
    return ("an extended identifier" if extended else ""), bytes.fromhex(payload)


def _check(name: str, where: str, kind: str, identifier: int, length: int) -> None:
    """Refuse what is no frame of a rig."""
    if kind:
        raise refused(name, where, f"has {kind}, and a rig's frames have none", "record a rig")
    if identifier not in BY_ID:
        raise refused(
            name, where, f"{identifier:03X} is no message of rig.dbc", "record a rig's bus alone"
        )
    message = BY_ID[identifier].name
    if length != 8:
        raise refused(name, where, f"{message} has {length} bytes, not 8")


def _messages(path: Path, name: str) -> Iterator[Row]:
    """Read what python-can reads; whatever it raises is one sentence."""
    from can import ASCReader, BLFReader, TRCReader

    suffix, data = path.suffix.lower(), read_bytes(path, TRACE)
    if suffix == ".asc" and _RELATIVE.search(data):
        raise refused(
            name,
            "",
            "its times count from frame to frame, which python-can takes for absolute ones",
            "export it with absolute times",
        )
    if suffix == ".blf" and (trouble := trouble_of_blf(data)):
        raise refused(name, "", trouble, "record it in parts")
    number, channel = 0, None
    try:
        # Each is given a file of ours, because one that fails on its first bytes leaves it open.
        with (
            heard() as skipped,
            io.BytesIO(data) as file,
            io.TextIOWrapper(file, "latin-1") as text,
        ):
            if suffix == ".blf":
                messages: Iterable[Any] = _whole(BLFReader(file), len(data), name)
            else:
                messages = ASCReader(text) if suffix == ".asc" else TRCReader(text)
            for message in messages:
                number += 1
                row = _row_of(message, name, number)
                if number > 1 and message.channel != channel:
                    raise refused(
                        name,
                        row.where,
                        f"a frame of bus {message.channel} among those of {channel}",
                        "keep one bus in a file",
                    )
                channel = message.channel
                if skipped.words:
                    break
                yield row
            if skipped.words:
                where = f"behind frame {number}"
                raise refused(name, where, f"python-can leaves a line out ({skipped.words})")
    except CgagenError:
        raise
    except Exception as error:  # its readers raise whatever a broken file leads them to
        words = f"{type(error).__name__}: {error}".splitlines()[0][:100]
        raise refused(
            name, f"behind frame {number}", f"python-can cannot read on ({words})"
        ) from error


def _whole(reader: Any, length: int, name: str) -> Any:
    """Return a reader of .blf, unless its file was cut; it would end quietly at any container."""
    if length < reader.file_size:
        raise refused(
            name,
            f"byte {length}",
            f"the file ends here, and its head says that it has {reader.file_size} bytes",
            "fetch it again",
        )
    return reader


def _row_of(message: Any, name: str, number: int) -> Row:
    where = f"frame {number}"
    kinds = {
        "an error in place of data": message.is_error_frame,
        "a remote frame": message.is_remote_frame,
        "a CAN FD frame": message.is_fd,
        "an extended identifier": message.is_extended_id,
    }
    kind = next((words for words, holds in kinds.items() if holds), "")
    data = bytes(message.data)
    _check(name, where, kind, message.arbitration_id, len(data))
    return Row(round(message.timestamp * 1e6), Frame(message.arbitration_id, data), where)
