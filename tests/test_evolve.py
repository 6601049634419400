"""The genetic algorithm on bits alone: its operators, their chances, and that it learns."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cgagen.evolve import (
    Settings,
    first_generation,
    mutate,
    next_generation,
    roulette,
    two_point,
)


def generator(seed=1):
    return np.random.Generator(np.random.Philox(key=seed))


def chi_square(counts, expected):
    return float(((counts - expected) ** 2 / expected).sum())


def test_it_learns_to_count_the_ones():
    settings = Settings(population=64, bits=48, mutation_rate=0.001)
    rng = generator()
    bits = first_generation(settings, rng)
    start = bits.mean()
    for _ in range(60):
        fitness = np.maximum(bits.sum(axis=1) - 16.0, 0.0) ** 2  # raw roulette needs contrast
        bits = next_generation(bits, fitness, settings, rng)
    assert abs(start - 0.5) < 0.05
    assert bits.mean() > 0.9


@given(seed=st.integers(0, 2**32), elite=st.integers(0, 5))
def test_shape_type_and_values_stay(seed, elite):
    settings = Settings(population=6, bits=21, mutation_rate=0.1, elite=elite)
    rng = generator(seed)
    bits = first_generation(settings, rng)
    after = next_generation(bits, bits.sum(axis=1).astype(float), settings, rng)
    assert after.shape == bits.shape
    assert after.dtype == np.uint8
    assert set(np.unique(after)) <= {0, 1}


@given(seed=st.integers(0, 2**32))
def test_each_child_is_a_piece_of_one_parent_in_the_other(seed):
    """Parents of all 0 and all 1 show where each bit comes from."""
    first, second = np.zeros((20, 30), np.uint8), np.ones((20, 30), np.uint8)
    for child in two_point(first, second, generator(seed)):
        assert np.abs(np.diff(np.concatenate([[0], child, [0]]).astype(int))).sum() in (0, 2)


@given(seed=st.integers(0, 2**32))
def test_without_mutation_bits_come_from_the_population(seed):
    settings = Settings(population=5, bits=12, mutation_rate=0.0)
    rng = generator(seed)
    bits = first_generation(settings, rng)
    bits[:, 3], bits[:, 7] = 0, 1
    after = next_generation(bits, np.ones(5), settings, rng)
    assert not after[:, 3].any()
    assert after[:, 7].all()


def test_every_pair_of_cut_points_is_possible_and_both_are_uniform():
    """Of bits + 1 places each has the same chance, so does each unordered pair of two."""
    length, children = 4, 50_000
    first, second = np.zeros((children, length), np.uint8), np.ones((children, length), np.uint8)
    crossed = two_point(first, second, generator())
    codes = crossed @ (1 << np.arange(length))
    counts = {code: int((codes == code).sum()) for code in set(codes.tolist())}
    # 25 ordered pairs of places: 5 are empty pieces, each other piece comes from two pairs.
    pieces = [sum(1 << k for k in range(a, b)) for a in range(5) for b in range(a + 1, 5)]
    assert set(counts) == {0, *pieces}
    observed = np.array([counts[0], *(counts[piece] for piece in pieces)])
    expected = children * np.array([5, *[2] * len(pieces)]) / 25
    assert chi_square(observed, expected) < 29.6  # 10 degrees of freedom, p = 0.001


def test_selection_is_proportional_to_fitness():
    fitness = np.array([0.0, 1.0, 2.0, 3.0, 0.0, 4.0, 0.0])
    drawn = np.bincount(roulette(fitness, 100_000, generator()), minlength=len(fitness))
    assert drawn[[0, 4, 6]].sum() == 0
    turning = fitness > 0
    expected = 100_000 * fitness[turning] / fitness.sum()
    assert chi_square(drawn[turning], expected) < 16.3  # 3 degrees of freedom, p = 0.001


@pytest.mark.parametrize("value", [0.0, 3.5])
def test_equal_fitness_gives_equal_chances(value):
    drawn = np.bincount(roulette(np.full(8, value), 80_000, generator()), minlength=8)
    assert chi_square(drawn, np.full(8, 10_000.0)) < 24.3  # 7 degrees of freedom, p = 0.001


@pytest.mark.parametrize("bad", [-1e-300, np.nan, np.inf, -np.inf, 1e308])
def test_a_fitness_that_is_no_sector_is_refused(bad):
    with pytest.raises(ValueError, match="fitness"), np.errstate(over="ignore"):
        roulette(np.array([1.0, bad, 1e308, 2.0]), 3, generator())


def test_tiny_fitness_still_draws_inside():
    assert roulette(np.array([0.0, 5e-324, 0.0]), 50, generator()).tolist() == [1] * 50


def test_both_parents_are_drawn_for_each_child():
    """With two different individuals a quarter of the pairs is each of the four."""
    settings = Settings(population=4_000, bits=2, mutation_rate=0.0)
    bits = np.zeros((4_000, 2), np.uint8)
    bits[2_000:] = 1
    after = next_generation(bits, np.ones(4_000), settings, generator())
    mixed = (after[:, 0] != after[:, 1]).mean()
    # One piece of 2 bits is cut from 3 places: 4 of 9 ordered pairs leave one bit to each parent.
    assert abs(mixed - 0.5 * 4 / 9) < 0.03


def test_mutation_inverts_at_its_rate():
    bits = first_generation(Settings(population=500, bits=1_000), generator())
    flipped = mutate(bits, 0.003, generator(2)) != bits
    assert abs(flipped.sum() - 1_500) < 4 * np.sqrt(1_500)
    assert np.array_equal(mutate(bits, 0.0, generator()), bits)
    assert np.array_equal(mutate(bits, 1.0, generator()), 1 - bits)


def test_the_papers_rate_is_about_one_and_a_half_bits_a_generation():
    settings = Settings()
    zeros = np.zeros((settings.population, settings.bits), np.uint8)
    rng = generator()
    flips = [int(mutate(zeros, settings.mutation_rate, rng).sum()) for _ in range(200)]
    assert abs(np.mean(flips) - 1.47) < 0.35


def test_the_elite_passes_unchanged_ties_by_index():
    settings = Settings(population=6, bits=40, mutation_rate=0.5, elite=3)
    bits = first_generation(settings, generator())
    after = next_generation(bits, np.array([1.0, 5.0, 2.0, 5.0, 2.0, 0.0]), settings, generator())
    assert np.array_equal(after[:3], bits[[1, 3, 2]])


def test_no_elite_by_default():
    assert Settings() == Settings(256, 192, 3e-5, "roulette", "two-point", 0)


def test_the_same_generator_gives_the_same_bits_as_ever():
    """Pinned: a change here changes every run that anybody has made."""
    settings = Settings(population=8, bits=16, mutation_rate=0.05)
    rng = generator(2008)
    bits = first_generation(settings, rng)
    after = next_generation(bits, np.arange(1.0, 9.0), settings, rng)
    assert [int("".join(map(str, row)), 2) for row in bits.tolist()] == FIRST
    assert [int("".join(map(str, row)), 2) for row in after.tolist()] == SECOND


FIRST = [61674, 28733, 28855, 46292, 50495, 19509, 18996, 28094]
SECOND = [28094, 19505, 19509, 26686, 19509, 18997, 28727, 50495]


@pytest.mark.parametrize(
    "change",
    [
        {"population": 1},
        {"bits": 0},
        {"mutation_rate": -0.1},
        {"mutation_rate": float("nan")},
        {"selection": "rank"},
        {"crossover": "one-point"},
        {"elite": -1},
        {"elite": 256},
    ],
)
def test_settings_that_cannot_be_are_refused(change):
    with pytest.raises(ValueError, match=next(iter(change))):
        Settings(**change)


def test_arrays_that_do_not_fit_are_refused():
    settings = Settings(population=4, bits=8)
    bits = first_generation(settings, generator())
    with pytest.raises(ValueError, match="shape"):
        next_generation(bits[:3], np.ones(4), settings, generator())
    with pytest.raises(ValueError, match="fitness"):
        next_generation(bits, np.ones(3), settings, generator())
