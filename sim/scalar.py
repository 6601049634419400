"""The step called in a plain loop, one episode after the other: what the lanes are measured by."""

import numpy as np
from numpy.typing import NDArray

from sim.batch import bonus
from sim.jit import kernel
from sim.numbers import WorldNumbers
from sim.world import Pair, Words, score_of, step


@kernel
def play_scalar(
    genomes: NDArray[np.int64],
    starts: NDArray[np.float64],
    steps: int,
    numbers: WorldNumbers,
    scores: NDArray[np.float64],
) -> None:
    """Play all episodes to their last step, as `sim.batch.play` does in lanes."""
    count = starts.shape[1]
    for k in range(scores.shape[0]):
        j = k % count
        words = Words(genomes[0, k // count], genomes[1, k // count], genomes[2, k // count])
        pair = Pair(
            starts[0, j], starts[1, j], starts[2, j], starts[3, j], starts[4, j], starts[5, j],
            starts[6, j], starts[7, j], starts[8, j],
        )  # fmt: skip
        total = 0.0
        for n in range(1, steps + 1):
            pair = step(pair, words, numbers)
            total += score_of(pair.distance, numbers.scoring) * bonus(float(n))
        scores[k] = total
