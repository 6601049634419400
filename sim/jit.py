"""How the world is compiled: two decorators, and a cache that notices every edit.

Numba keys its cache on the file of the outer function alone, so an edit of an inlined helper in
another file would go unnoticed. Here the cache folder is named by the digest of all the files
that the kernel is made of; what is in it, see `sim.kernel_cache`.

No fast-math and no contraction: the operations are IEEE double precision in the order written,
so plain Python (`NUMBA_DISABLE_JIT=1`) and every CPU give the same bits.
"""

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import llvmlite.binding
import numba

from cgagen import counts
from cgagen.caches import user_cache
from cgagen.files import digest
from cgagen.robot import values
from sim.kernel_cache import SUFFIX, KernelCache

F = TypeVar("F", bound=Callable[..., Any])

KERNEL_FILES = (
    Path(counts.__file__),
    Path(values.__file__),
    *(
        Path(__file__).with_name(name)
        for name in (
            "jit.py",
            "trig.py",
            "numbers.py",
            "senses.py",
            "decide.py",
            "world.py",
            "batch.py",
            "starts.py",
            "model.py",
            "entry.py",
            "kernel_cache.py",
        )
    ),
)


def kernel_digest() -> str:
    """Return the digest of the sources that a result depends on, 16 hexadecimal digits."""
    return digest("".join(path.read_text("utf-8") for path in KERNEL_FILES))[:16]


def cache_folder() -> Path | None:
    """Return the folder for compiled kernels, named by the sources; None where there is no home.

    It lies in NUMBA_CACHE_DIR where the user has set that, else in the user's cache.
    """
    given = os.environ.get("NUMBA_CACHE_DIR")
    ours = Path(given).absolute() if given else user_cache()
    return None if ours is None else ours / f"kernel-{kernel_digest()}"


def is_compiled() -> bool:
    """Say whether this machine has compiled the world step before, as far as one can tell."""
    try:
        return FOLDER is not None and any(FOLDER.glob(f"*{SUFFIX}"))
    except OSError:
        return False


def _prepare() -> None:
    """Choose the vector width, unless the user has.

    LLVM holds Intel's AVX-512 processors to half of their width; the step is a third faster at
    full width (measured: 19 against 25 M steps/s on a Cascade Lake). The bits are the same.
    """
    settings = cast(Any, numba.config)
    features = llvmlite.binding.get_host_cpu_features()
    if "NUMBA_CPU_FEATURES" not in os.environ and features.get("avx512f"):
        settings.CPU_NAME = settings.CPU_NAME or llvmlite.binding.get_host_cpu_name()
        settings.CPU_FEATURES = f"{features.flatten()},-prefer-256-bit"


_prepare()

FOLDER = cache_folder()
"""Of this process."""


def device(function: F) -> F:
    """Compile a helper of the step: always inlined, so that LLVM can run it in lanes."""
    return cast(F, _kept(numba.njit(error_model="numpy", forceinline=True)(function)))


def kernel(function: F) -> F:
    """Compile a loop over episodes: releases the GIL, kept in the cache."""
    return cast(F, _kept(numba.njit(error_model="numpy", nogil=True)(function)))


def _kept(compiled: Any) -> Any:
    """Give a function its cache; plain Python (`NUMBA_DISABLE_JIT=1`) has none."""
    if hasattr(compiled, "py_func"):
        compiled._cache = KernelCache(compiled.py_func, FOLDER)
    return compiled
