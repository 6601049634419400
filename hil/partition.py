"""The sensor space, divided into finitely many cells in which every decider decides alike.

Sensors that are compared with one another, directly or through others, make a group with one
row of critical numbers; these divide the words into intervals. Which interval each sensor of a
group is in, and the order (with ties) of those in the same interval, is a cell of the group.
Two stimuli of one cell agree in every comparison with a critical number and in every
comparison of two sensors of a group: in different intervals the intervals decide, in the same
one the order does. A cell of the space is one cell of each group, and a position of the antennas.
"""

from collections.abc import Sequence
from functools import cache, cached_property
from itertools import product
from math import comb, prod

from hil.criticals import LARGEST, Criticals

Counts = tuple[int, ...]


class Group:
    """Sensors that are compared with one another.

    Args:
        sensors: their numbers.
        cuts: every `c` such that a count below `c` may be told from one at `c`.
        largest: the largest count.

    Attributes:
        sensors: see above.
        intervals: first and last count of each.
    """

    def __init__(self, sensors: Sequence[int], cuts: set[int], largest: int = LARGEST) -> None:
        self.sensors = tuple(sensors)
        starts = sorted({0} | {cut for cut in cuts if 0 < cut <= largest})
        ends = [start - 1 for start in starts[1:]] + [largest]
        self.intervals = tuple(zip(starts, ends, strict=True))

    @cached_property
    def cells(self) -> tuple[Counts, ...]:
        """A representative of each cell, counts in the order of `sensors`."""
        return _representatives(len(self.sensors), self.intervals)

    def counted(self) -> int:
        """Return how many cells there are, by a formula instead of the list.

        For every distribution of the sensors over the intervals: the ways to distribute them,
        times the weak orders within each interval, of at most as many levels as it has counts.
        """
        sizes = [last - first + 1 for first, last in self.intervals]
        ways = [1] + [0] * len(self.sensors)
        for size in sizes:
            ways = [
                sum(
                    ways[others] * comb(total, others) * weak_orders(total - others, size)
                    for others in range(total + 1)
                )
                for total in range(len(self.sensors) + 1)
            ]
        return ways[-1]

    def cell_of(self, counts: Sequence[int]) -> tuple[tuple[int, int], ...]:
        """Return which cell counts are in: interval, and rank in it, of each sensor."""
        inside = [
            next(n for n, (first, last) in enumerate(self.intervals) if first <= count <= last)
            for count in counts
        ]
        return tuple(
            (
                interval,
                len(
                    {c for c, i in zip(counts, inside, strict=True) if i == interval and c < count}
                ),
            )
            for count, interval in zip(counts, inside, strict=True)
        )

    def like(self, counts: Sequence[int]) -> Counts:
        """Return the representative of the cell that counts are in."""
        cell = self.cell_of(counts)
        top = {interval: 0 for interval, _ in cell}
        for interval, rank in cell:
            top[interval] = max(top[interval], rank)
        return tuple(
            _count(self.intervals[interval], rank, top[interval], at_end=interval % 2 == 0)
            for interval, rank in cell
        )


class Partition:
    """All cells of a sensor space.

    Args:
        sensors: how many words there are.
        criticals: what any decider compares them with.
        antennas: positions of the antennas.
        largest: the largest count.

    Attributes:
        groups: of sensors that are compared with one another.
    """

    def __init__(
        self,
        sensors: int,
        criticals: Criticals,
        antennas: Sequence[tuple[bool, ...]],
        largest: int = LARGEST,
    ) -> None:
        self._sensors = sensors
        self._antennas = tuple(antennas)
        self.groups = tuple(
            Group(
                members,
                set().union(*(criticals.cuts.get(sensor, set()) for sensor in members)),
                largest,
            )
            for members in joined(sensors, criticals.pairs)
        )
        self._size = len(self._antennas) * prod(group.counted() for group in self.groups)

    def __len__(self) -> int:
        """Return how many cells there are; none is listed yet."""
        return self._size

    def __getitem__(self, index: int) -> tuple[Counts, tuple[bool, ...]]:
        """Return the counts and the antennas of the representative of a cell."""
        if not 0 <= index < len(self):
            raise IndexError(index)
        index, antenna = divmod(index, len(self._antennas))
        counts = [0] * self._sensors
        for group in self.groups:
            index, cell = divmod(index, len(group.cells))
            for sensor, count in zip(group.sensors, group.cells[cell], strict=True):
                counts[sensor] = count
        return tuple(counts), self._antennas[antenna]


def joined(sensors: int, pairs: set[tuple[int, int]]) -> tuple[tuple[int, ...], ...]:
    """Return the groups of sensors that pairs join.

    >>> joined(5, {(0, 1), (1, 2)})
    ((0, 1, 2), (3,), (4,))
    """
    group = list(range(sensors))
    for first, second in sorted(pairs):
        old, new = group[second], group[first]
        group = [new if one == old else one for one in group]
    return tuple(
        tuple(n for n in range(sensors) if group[n] == one) for one in dict.fromkeys(group)
    )


@cache
def rankings(things: int, levels: int) -> tuple[tuple[int, ...], ...]:
    """Return the weak orders of some things: the rank of each, 0 up, no rank left out.

    >>> rankings(2, 65000), rankings(2, 1)
    (((0, 0), (0, 1), (1, 0)), ((0, 0),))
    """
    top = min(things, levels)
    return tuple(
        ranks
        for ranks in product(range(top), repeat=things)
        if set(ranks) == set(range(max(ranks) + 1))
    )


@cache
def weak_orders(things: int, levels: int) -> int:
    """Return how many weak orders of so many levels at most there are.

    >>> [weak_orders(n, 9) for n in range(7)], weak_orders(3, 2)
    ([1, 1, 3, 13, 75, 541, 4683], 7)
    """
    if things == 0:
        return 1
    return (
        sum(
            comb(things, lowest) * weak_orders(things - lowest, levels - 1)
            for lowest in range(1, things + 1)
        )
        if levels
        else 0
    )


@cache
def _representatives(sensors: int, intervals: tuple[tuple[int, int], ...]) -> tuple[Counts, ...]:
    """Return counts in each cell of a group."""
    found = []
    for inside in product(range(len(intervals)), repeat=sensors):
        members = {i: [n for n, j in enumerate(inside) if j == i] for i in sorted(set(inside))}
        sizes = {i: intervals[i][1] - intervals[i][0] + 1 for i in members}
        ranks = (rankings(len(names), sizes[i]) for i, names in members.items())
        for chosen in product(*ranks):
            counts = [0] * sensors
            for (i, names), ranking in zip(members.items(), chosen, strict=True):
                for name, rank in zip(names, ranking, strict=True):
                    counts[name] = _count(intervals[i], rank, max(ranking), at_end=i % 2 == 0)
            found.append(tuple(counts))
    return tuple(found)


def _count(interval: tuple[int, int], rank: int, top: int, at_end: bool) -> int:
    """Return a count for a rank: the highest at the interval's end, the others at its start.

    A single level lies where `at_end` says.
    """
    first, last = interval
    return last if (rank == top if top else at_end) else first + rank
