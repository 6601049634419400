"""What a decision depends on: numbers that a reading is compared with, and readings compared.

A decider that does nothing with its readings but compare them decides the same for any two
stimuli of which all these comparisons say the same. Both deciders, the image and the simulator,
are asked for theirs (`hil.dataflow`, `hil.tracing`); the union divides the sensor space.
"""

from dataclasses import dataclass, field

LARGEST = 0xFFFF
"""Of a word."""


@dataclass
class Criticals:
    """The comparisons that a decider may make, gathered.

    Attributes:
        cuts: by sensor, each `c` such that a count below `c` may be told from one at `c`.
        pairs: sensors whose counts are compared, the smaller number first.
    """

    cuts: dict[int, set[int]] = field(default_factory=dict)
    pairs: set[tuple[int, int]] = field(default_factory=set)

    def constant(self, sensor: int, symbol: str, value: int) -> None:
        """Note a comparison of a sensor's count with a number.

        Args:
            sensor: its number.
            symbol: `<`, `>`, `<=`, `>=`, `=` or `<>`, the sensor on the left.
            value: the number.

        >>> seen = Criticals()
        >>> seen.constant(0, "<", 1843); seen.constant(0, "=", 0); seen.constant(0, "<=", 65535)
        >>> seen.cuts
        {0: {1, 1843}}
        """
        both = symbol in ("=", "<>")
        found = set()
        if both or symbol in ("<", ">="):
            found.add(value)
        if both or symbol in ("<=", ">"):
            found.add(value + 1)
        self.cuts.setdefault(sensor, set()).update(cut for cut in found if 0 < cut <= LARGEST)

    def pair(self, first: int, second: int) -> None:
        """Note a comparison of two sensors' counts."""
        if first != second:
            self.pairs.add((min(first, second), max(first, second)))

    def add(self, other: "Criticals") -> None:
        """Take in what another decider compares."""
        for sensor, cuts in other.cuts.items():
            self.cuts.setdefault(sensor, set()).update(cuts)
        self.pairs |= other.pairs
