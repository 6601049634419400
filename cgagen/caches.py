"""Where caches lie, and whether what lies there can only be ours.

A cache holds what this machine made or fetched once: compiled kernels and the tokenizer. Both are
run, so a folder in which another user could have put something is not used.
"""

import os
import stat
from collections.abc import Callable
from pathlib import Path


class Trouble:
    """What is wrong with a cache, told once in a process to who wants to know.

    Attributes:
        tell: takes the sentence; set where a user has asked for more words.
        seen: all sentences so far.
    """

    def __init__(self) -> None:
        self.tell: Callable[[str], None] | None = None
        self.seen: list[str] = []

    def add(self, words: str) -> None:
        """Note something; only the first is told, for the others mostly follow from it."""
        self.seen.append(words)
        if len(self.seen) == 1 and self.tell is not None:
            self.tell(f"note: a file of the cache is not used: {words}")


TROUBLE = Trouble()
"""Of this process."""


def user_cache() -> Path | None:
    """Return the folder for the caches of this user; None where there is no home.

    Ref: XDG Base Directory Specification; a relative path in XDG_CACHE_HOME is to be ignored.
    """
    base = os.environ.get("XDG_CACHE_HOME", "")
    if os.path.isabs(base):
        return Path(base) / "cgagen"
    try:
        return Path.home() / ".cache" / "cgagen"
    except RuntimeError:
        return None


def trouble_of(path: Path) -> str:
    """Return why a folder, or a file in one, may hold what others have put there; "" if not.

    Raises:
        OSError: it is not there, or cannot be looked at.
    """
    return trouble_of_stat(path.lstat())


def trouble_of_stat(found: os.stat_result) -> str:
    """Return likewise, of what `os.lstat` or `os.fstat` has found."""
    if stat.S_ISLNK(found.st_mode):
        return "it is a link"
    if not (stat.S_ISDIR(found.st_mode) or stat.S_ISREG(found.st_mode)):
        return "it is neither a folder nor a file"
    if found.st_uid != os.geteuid():
        return "it belongs to another user"
    if found.st_mode & stat.S_IWOTH:
        return "all users can write it"
    if found.st_mode & stat.S_IWGRP and not _is_private_group(found.st_gid):
        return "a group of users can write it"
    return ""


def _is_private_group(number: int) -> bool:
    """Say whether a group is a user's own, as many systems make one for each."""
    import grp
    import pwd

    try:
        group, user = grp.getgrgid(number), pwd.getpwuid(os.geteuid())
    except KeyError:
        return False
    return group.gr_name == user.pw_name and set(group.gr_mem) <= {user.pw_name}
