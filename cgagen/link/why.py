"""Why a port does not open, and what can be known of it without opening it."""

import errno
import grp
import os
import re
import stat
import termios
from pathlib import Path

PROCESSES = Path("/proc")

_NUMBER = re.compile(r"://[^/]+:\d+")

LOST = (OSError, TypeError, ValueError, termios.error)
"""What pyserial raises when a port goes away under it."""

LINELESS = frozenset({errno.ENOTTY, errno.EINVAL, errno.EOPNOTSUPP})
"""What a system says of a port that has no DTR, or no BREAK."""

ABSENT = "it is not there; look at the cable, and at `cgagen ports`"


def why_closed(name: str, error: BaseException) -> str:
    """Return why a port could not be opened, with what to do.

    >>> why_closed("/dev/ttyUSB9", OSError(2, "No such file or directory"))
    'it is not there; look at the cable, and at `cgagen ports`'
    """
    number = getattr(error, "errno", None)
    if number in (errno.EACCES, errno.EPERM):
        return no_permission(name)
    if number in (errno.ENOENT, errno.ENODEV, errno.ENXIO):
        return ABSENT
    if number in (errno.EBUSY, errno.EAGAIN):
        return busy(holders(name))
    if number in (errno.ENOTTY, errno.EINVAL, errno.EISDIR) or _is_file(name):
        return "it is no serial port; name another, `cgagen ports` lists them"
    if "://" in name and not _NUMBER.search(name):
        return "it lacks the number of the socket; say rfc2217://HOST:PORT or socket://HOST:PORT"
    if "://" in name:
        return f"{_plain(error)}; is the other side running and free, and the name right?"
    return f"{_plain(error)}; look at the cable and the name"


def no_permission(name: str) -> str:
    """Return the sentence about a port that the user may not open."""
    group = group_of(name)
    if not group:
        return "you may not; ask whoever keeps this machine"
    return (
        f"you may not, for it belongs to the group {group}; "
        f"run `sudo usermod -aG {group} $USER` and log in again"
    )


def busy(others: list[str]) -> str:
    """Return the sentence about a port that somebody else has open."""
    who = f" ({', '.join(others)})" if others else ""
    return f"another program has it open{who}; close that first"


def group_of(device: str) -> str:
    """Return the group that may open a device; "" where there is none."""
    try:
        entry = os.stat(device)
        if not entry.st_mode & stat.S_IRGRP:
            return ""
        return grp.getgrgid(entry.st_gid).gr_name
    except (OSError, KeyError):
        return ""


def may_open(device: str) -> bool:
    """Say whether this user may open a device for both ways."""
    return os.access(device, os.R_OK | os.W_OK)


def holders(device: str, processes: Path = PROCESSES) -> list[str]:
    """Return who has a device open, as "name, process N"; only one's own processes can be seen.

    Args:
        device: its path, or a link to it.
        processes: where the system lists its processes.
    """
    if "://" in device or not processes.is_dir():
        return []
    real = os.path.realpath(device)
    found = []
    for process in sorted(processes.glob("[0-9]*"), key=lambda path: int(path.name)):
        if int(process.name) != os.getpid() and _has_open(process, real):
            found.append(f"{_name_of(process)}, process {process.name}")
    return found


def _has_open(process: Path, real: str) -> bool:
    try:
        return any(os.readlink(handle) == real for handle in (process / "fd").iterdir())
    except OSError:  # another user's, or it has ended meanwhile
        return False


def _name_of(process: Path) -> str:
    try:
        return (process / "comm").read_text("utf-8", "replace").strip()
    except OSError:
        return "a program"


def _is_file(name: str) -> bool:
    try:
        return not stat.S_ISCHR(os.stat(name).st_mode)
    except OSError:
        return False


def _plain(error: BaseException) -> str:
    return str(getattr(error, "strerror", None) or error)
