"""How a call ends that did not end well: one sentence on stderr, and an exit code.

What a user can mend is a `CgagenError`. What the computer refuses where nobody expected it (a name
that is too long, a file that may not grow, no memory) is told likewise. Everything else is a bug
of ours, whose traceback goes to a file of the user's own, or is printed with `-v`.
"""

import contextlib
import errno
import io
import os
import re
import signal
import sys
import tempfile
import traceback
from collections.abc import Iterable
from pathlib import Path

import click

from cgagen import __version__
from cgagen.errors import CgagenError, StorageError, ToolchainError
from cgagen.shown import LONGEST_MESSAGE, printable, sentence, short
from cgagen.signals import Asked

POSIX_MODULES = frozenset({"fcntl", "grp", "pty", "termios", "tty"})
"""Of Python's own, which Windows does not have."""

POSIX = "Linux or macOS; on Windows, run cgagen in the Windows Subsystem for Linux"

PIPE_CLOSED, BUG = 141, 1

REFUSALS = frozenset(
    getattr(errno, name)
    for name in (
        "EACCES", "EPERM", "EROFS", "ENOSPC", "EDQUOT", "EFBIG", "EIO", "ENAMETOOLONG", "ELOOP",
        "ENOENT", "ENOTDIR", "EISDIR", "EEXIST", "ENOTEMPTY", "EMFILE", "ENFILE", "ENOMEM",
        "EAGAIN", "EBUSY", "ETXTBSY", "EXDEV", "ENXIO", "ENODEV", "EMLINK", "ESTALE", "ENOTSUP",
    )
)  # fmt: skip
"""What a system refuses to anybody; other numbers say that we have called it wrongly."""


def ended(code: int, asked: Asked) -> int:
    """Return the exit code of a verb that has come to its end.

    Some take Ctrl-C for their end and count it as one; other signals are told in any case.

    Args:
        code: of the verb.
        asked: what has asked for the end meanwhile.
    """
    return code if asked.number in (None, signal.SIGINT) else asked.exit_code


def end(error: BaseException, words: Iterable[str], asked: Asked | None = None) -> int:
    """Say why a call has ended, and return its exit code.

    Args:
        error: what ended it.
        words: of the command line.
        asked: what has asked for the end meanwhile.
    """
    asked = asked or Asked()
    if isinstance(error, click.Abort) and isinstance(error.__cause__, EOFError):
        error = error.__cause__  # what read a file to its end is no user at a keyboard
    if isinstance(error, click.exceptions.Exit):
        return ended(error.exit_code, asked)
    if isinstance(error, click.ClickException):
        told = io.StringIO()
        error.show(told)
        _say(told.getvalue().rstrip("\n"))
        return error.exit_code
    if isinstance(error, CgagenError):
        _say(f"cgagen: {error}")
        return error.exit_code
    # Where a signal comes in the middle of an import, anything may be made of it.
    if isinstance(error, KeyboardInterrupt | click.Abort) or asked.number is not None:
        _say(f"cgagen: stopped by {asked.name}; nothing half-written was left behind")
        return asked.exit_code
    if isinstance(error, BrokenPipeError | SystemExit):  # the latter is click's of the former
        _let_go()
        return PIPE_CLOSED
    return _unexpected(error, is_verbose(words))


def is_verbose(words: Iterable[str]) -> bool:
    """Say whether -v or --verbose is among the words, wherever it stands.

    >>> is_verbose(["info", "x", "-v"]), is_verbose(["-qv"]), is_verbose(["info", "--", "-v"])
    (True, True, False)
    """
    for word in words:
        if word == "--":
            return False
        if word == "--verbose" or re.fullmatch(r"-q*v[qv]*", word):
            return True
    return False


def _unexpected(error: BaseException, verbose: bool) -> int:
    if isinstance(error, ModuleNotFoundError) and error.name in POSIX_MODULES:
        _say(f"cgagen: this verb needs {POSIX}")
        return ToolchainError.exit_code
    if isinstance(error, OSError) and error.errno in REFUSALS:
        if error.filename is None:
            _let_go()
        where = error.filename if isinstance(error.filename, str | bytes | os.PathLike) else None
        what = short(os.fsdecode(where), 300) if where else "what was to be written or read"
        _say(f"cgagen: {what}: the system refuses it ({error.strerror}); mend that, and try again")
        return StorageError.exit_code
    if isinstance(error, MemoryError):
        _say("cgagen: the memory does not suffice; close other programs, or take smaller files")
        return StorageError.exit_code
    trace = printable("".join(traceback.format_exception(error)))
    kind = f"cgagen: a bug of ours ({type(error).__name__}: {short(str(error), 300)})"
    if verbose:
        _say(f"{kind}; report what follows\n{trace}", most=len(trace) + LONGEST_MESSAGE)
        return BUG
    report = _kept(f"cgagen {__version__}, Python {sys.version.split()[0]}\n{trace}")
    where = f"{report} has the details" if report else "run it again with -v for the details"
    _say(f"{kind}; {where}, please report them")
    return BUG


def _kept(text: str) -> Path | None:
    """Write a report to a new file that only the user can read; None where none can be."""
    base = os.environ.get("XDG_STATE_HOME", "")
    root = Path(base) if os.path.isabs(base) else Path(os.path.expanduser("~/.local/state"))
    for folder in (root / "cgagen", Path(tempfile.gettempdir())):
        try:
            if folder.name == "cgagen":
                folder.mkdir(parents=True, exist_ok=True)
            handle, name = tempfile.mkstemp(prefix="cgagen-bug-", suffix=".txt", dir=folder)
            with os.fdopen(handle, "w", encoding="utf-8") as file:
                file.write(text)
        except (OSError, ValueError):
            continue
        return Path(name)
    return None


def remove_own_temporaries() -> None:
    """Remove what a signal at a bad moment has kept from being removed."""
    temporaries = sys.modules.get("cgagen.temporaries")  # not there, nothing made
    if temporaries is not None:
        temporaries.remove_own()


def flush() -> None:
    """Write what has been printed, as long as there is somebody to tell that it cannot be."""
    if sys.stdout is not None:  # a process may be begun without
        sys.stdout.flush()


def _let_go() -> None:
    """Make sure that what could not be printed is not tried again when the process ends."""
    with contextlib.suppress(OSError, ValueError, AttributeError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _say(text: str, most: int = LONGEST_MESSAGE) -> None:
    """Print on stderr; where that is gone or full there is nobody to tell."""
    try:
        sys.stderr.write(f"{sentence(text, most)}\n")
        sys.stderr.flush()
    except (OSError, ValueError, AttributeError):
        return
