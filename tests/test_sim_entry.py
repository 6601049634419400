"""What is handed to compiled code: its shape, type and numbers are looked at first."""

import numpy as np
import pytest

from cgagen.robot import load_arena, load_robot
from sim.episode import play_episode, play_recorded, visits_of
from sim.model import World, words_of

NAN = float("nan")


@pytest.fixture(scope="module")
def world() -> World:
    robots = load_robot("servobot-predator"), load_robot("servobot-prey")
    return World(*robots, load_arena("colony"), steps=20)


@pytest.fixture(scope="module")
def starts(world):
    return world.draw_starts(np.random.Generator(np.random.Philox(key=1)), 5)


def genomes(count: int = 3):
    rng = np.random.Generator(np.random.Philox(key=2))
    return (rng.random((count, 192)) < 0.5).astype(np.uint8)


@pytest.mark.parametrize(
    ("bits", "words"),
    [
        (np.zeros((3, 191), np.uint8), r"shape \(n, 192\), not \(3, 191\)"),
        (np.zeros(192, np.uint8), r"not \(192,\)"),
        (np.zeros((2, 3, 192), np.uint8), r"not \(2, 3, 192\)"),
        (np.full((3, 192), 2, np.uint8), "bits 0 and 1"),
        (np.full((3, 192), -1), "bits 0 and 1"),
        (np.full((3, 192), 0.5), "bits 0 and 1"),
        (np.full((3, 192), NAN), "bits 0 and 1"),
        (np.full((3, 192), "0"), "bits 0 and 1"),
        (np.zeros((0, 192), np.uint8), "nobody plays"),
    ],
)
def test_populations_that_are_none(world, starts, bits, words) -> None:
    with pytest.raises(ValueError, match=words):
        world.evaluate(bits, starts)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda s: s[:, :7], r"shape \(S, 8\), not \(5, 7\)"),
        (lambda s: s[0], r"not \(8,\)"),
        (lambda s: np.where(s == s[2, 1], NAN, s), "a number that is none"),
        (lambda s: np.where(s == s[2, 1], np.inf, s), "a number that is none"),
        (lambda s: s * 2, "no unit vector"),
        (lambda s: s.astype(str), "of <U"),
        (lambda s: s.astype(complex), "of complex"),
        (lambda s: s[:0], "from nowhere"),
    ],
)
def test_starts_that_are_none(world, starts, change, words) -> None:
    with pytest.raises(ValueError, match=words):
        world.evaluate(genomes(), change(starts))
    if len(change(starts)):
        with pytest.raises(ValueError, match=words):
            play_recorded(words_of(genomes())[:, 0], change(starts), 5, world.numbers)


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (np.zeros((2, 3), np.int64), r"shape \(3, n\), not int64 of \(2, 3\)"),
        (np.zeros((3, 2)), "not float64"),
        (np.zeros((3, 2), np.int32), "not int32"),
        (np.zeros(3, np.int64), r"not \(3,\)"),
        (np.zeros((), np.int64), r"int64 of \(\)"),
    ],
)
def test_words_that_are_none(world, starts, words, sentence) -> None:
    with pytest.raises(ValueError, match=sentence):
        world.play(words, starts)


@pytest.mark.parametrize("steps", [0, -1, 2.5, True, "9"])
def test_steps_that_are_none(world, starts, steps) -> None:
    word = words_of(genomes())[:, 0]
    with pytest.raises(ValueError, match="1 step or more"):
        play_episode(word, starts[:1], steps, world.numbers)
    with pytest.raises(ValueError, match="1 step or more"):
        visits_of(word, starts, steps, world.numbers)
    robots = load_robot("servobot-predator"), load_robot("servobot-prey")
    with pytest.raises(ValueError, match="1 step or more"):
        World(*robots, load_arena("colony"), steps=steps)


def test_one_genome_and_one_start_are_recorded(world, starts) -> None:
    words = words_of(genomes())
    with pytest.raises(ValueError, match="one genome and one start"):
        play_recorded(words, starts[:1], 5, world.numbers)
    with pytest.raises(ValueError, match="one genome and one start"):
        play_recorded(words[:, 0], starts, 5, world.numbers)


def test_arrays_that_lie_otherwise_in_memory_give_the_same_bits(world, starts) -> None:
    bits = genomes(4)
    wanted = world.evaluate(bits, starts)
    wide = np.zeros((4, 384), np.uint8)
    wide[:, ::2] = bits
    for one in (wide[:, ::2], np.asfortranarray(bits), bits.astype(bool), bits.astype(np.int64)):
        found = world.evaluate(one, np.asfortranarray(starts))
        assert found.fitness.tolist() == wanted.fitness.tolist()
        assert found.captured.tolist() == wanted.captured.tolist()
    back = world.evaluate(bits, starts[::-1])
    assert sorted(back.captured) == sorted(wanted.captured)
