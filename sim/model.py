"""The world as evolution sees it: individuals and starts in, scores out."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cgagen.robot import Arena, Robot
from cgagen.words import BITS_PER_GENE, GENES
from sim.batch import LANES, play
from sim.entry import checked_bits, checked_starts, checked_steps, checked_words
from sim.numbers import Options, world_numbers
from sim.starts import draw_starts

STEPS = 200
"""Gait cycles of an episode. Ref: S1 III.A."""


@dataclass(frozen=True, slots=True)
class Scores:
    """How well individuals did.

    Attributes:
        fitness: mean step score over all starts, arena units, shape (individuals,).
        captured: share of the starts that ended in a capture, shape (individuals,).
    """

    fitness: NDArray[np.float64]
    captured: NDArray[np.float64]


def words_of(bits: NDArray[np.uint8]) -> NDArray[np.int64]:
    """Return genomes as the three words that the kernel reads.

    Args:
        bits: 0 or 1, gene 0 first, the most significant bit of a gene first, shape (n, 192).

    Returns:
        Word b holds bit b of all 64 commands, shape (3, n).

    Raises:
        ValueError: another shape, or other numbers.

    >>> one = np.zeros((1, 192), np.uint8); one[0, 3:6] = (1, 0, 1)   # gene 1 is 101
    >>> words_of(one)[:, 0].tolist()
    [2, 0, 2]
    """
    genes = checked_bits(bits).reshape(-1, GENES, BITS_PER_GENE)[:, :, ::-1]
    packed = np.packbits(np.ascontiguousarray(genes.transpose(2, 0, 1)), axis=2, bitorder="little")
    return np.ascontiguousarray(packed).view("<i8")[:, :, 0].astype(np.int64)


def with_distance(starts: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return starts as columns with the distance between the robots, shape (9, starts)."""
    dx, dy = starts[:, 4] - starts[:, 0], starts[:, 5] - starts[:, 1]
    return np.ascontiguousarray(np.column_stack((starts, np.sqrt(dx * dx + dy * dy))).T)


class World:
    """Two robots in an arena. The same arguments give the same scores, bit for bit.

    Args:
        predator: whose genomes are tried.
        prey: the robot that it hunts.
        arena: where.
        options: what the paper leaves open.
        steps: gait cycles of an episode.
        threads: how many share the episodes; the results do not depend on it.

    Raises:
        ValueError: fewer steps or threads than 1.
    """

    def __init__(
        self,
        predator: Robot,
        prey: Robot,
        arena: Arena,
        options: Options | None = None,
        steps: int = STEPS,
        threads: int = 1,
    ) -> None:
        self.numbers = world_numbers(predator, prey, arena, options)
        self.steps = checked_steps(steps)
        if threads < 1:
            raise ValueError(f"threads is {threads}, it must be 1 or more")
        self._gap_units = arena.start_gap_units
        self._threads = threads
        self._pool = ThreadPoolExecutor(threads) if threads > 1 else None

    def draw_starts(self, rng: np.random.Generator, count: int) -> NDArray[np.float64]:
        """Return random starts, shape (count, 8); columns as in `sim.starts`."""
        radii = self.numbers.predator.radius, self.numbers.prey.radius
        return draw_starts(rng, count, self.numbers.side, radii, self._gap_units)

    def evaluate(self, bits: NDArray[np.uint8], starts: NDArray[np.float64]) -> Scores:
        """Play every individual from every start.

        Args:
            bits: shape (n, 192); see `words_of`.
            starts: shape (S, 8).

        Raises:
            ValueError: another shape, or numbers that cannot be.
        """
        if not len(bits) or not len(starts):
            raise ValueError("nobody plays, or from nowhere; give individuals and starts")
        individuals, count = len(bits), len(starts)
        scores, caught = self.play(words_of(bits), starts)
        # A running sum adds in one order everywhere; NumPy's own sum may not.
        total = np.cumsum(scores.reshape(individuals, count), axis=1)[:, -1]
        captures = (caught.reshape(individuals, count) > 0).sum(axis=1)
        return Scores(total / (count * self.steps), captures / count)

    def play(
        self, words: NDArray[np.int64], starts: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """Play episodes; return the sums of their step scores and the steps of their captures.

        Both have the shape (n * S,), genome by genome; the step of a capture is 0 for none.

        Raises:
            ValueError: another shape, or numbers that cannot be.
        """
        words, starts = checked_words(words), checked_starts(starts)
        if words.ndim != 2:
            raise ValueError(f"the words of genomes have the shape (3, n), not {words.shape}")
        episodes = words.shape[1] * len(starts)
        scores, caught = np.empty(episodes), np.empty(episodes, np.int64)
        columns = with_distance(starts)

        def part(first: int, last: int) -> None:
            play(words, columns, self.steps, self.numbers, first, last, scores, caught)

        if self._pool is None or episodes == 0:
            part(0, episodes)
        else:
            share = -(-episodes // (self._threads * LANES)) * LANES
            jobs = [
                self._pool.submit(part, first, min(first + share, episodes))
                for first in range(0, episodes, share)
            ]
            for job in jobs:
                job.result()
        return scores, caught

    def close(self) -> None:
        """Give back the threads; the world is not used again."""
        if self._pool is not None:
            self._pool.shutdown()
