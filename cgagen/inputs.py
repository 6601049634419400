"""Files of the user's: every one is read here, and only if it is a file of a sensible size.

A verb that is given a name opens whatever bears it, and that may be a device that never ends, a
pipe that nobody writes to, a port whose opening resets a Stamp, or an archive that unpacks to more
than the memory. So one function looks before it opens, reads no more than its kind of file may
have, and says in one sentence what is wrong. Pipes are refused, `<(...)` of a shell among them:
what was tried has to stand somewhere, to be tried again. `-` is read where a verb offers it.
"""

import errno
import os
import re
import stat
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from cgagen.errors import (
    BenchError,
    CgagenError,
    FolderError,
    GenomeError,
    ImageError,
    MeasurementError,
    RobotError,
    RunError,
    SourceError,
    TemplateError,
    TraceError,
)
from cgagen.shown import short

KIB, MIB = 1 << 10, 1 << 20


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of file.

    Attributes:
        what: it is, for sentences: "a genome".
        most: bytes that one may have, unpacked. Choice, far above any honest one.
        refusal: what is raised.
        mend: what to do, as the end of a sentence.
    """

    what: str
    most: int
    refusal: type[CgagenError]
    mend: str


GENOME = Kind("a genome", 64 * KIB, GenomeError, "give the best.genome of a run")
ROBOT = Kind("a robot", 256 * KIB, RobotError, "give a robot's TOML file")
ARENA = Kind("an arena", 256 * KIB, RobotError, "give an arena's TOML file")
RUN_FILE = Kind("a file of a run", MIB, RunError, "put it back, or start a new run")
RUN_TABLE = Kind("a table of a run", 64 * MIB, RunError, "put it back, or start a new run")
CHECKPOINT = Kind("a checkpoint", 64 * MIB, RunError, "put back a whole copy, and resume again")
BUILD_RECORD = Kind("a build.json", MIB, FolderError, "give a folder that `cgagen build` wrote")
BUILD_FILE = Kind("a file of a build", MIB, FolderError, "build the folder again")
IMAGE = Kind("an image of 2,048 bytes", 64 * KIB, ImageError, "name an image")
SOURCE = Kind("a PBASIC source", MIB, SourceError, "name a PBASIC source")
BENCH = Kind("a bench", MIB, BenchError, "name a bench file")
TRACE = Kind("a trace", 8 * MIB, TraceError, "name a trace")
SIDECAR = Kind("what lies beside a trace", 256 * KIB, TraceError, "record the trace again")
MEASUREMENTS = Kind("a table", MIB, MeasurementError, "give a table, or - to type one")
DECISIONS = Kind("a file of decisions", 16 * MIB, RunError, "name a file of decisions")
KILLS = Kind("a kill matrix", 16 * MIB, RunError, "make one with make hil-mutants")
REVIEWS = Kind("a list of reviews", MIB, RunError, "put back the one of this version")
REQUIREMENTS = Kind("a table of requirements", MIB, RunError, "name a TOML file")
TEMPLATE = Kind("a template", MIB, TemplateError, "see the folder templates/")

KINDS_OF_NODE = {
    stat.S_IFDIR: "a folder",
    stat.S_IFIFO: "a pipe",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFSOCK: "a socket",
}

_CHUNK = 256 * KIB


def read_bytes(path: Path | str, kind: Kind) -> bytes:
    """Return the content of a file.

    Args:
        path: a file, or links that lead to one.
        kind: what it should be.

    Raises:
        CgagenError: of the kind's class: it is not there, no file, too large or not readable.
    """
    try:
        with _opened(path, kind) as file:
            return _limited(file, path, kind)
    except (OSError, ValueError) as error:
        raise refused(path, kind, f"cannot be read ({_why(error)})") from error


def named_alike(folder: Path, name: str) -> list[str]:
    """Return what a folder has under a name, or else under that name in other letters' case.

    Windows, where many of these files are made, takes them for one.
    """
    if name in (".", "..") or os.path.lexists(folder / name):
        return [name]
    return others_alike(folder / name)


def others_alike(path: Path) -> list[str]:
    """Return the names beside a path that differ from its own in case at most."""
    try:
        names = os.listdir(path.parent)
    except (OSError, ValueError):
        return []
    return sorted(one for one in names if one.casefold() == path.name.casefold())


def alike(path: Path) -> Path | None:
    """Return the one file that a path leads to if a backslash parts folders and case is ignored.

    None where there is none, or several.
    """
    if os.path.lexists(path):
        return path
    place = Path(path.anchor)
    for part in re.split(r"[\\/]", str(path.relative_to(path.anchor))):
        found = named_alike(place, part)
        if len(found) != 1:
            return None
        place = place / found[0]
    return place


def read_bytes_if_there(path: Path | str, kind: Kind) -> bytes | None:
    """Return likewise; None where no such file is.

    Raises:
        CgagenError: see `read_bytes`.
    """
    try:
        os.stat(path)
    except (FileNotFoundError, NotADirectoryError):
        return None
    except (OSError, ValueError) as error:
        raise refused(path, kind, f"cannot be read ({_why(error)})") from error
    return read_bytes(path, kind)


def read_text(path: Path | str, kind: Kind) -> str:
    """Return the text of a file of UTF-8, without the mark that some editors put before it.

    Raises:
        CgagenError: see `read_bytes`; or it is no such text.
    """
    return decoded(read_bytes(path, kind), path, kind)


def decoded(data: bytes, path: Path | str, kind: Kind) -> str:
    """Return what bytes of UTF-8 say, without a byte order mark.

    Raises:
        CgagenError: of the kind's class, with the line of the first byte that is no text.
    """
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        raise _no_text(path, kind, "is text of 16 bits a character (UTF-16)")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        raise _no_text(path, kind, f"line {line}: not UTF-8 at byte {error.start}") from error


def _no_text(path: Path | str, kind: Kind, what: str) -> CgagenError:
    return kind.refusal(f"{short(str(path), 300)}: {what}; save it as UTF-8")


def read_stream(file: BinaryIO, name: str, kind: Kind) -> bytes:
    """Return what comes from a stream that a verb was asked to read, up to its end.

    Raises:
        CgagenError: of the kind's class: too much came, or it cannot be read.
    """
    try:
        return _limited(file, name, kind)
    except (OSError, ValueError) as error:
        raise refused(name, kind, f"cannot be read ({_why(error)})") from error


def start_of(path: Path | str, most: int) -> bytes | None:
    """Return the first bytes of a file; None where there is none that can be read.

    For who asks what a file is; reading it is another step, with its own sentences.
    """
    probe = Kind("a file", 1 << 62, CgagenError, "")
    try:
        with _opened(path, probe) as file:
            return file.read(most)
    except (OSError, ValueError, CgagenError):
        return None


def gunzipped(data: bytes, path: Path | str, kind: Kind) -> bytes:
    """Return what gzip has packed, of any number of members, as long as it is not too much.

    Raises:
        CgagenError: of the kind's class: cut, damaged, or larger than its kind may be.
    """
    whole, rest = bytearray(), data
    try:
        while True:
            one = zlib.decompressobj(wbits=31)
            whole += one.decompress(rest, kind.most + 1 - len(whole))
            if len(whole) > kind.most:
                raise refused(path, kind, f"unpacks to more than {kind.most:,} bytes")
            if not one.eof:
                raise refused(path, kind, "is cut: its packed data have no end")
            rest = one.unused_data.lstrip(b"\0")
            if not rest:
                return bytes(whole)
    except zlib.error as error:
        raise refused(path, kind, f"cannot be unpacked ({error})") from error


def refused(path: Path | str, kind: Kind, what: str) -> CgagenError:
    """Return (not raise) the refusal of a file, with what to do."""
    return kind.refusal(f"{short(str(path), 300)}: {what}; {kind.mend}")


def _opened(path: Path | str, kind: Kind) -> BinaryIO:
    """Open a file after a look at what it is, and look again at what was opened."""
    _check_node(os.stat(path), path, kind)  # opening a port would already reset a Stamp
    handle = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC | os.O_NOCTTY)
    try:
        _check_node(os.fstat(handle), path, kind)
        return os.fdopen(handle, "rb", buffering=0)
    except BaseException:
        os.close(handle)
        raise


def _check_node(found: os.stat_result, path: Path | str, kind: Kind) -> None:
    node = stat.S_IFMT(found.st_mode)
    if node == stat.S_IFREG:
        if found.st_size > kind.most:
            raise _too_large(path, kind, f"{found.st_size:,} bytes are")
        return
    what = KINDS_OF_NODE.get(node, "no file")
    mend = kind.mend if node == stat.S_IFDIR else "write its content to a file, and name that"
    raise kind.refusal(f"{short(str(path), 300)}: is {what}, not {kind.what}; {mend}")


def _limited(file: BinaryIO, path: Path | str, kind: Kind) -> bytes:
    content = bytearray()
    while (chunk := file.read(_CHUNK)) != b"":
        if chunk is None:  # some files of the system's wait for news
            raise BlockingIOError(errno.EAGAIN, "it gives nothing at the moment")
        content += chunk
        if len(content) > kind.most:
            raise _too_large(path, kind, "its content is")
    return bytes(content)


def _too_large(path: Path | str, kind: Kind, what: str) -> CgagenError:
    return refused(path, kind, f"{what} too many for {kind.what} (at most {kind.most:,} bytes)")


def _why(error: OSError | ValueError) -> str:
    if isinstance(error, OSError):
        return error.strerror or str(error)
    return "no file can have such a name" if "null" in str(error) else str(error)
