"""The proof over the whole sensor space: no cell is missed, and the trace that finds them."""

import random
from collections.abc import Callable
from itertools import combinations, product

import pytest

from cgagen.emulator.chip import Chip
from cgagen.emulator.clock import Clock
from cgagen.errors import UnprovenError
from hil.criticals import Criticals
from hil.followed import POSITIONS
from hil.partition import Group, Partition, joined
from hil.tracing import Trace
from tests.proof_cases import questions


def small_criticals(dice: random.Random, sensors: int, largest: int) -> Criticals:
    """Critical numbers and pairs of a small space, by chance."""
    criticals = Criticals()
    for sensor in range(sensors):
        for _ in range(dice.randrange(3)):
            symbol = dice.choice(("<", "<=", ">", ">=", "=", "<>"))
            criticals.constant(sensor, symbol, dice.randrange(largest + 1))
    for pair in combinations(range(sensors), 2):
        if dice.random() < 0.6:
            criticals.pair(*pair)
    return criticals


def comparisons(criticals: Criticals, counts: tuple[int, ...]) -> tuple[object, ...]:
    """All that a decider may know of some counts."""
    numbers = [counts[n] >= cut for n, cuts in sorted(criticals.cuts.items()) for cut in cuts]
    pairs = [(counts[a] < counts[b], counts[a] == counts[b]) for a, b in sorted(criticals.pairs)]
    return (*numbers, *pairs)


@pytest.mark.parametrize("seed", range(25))
def test_every_point_of_a_small_space_is_decided_like_its_cell(seed: int) -> None:
    """All points, told apart by the comparisons themselves: each way has a cell, and one way."""
    dice = random.Random(seed)
    sensors, largest = (4, 5) if seed % 2 else (3, 7)
    criticals = small_criticals(dice, sensors, largest)
    partition = Partition(sensors, criticals, [()], largest)
    cells = [partition[cell][0] for cell in range(len(partition))]
    assert all(0 <= count <= largest for counts in cells for count in counts)
    named = {name_of(partition, counts): comparisons(criticals, counts) for counts in cells}
    assert len(named) == len(cells), "two representatives of one cell"
    for point in product(range(largest + 1), repeat=sensors):
        assert named[name_of(partition, point)] == comparisons(criticals, point)
    points = product(range(largest + 1), repeat=sensors)
    assert {name_of(partition, point) for point in points} == set(named), "an empty cell"


def name_of(partition: Partition, counts: tuple[int, ...]) -> tuple[object, ...]:
    """Which cell some counts are in."""
    return tuple(
        group.cell_of([counts[sensor] for sensor in group.sensors]) for group in partition.groups
    )


@pytest.mark.parametrize("seed", range(10))
def test_the_number_of_cells_is_the_formula(seed: int) -> None:
    dice = random.Random(seed)
    cuts = {dice.randrange(1, 12) for _ in range(dice.randrange(5))}
    group = Group(range(dice.randrange(1, 6)), cuts, largest=dice.randrange(1, 12))
    assert len(group.cells) == len(set(group.cells)) == group.counted()


def test_groups_are_joined_through_others() -> None:
    assert joined(4, {(2, 3), (0, 3), (0, 1)}) == ((0, 1, 2, 3),)
    assert joined(3, set()) == ((0,), (1,), (2,))


def test_any_reading_is_decided_like_its_cell() -> None:
    """The same for the images themselves, with readings by chance."""
    dice = random.Random(7)
    for question in questions().values():
        partition = question.partition
        listed = [set(group.cells) for group in partition.groups]
        for _ in range(1500):
            common = dice.randrange(65_536)
            counts = [
                dice.choice((common, dice.randrange(65_536), dice.randrange(8_000), 0, 65_535))
                for _ in question.places.words
            ]
            like = counts.copy()
            for group, cells in zip(partition.groups, listed, strict=True):
                cell = group.like([counts[sensor] for sensor in group.sensors])
                assert cell in cells
                for sensor, count in zip(group.sensors, cell, strict=True):
                    like[sensor] = count
            touched = dice.choice((POSITIONS[0], *POSITIONS))
            decided = question.decide(tuple(counts), touched)
            assert decided == question.decide(tuple(like), touched), (counts, like)


@pytest.mark.parametrize("role", ["predator", "prey"])
def test_a_chip_with_its_clock_decides_the_same(role: str) -> None:
    """The routine called without a bench, against the whole emulated chip."""
    question, dice = questions()[role], random.Random(8)
    places, image = question.places, question.subject.images["main"]
    chip = Chip("main", [image], Clock())
    chip.machine.pc = places.entry
    chip.machine.gosubs[:] = [places.call]
    chip.on_address(places.stop, lambda stopped: stopped.clock.stop())
    counted = chip.cover().counts
    start, now = chip.snapshot(), chip.clock.state()
    for _ in range(500):
        counts, touched = question.partition[dice.randrange(len(question.partition))]
        chip.clock.restore(now)
        chip.restore(start)
        for word, count in zip(places.words, counts, strict=True):
            chip.registers.write(16, word, count)
        for bit, bent in zip(places.antennas, touched, strict=True):
            chip.registers.write(1, bit, not bent)
        chip.run(1_000_000_000)
        assert chip.pc == places.stop
        observed = question.decide(counts, touched)
        assert observed is not None
        assert observed[1] == chip.pins.latch & 7
    # All that was carried out had been followed, and no more.
    assert {address for _, address in counted} - {places.stop} == question.visited


def traced(function: Callable[..., object]) -> tuple[set[object], Criticals]:
    trace = Trace(("a", "b", "c"))
    found = trace.follow(function, *(trace.word(n) for n in range(3)))
    return found, trace.criticals


def test_the_trace_takes_every_way() -> None:
    def decide(a: int, b: int, c: int) -> int:
        least = a if a < b else b
        if least == 0:
            return 1
        return 2 if 9 <= least and least != c else (3 if b > 20 else 4)

    found, criticals = traced(decide)
    assert found == {1, 2, 3, 4}
    assert criticals.cuts == {0: {1, 9}, 1: {1, 9, 21}}
    assert criticals.pairs == {(0, 1), (0, 2), (1, 2)}


REFUSED: list[Callable[..., object]] = [
    lambda a, b, c: a + 1,
    lambda a, b, c: 5 - b,
    lambda a, b, c: a & 1,
    lambda a, b, c: (1, 2, 3)[c],
    lambda a, b, c: int(a),
    lambda a, b, c: -a < b,
    lambda a, b, c: range(a),
    lambda a, b, c: {a: 1},
]
"""Functions that do more with a word than compare it."""


@pytest.mark.parametrize("function", REFUSED)
def test_the_trace_refuses_all_but_comparisons(function: Callable[..., object]) -> None:
    with pytest.raises(UnprovenError, match="more than compare"):
        traced(function)


def test_the_trace_refuses_to_compare_with_what_is_no_number() -> None:
    with pytest.raises(UnprovenError, match=r"a is compared with 1\.5, no number"):
        traced(lambda a, b, c: a < 1.5)


def test_a_word_is_equal_to_itself() -> None:
    trace = Trace(("a",))
    word, same = trace.word(0), trace.word(0)
    assert word == same
    assert word <= same
    assert not word < same
