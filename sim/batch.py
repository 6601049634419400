"""Many episodes at once: the scalar step in 64 lanes.

LLVM turns the innermost loop into vector code: eight lanes at a time with AVX-512, four with
AVX2, and every lane computes exactly what the scalar step computes.
"""

import numpy as np
from numpy.typing import NDArray

from sim.jit import kernel
from sim.numbers import WorldNumbers
from sim.world import Pair, Words, captured, score_of, step

LANES = 64
"""Episodes side by side; 16 to 256 are equally fast. Measured."""


@kernel
def play(
    genomes: NDArray[np.int64],
    starts: NDArray[np.float64],
    bonus: NDArray[np.float64],
    numbers: WorldNumbers,
    first: int,
    last: int,
    scores: NDArray[np.float64],
    caught: NDArray[np.int64],
) -> None:
    """Play episodes `first` to `last - 1`; episode k is genome k // S from start k % S.

    Args:
        genomes: the words of `sim.decide.gene`, shape (3, genomes).
        starts: poses px, py, pc, ps, qx, qy, qc, qs and the distance, shape (9, S).
        bonus: factor of step n at index n - 1, shape (steps,).
        numbers: of this world.
        first: an episode.
        last: the one after the last.
        scores: filled with the sum of the step scores, shape (genomes * S,).
        caught: filled with the step of the capture, 0 for none, same shape.
    """
    count = starts.shape[1]
    z = np.empty((10, LANES))
    g = np.empty((3, LANES), np.int64)
    at = np.zeros(LANES, np.int64)
    for block in range(first, last, LANES):
        lanes = min(LANES, last - block)
        for j in range(lanes):
            for row in range(9):
                z[row, j] = starts[row, (block + j) % count]
            z[9, j] = 0.0
            at[j] = 0
            for row in range(3):
                g[row, j] = genomes[row, (block + j) // count]
        for n in range(bonus.shape[0]):
            factor = bonus[n]
            for j in range(lanes):
                pair = Pair(
                    z[0, j], z[1, j], z[2, j], z[3, j], z[4, j], z[5, j], z[6, j], z[7, j], z[8, j]
                )  # fmt: skip
                pair = step(pair, Words(g[0, j], g[1, j], g[2, j]), numbers)
                z[0, j] = pair.px
                z[1, j] = pair.py
                z[2, j] = pair.pc
                z[3, j] = pair.ps
                z[4, j] = pair.qx
                z[5, j] = pair.qy
                z[6, j] = pair.qc
                z[7, j] = pair.qs
                z[8, j] = pair.distance
                z[9, j] += score_of(pair.distance, numbers.scoring) * factor
                at[j] = n + 1 if (at[j] == 0) & captured(pair.distance, numbers.scoring) else at[j]
        for j in range(lanes):
            scores[block + j] = z[9, j]
            caught[block + j] = at[j]
