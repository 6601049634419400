"""Selection, crossover, mutation: the genetic algorithm. It knows bits and fitness only.

Every random number is a double of `Generator.random`, and every sum is made in a fixed order, so
the same generator state gives the same children on every machine and with every NumPy.

>>> settings = Settings(population=4, bits=6)
>>> rng = np.random.Generator(np.random.Philox(key=1))
>>> bits = first_generation(settings, rng)
>>> next_generation(bits, bits.sum(axis=1).astype(np.float64), settings, rng).shape
(4, 6)
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Bits = NDArray[np.uint8]
"""A population: 0 and 1, shape (population, bits)."""

Fitness = NDArray[np.float64]
"""One number per individual, 0 or more, shape (population,)."""


@dataclass(frozen=True, slots=True)
class Settings:
    """What the paper fixes of its genetic algorithm, each value open to change.

    Attributes:
        population: individuals, the same in every generation. Ref: S1 section III.A.
        bits: bits of an individual: 64 genes of 3. Ref: S1 section III.A.
        mutation_rate: chance that a bit of a child is inverted. Ref: S1 section III.A, 0.003 %,
            read as a chance per bit (choice).
        selection: how parents are drawn. Ref: S1 section III.A, roulette wheel.
        crossover: how two parents make one child. Ref: S1 section III.A, two-point.
        elite: best individuals that pass unchanged. Ref: S1 section III.A names none.

    Raises:
        ValueError: a value is outside what is allowed.
    """

    population: int = 256
    bits: int = 192
    mutation_rate: float = 3e-5
    selection: str = "roulette"
    crossover: str = "two-point"
    elite: int = 0

    def __post_init__(self) -> None:
        if self.population < 2:
            raise ValueError(f"population is {self.population}, it must be 2 or more")
        if self.bits < 1:
            raise ValueError(f"bits is {self.bits}, it must be 1 or more")
        if not 0.0 <= self.mutation_rate <= 1.0:
            raise ValueError(f"mutation_rate is {self.mutation_rate}, it must be 0 to 1")
        if self.selection not in SELECTIONS:
            raise ValueError(f"selection is {self.selection!r}, not {' or '.join(SELECTIONS)}")
        if self.crossover not in CROSSOVERS:
            raise ValueError(f"crossover is {self.crossover!r}, not {' or '.join(CROSSOVERS)}")
        if not 0 <= self.elite < self.population:
            raise ValueError(f"elite is {self.elite}, it must be 0 to {self.population - 1}")


def first_generation(settings: Settings, rng: np.random.Generator) -> Bits:
    """Return a random population, every bit 0 or 1 with the same chance."""
    return (rng.random((settings.population, settings.bits)) < 0.5).astype(np.uint8)


def next_generation(
    bits: Bits, fitness: Fitness, settings: Settings, rng: np.random.Generator
) -> Bits:
    """Return the population that follows.

    Each child has two parents of its own, drawn with replacement (they may be the same
    individual), is crossed once and mutated. With an elite the best individuals, ties by index,
    take the first places unchanged.

    Args:
        bits: the population, shape (population, bits).
        fitness: of each individual, shape (population,); see `roulette` for what is allowed.
        settings: the parameters.
        rng: drawn from in this order: parents, cut points, mutation.

    Raises:
        ValueError: a shape that does not fit the settings, or a fitness that `roulette` refuses.
    """
    if bits.shape != (settings.population, settings.bits):
        raise ValueError(
            f"the population has shape {bits.shape}, the settings say "
            f"({settings.population}, {settings.bits})"
        )
    if fitness.shape != (settings.population,):
        raise ValueError(f"{fitness.shape} fitness values for {settings.population} individuals")
    children = settings.population - settings.elite
    parents = SELECTIONS[settings.selection](fitness, 2 * children, rng).reshape(children, 2)
    crossed = CROSSOVERS[settings.crossover](bits[parents[:, 0]], bits[parents[:, 1]], rng)
    mutated = mutate(crossed, settings.mutation_rate, rng)
    if not settings.elite:
        return mutated
    best = np.argsort(-fitness, kind="stable")[: settings.elite]
    return np.concatenate([bits[best], mutated])


def roulette(fitness: Fitness, count: int, rng: np.random.Generator) -> NDArray[np.intp]:
    """Draw individuals with a chance proportional to their fitness.

    Where every fitness is 0 the wheel has no sectors, and all have the same chance.

    Args:
        fitness: of each individual, finite and 0 or more, shape (population,).
        count: how many to draw, with replacement.
        rng: `count` doubles are drawn.

    Returns:
        Indices of individuals, shape (count,).

    Raises:
        ValueError: a fitness is negative, not a number or infinite, or their sum is infinite.

    Ref: S1 section III.A; the rule for zeros is a choice.
    """
    if not bool(np.all(fitness >= 0.0)):
        raise ValueError("a fitness is negative or not a number; roulette needs 0 or more")
    wheel = np.cumsum(fitness, dtype=np.float64)
    total = float(wheel[-1])
    if not math.isfinite(total):
        raise ValueError("the sum of all fitness values is not finite")
    if total == 0.0:
        wheel = np.arange(1.0, len(fitness) + 1.0)
        total = float(len(fitness))
    drawn = np.searchsorted(wheel, rng.random(count) * total, side="right")
    return np.minimum(drawn, np.searchsorted(wheel, total))  # a product can round up to the total


def two_point(first: Bits, second: Bits, rng: np.random.Generator) -> Bits:
    """Cross parents pairwise: the child is the first with a piece of the second.

    Both cut points are drawn from the places before, between and after the bits, each with the
    same chance; the piece lies between them, so it may be empty or the whole (choice: the paper
    only says two-point).

    Args:
        first: parents, shape (children, bits).
        second: the other parents, same shape.
        rng: 2 doubles per child are drawn.

    Returns:
        Children, same shape.

    Ref: S1 section III.A.
    """
    children, length = first.shape
    cuts = np.sort((rng.random((children, 2)) * (length + 1)).astype(np.int32), axis=1)
    place = np.arange(length, dtype=np.int32)
    taken = (place >= cuts[:, :1]) & (place < cuts[:, 1:])
    return np.where(taken, second, first)


def mutate(bits: Bits, rate: float, rng: np.random.Generator) -> Bits:
    """Invert each bit with the same chance.

    Args:
        bits: any shape.
        rate: chance per bit, 0 to 1.
        rng: one double per bit is drawn, also where `rate` is 0.

    Returns:
        A new array of the same shape.

    Ref: S1 section III.A.
    """
    return bits ^ (rng.random(bits.shape) < rate)


SELECTIONS: dict[str, Callable[[Fitness, int, np.random.Generator], NDArray[np.intp]]] = {
    "roulette": roulette,
}
CROSSOVERS: dict[str, Callable[[Bits, Bits, np.random.Generator], Bits]] = {
    "two-point": two_point,
}
