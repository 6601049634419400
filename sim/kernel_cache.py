"""Compiled kernels on the disk: what is whole and ours is loaded, everything else made again.

Numba's own cache unpickles what it finds, and a file that was cut ends the program. Here a file
begins with the digest of what follows, which is looked at before anything is unpickled; whatever
goes wrong in reading or writing costs a compilation and nothing else. A kernel is in one file,
named by all that its machine code depends on; the folder is named by its sources.
"""

import errno
import hashlib
import os
import pickle
import stat
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

import llvmlite
import numba
from numba.core import compiler, serialize
from numba.core.caching import Cache

from cgagen.caches import TROUBLE, trouble_of, trouble_of_stat
from cgagen.errors import CgagenError
from cgagen.files import digest, write_bytes
from cgagen.inputs import MIB

SUFFIX = ".kernel"
MAGIC = b"cgagen-kernel-1\n"
DIGEST_BYTES = 32
LARGEST = 64 * MIB
"""Bytes of a kernel; the largest has some 200 kB. Choice."""


_Result: Any = compiler.CompileResult
_dumps: Any = serialize.dumps


class KernelCache(Cache):
    """The cache of one function, as Numba's dispatcher asks for it.

    Args:
        function: what is compiled.
        folder: for all kernels; None for no cache.
    """

    def __init__(self, function: Callable[..., Any], folder: Path | None) -> None:
        self._py_func = function
        self._name = repr(function)
        self._folder = folder
        self._enabled = True

    @property
    def cache_path(self) -> str:
        """Return the folder, as Numba asks for it."""
        return str(self._folder or "")

    def flush(self) -> None:
        """Forget nothing: a file whose name says all that it depends on is never out of date."""

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return a compiled function; None where there is none that can be used."""
        if not self._enabled or self._folder is None:
            return None
        target_context.refresh()
        path = self._path(sig, target_context.codegen())
        try:
            payload = self._payload(path)
            if payload is None:
                return None
            return _Result._rebuild(target_context, *pickle.loads(payload))
        except Exception as error:  # a kernel of another library may raise anything
            TROUBLE.add(f"{path}: {_words(error)}; compiling again")
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep a compiled function, if it can be kept."""
        if not self._enabled or self._folder is None:
            return
        if any(not one.can_cache for one in data.lifted) or data.library.has_dynamic_globals:
            return
        path = self._path(sig, data.codegen)
        try:
            _make_private(self._folder)
            _drop_what_is_no_file(path)
            payload: bytes = _dumps(data._reduce())
            write_bytes(path, MAGIC + hashlib.sha256(payload).digest() + payload)
        except (CgagenError, OSError, pickle.PicklingError, ValueError) as error:
            TROUBLE.add(f"{path}: {_words(error)}; compiling again")
            self._enabled = False

    def _path(self, sig: Any, codegen: Any) -> Path:
        """Return the file of a signature: what its machine code depends on is in its name."""
        code = self._py_func.__code__
        inner = self._py_func.__closure__ or ()
        parts = (
            sys.implementation.cache_tag,
            numba.__version__,
            llvmlite.__version__,
            str(sig),
            repr(codegen.magic_tuple()),
            code.co_code.hex(),
            digest(_dumps(tuple(cell.cell_contents for cell in inner))) if inner else "",
        )
        name = f"{self._py_func.__name__}-{code.co_firstlineno}-{digest(chr(0).join(parts))[:16]}"
        return cast(Path, self._folder) / f"{name}{SUFFIX}"

    def _payload(self, path: Path) -> bytes | None:
        """Return what a file holds behind its digest; None where there is no file.

        Raises:
            ValueError: it is damaged, or others could have written it.
            OSError: it cannot be read.
        """
        try:
            _check(trouble_of(cast(Path, self._folder)), self._folder)
            handle = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
        except FileNotFoundError:
            return None
        with os.fdopen(handle, "rb") as file:
            _check(trouble_of_stat(os.fstat(file.fileno())), None)
            content = file.read(LARGEST)
        start = len(MAGIC) + DIGEST_BYTES
        payload = content[start:]
        if content[:start] != MAGIC + hashlib.sha256(payload).digest():
            raise ValueError("it is damaged")
        return payload


def _make_private(folder: Path) -> None:
    """Make the folder for this user alone; refuse one that others can write.

    Raises:
        ValueError: others can write it.
        OSError: it cannot be made.
    """
    folder.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    folder.mkdir(mode=0o700, exist_ok=True)
    _check(trouble_of(folder), folder)


def _drop_what_is_no_file(path: Path) -> None:
    """Remove a link or a pipe that stands where a kernel belongs; the folder is ours alone."""
    try:
        is_file = stat.S_ISREG(path.lstat().st_mode)
    except FileNotFoundError:
        return
    if not is_file:
        path.unlink()


def _check(trouble: str, folder: Path | None) -> None:
    if trouble:
        raise ValueError(f"{folder}: {trouble}" if folder else trouble)


def _words(error: BaseException) -> str:
    if isinstance(error, OSError) and error.errno in {errno.ENOSPC, errno.EDQUOT}:
        return "the disk is full"
    return str(error) or type(error).__name__
