"""Repeated measurements of one quantity."""

import math
from collections.abc import Sequence
from typing import NamedTuple

OUTLIER_DEVIATIONS = 6.0
"""A value so many median deviations away from the others' median is pointed out. Choice."""

FEWEST_FOR_OUTLIERS = 4
"""Among fewer values nobody can say which one is wrong. Choice."""


class Sample(NamedTuple):
    """What is kept of repeated measurements.

    Attributes:
        mean: of all of them.
        spread: their standard deviation (n - 1); None of a single one.
        repeats: how many.
    """

    mean: float
    spread: float | None
    repeats: int

    def mark(self, date: str = "") -> str:
        """Return the comment that goes behind the number in a robot file.

        >>> Sample(7.4, 0.125, 5).mark("4 May")
        'measured: mean of 5, spread 0.12, 4 May'
        >>> Sample(7.4, None, 1).mark()
        'measured: once'
        """
        if self.spread is None:
            words = "measured: once"
        else:
            words = f"measured: mean of {self.repeats}, spread {self.spread:.2g}"
        return f"{words}, {date}" if date else words


def sample(values: Sequence[float]) -> Sample:
    """Return mean and spread of at least one value.

    >>> sample([1.0, 2.0, 3.0])
    Sample(mean=2.0, spread=1.0, repeats=3)
    """
    count = len(values)
    mean = math.fsum(values) / count
    if count == 1:
        return Sample(mean, None, 1)
    squares = math.fsum((value - mean) ** 2 for value in values)
    return Sample(mean, math.sqrt(squares / (count - 1)), count)


def outliers(values: Sequence[float], grain: float) -> list[int]:
    """Return the indexes of values that are far from all the others.

    Args:
        values: repeats of one quantity.
        grain: how well it can be read at all; deviations are counted as no less than this.

    >>> outliers([7.4, 7.5, 7.5, 7.6, 2.1], 0.1), outliers([7.4, 7.5, 2.1], 0.1)
    ([4], [])
    """
    if len(values) < FEWEST_FOR_OUTLIERS:
        return []
    middle = _median(values)
    deviation = max(_median([abs(value - middle) for value in values]), grain)
    far = OUTLIER_DEVIATIONS * deviation
    return [index for index, value in enumerate(values) if abs(value - middle) > far]


def _median(values: Sequence[float]) -> float:
    ordered, half = sorted(values), len(values) // 2
    return ordered[half] if len(values) % 2 else (ordered[half - 1] + ordered[half]) / 2
