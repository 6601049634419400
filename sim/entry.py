"""What enters the world from outside, looked at once, before a kernel reads it.

Compiled code looks at no bounds: a row that is too short is read past its end, and what stands
there decides. So everything that is handed to a kernel comes through here, is of the shape and
type that the kernel was written for, and lies in memory as it expects.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cgagen.words import BITS_PER_GENE, GENOME_BITS
from sim.starts import START_COLUMNS

UNIT_SLACK = 1e-9
"""How far the length of a heading may be from 1. Choice: rounding."""


def checked_bits(bits: NDArray[Any]) -> NDArray[np.uint8]:
    """Return genomes of 0 and 1, shape (n, 192).

    Raises:
        ValueError: another shape, or other numbers.

    >>> checked_bits(np.zeros((2, 190)))
    Traceback (most recent call last):
    ...
    ValueError: genomes have the shape (n, 192), not (2, 190)
    """
    array = np.asarray(bits)
    if array.ndim != 2 or array.shape[1] != GENOME_BITS:
        raise ValueError(f"genomes have the shape (n, {GENOME_BITS}), not {array.shape}")
    if array.dtype.kind not in "biu" or (array.size and not 0 <= array.min() <= array.max() <= 1):
        raise ValueError(f"genomes are of bits 0 and 1, not of {array.dtype} in another range")
    return np.ascontiguousarray(array, np.uint8)


def checked_words(words: NDArray[Any]) -> NDArray[np.int64]:
    """Return genomes as `sim.model.words_of` makes them, shape (3, n) or (3,).

    Raises:
        ValueError: another shape or type.
    """
    array = np.asarray(words)
    if array.ndim not in (1, 2) or array.shape[0] != BITS_PER_GENE or array.dtype != np.int64:
        raise ValueError(
            f"the words of genomes are int64 of shape ({BITS_PER_GENE}, n), not {array.dtype} of "
            f"{array.shape}; make them with words_of"
        )
    return np.ascontiguousarray(array)


def checked_starts(starts: NDArray[Any]) -> NDArray[np.float64]:
    """Return starts, shape (S, 8); see `sim.starts`.

    Raises:
        ValueError: another shape, a number that is none, or a heading of another length than 1.
    """
    array = np.asarray(starts)
    if array.ndim != 2 or array.shape[1] != START_COLUMNS or array.dtype.kind not in "fiu":
        raise ValueError(
            f"starts have the shape (S, {START_COLUMNS}), not {array.shape} of {array.dtype}"
        )
    array = np.ascontiguousarray(array, np.float64)
    if not np.isfinite(array).all():
        raise ValueError("a start has a number that is none (NaN or infinite); draw starts")
    for column in (2, 6):
        lengths = np.hypot(array[:, column], array[:, column + 1])
        if (np.abs(lengths - 1.0) > UNIT_SLACK).any():
            raise ValueError("a heading of a start is no unit vector; draw starts, or start_of")
    return array


def checked_steps(steps: int) -> int:
    """Return a number of gait cycles.

    Raises:
        ValueError: none, or less.
    """
    if isinstance(steps, bool) or not isinstance(steps, int | np.integer) or steps < 1:
        raise ValueError(f"an episode has 1 step or more, not {steps!r}")
    return int(steps)
