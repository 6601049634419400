"""Many episodes at once: the scalar step in 64 lanes.

LLVM turns the innermost loop into vector code: eight lanes at a time with AVX-512, four with
AVX2, and every lane computes exactly what the scalar step computes.

A capture that holds both robots decides the rest of an episode: the remaining steps all score
the same, so they are added up at once and the lane goes on with the next episode. In an evolved
population that saves most of the steps.
"""

import numpy as np
from numpy.typing import NDArray

from sim.jit import device, kernel
from sim.numbers import WorldNumbers
from sim.world import Pair, Words, captured, score_of, step

LANES = 64
"""Episodes side by side; 16 to 256 are equally fast. Measured."""

CHUNK = 8
"""Steps between two looks at which lanes are done. It decides in which order an episode's scores
are added, so it is part of what makes results equal bit for bit. Choice."""


@device
def bonus(n: float) -> float:
    """Return the factor of the score of step n, from 1. Ref: S1 III.A, equation 2."""
    return 1.0 + 1.0 / (n * n)


@kernel
def play(
    genomes: NDArray[np.int64],
    starts: NDArray[np.float64],
    steps: int,
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
        steps: gait cycles of an episode.
        numbers: of this world.
        first: an episode.
        last: the one after the last.
        scores: filled with the sum of the step scores, shape (genomes * S,).
        caught: filled with the step of the capture, 0 for none, same shape.
    """
    count = starts.shape[1]
    rest = np.zeros(steps + 1)
    for n in range(steps - 1, -1, -1):
        rest[n] = rest[n + 1] + bonus(n + 1.0)
    z = np.ones((9, LANES))
    total = np.zeros(LANES)
    number = np.zeros(LANES)
    at = np.zeros(LANES)
    g = np.zeros((3, LANES), np.int64)
    episode = np.full(LANES, -1, np.int64)
    waiting = first
    playing = 0
    while True:
        for j in range(LANES):
            k = episode[j]
            held = numbers.hold and at[j] > 0.0
            if k >= 0 and (held or number[j] >= steps):
                if held and number[j] < steps:
                    total[j] += score_of(z[8, j], numbers.scoring) * rest[int(number[j])]
                scores[k] = total[j]
                caught[k] = int(at[j])
                episode[j] = -1
                playing -= 1
            if episode[j] < 0 and waiting < last:
                episode[j] = waiting
                for row in range(9):
                    z[row, j] = starts[row, waiting % count]
                for row in range(3):
                    g[row, j] = genomes[row, waiting // count]
                total[j] = 0.0
                number[j] = 0.0
                at[j] = 0.0
                waiting += 1
                playing += 1
        if playing == 0:
            return
        for _ in range(CHUNK):
            for j in range(LANES):
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
                n = number[j] + 1.0
                number[j] = n
                score = score_of(pair.distance, numbers.scoring) * bonus(n)
                total[j] += score if n <= steps else 0.0
                now = captured(pair.distance, numbers.scoring) & (at[j] == 0.0) & (n <= steps)
                at[j] = n if now else at[j]
