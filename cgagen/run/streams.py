"""Random numbers as a function of what they are for, so that no state has to be kept.

Philox turns a key of 128 bits into a stream (Salmon et al., "Parallel random numbers: as easy as
1, 2, 3", SC 2011); other keys give unrelated streams. The key is written out of plain integers:

* first word: the seed;
* second word: trial, generation, purpose in 24, 32 and 8 bits, most significant first.
"""

from enum import IntEnum

import numpy as np

SEED_BITS = 64
TRIAL_BITS = 24
GENERATION_BITS = 32
PURPOSE_BITS = 8


class Purpose(IntEnum):
    """What a stream is drawn for. The numbers are part of the format of a run: never reuse one."""

    POPULATION = 0
    STARTS = 1
    CHILDREN = 2
    FIXED_STARTS = 3


def stream(seed: int, trial: int, generation: int, purpose: Purpose) -> np.random.Generator:
    """Return the generator for one purpose in one generation, always at its beginning.

    Args:
        seed: 0 to 2**64 - 1.
        trial: 0 to 2**24 - 1; the trials of a run begin at 1, 0 is for all of them.
        generation: 0 to 2**32 - 1; generations begin at 1, 0 is before the first.
        purpose: what for.

    Raises:
        ValueError: a number that does not fit its field.

    >>> stream(7, 1, 1, Purpose.STARTS).random() == stream(7, 1, 1, Purpose.STARTS).random()
    True
    >>> stream(7, 1, 1, Purpose.STARTS).random() == stream(7, 1, 2, Purpose.STARTS).random()
    False
    """
    fields = (
        ("seed", seed, SEED_BITS),
        ("trial", trial, TRIAL_BITS),
        ("generation", generation, GENERATION_BITS),
        ("purpose", purpose, PURPOSE_BITS),
    )
    for name, value, bits in fields:
        if not 0 <= value < 2**bits:
            raise ValueError(f"{name} is {value}, it must be 0 to 2**{bits} - 1")
    second = (trial << GENERATION_BITS | generation) << PURPOSE_BITS | purpose
    key = np.array([seed, second], dtype=np.uint64)
    return np.random.Generator(np.random.Philox(key=key))
