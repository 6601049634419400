"""Tables of a bench file."""

from typing import Any, ClassVar

from cgagen.errors import BenchError, CgagenError
from cgagen.shown import shown
from cgagen.tables import Table

LONGEST_US = 1e9
"""A thousand seconds: longer than any setting of a part makes sense."""


class BenchTable(Table):
    """One table of a bench file; it raises `BenchError`."""

    REFUSAL: ClassVar[type[CgagenError]] = BenchError

    def number_or(self, key: str, low: float, high: float, default: float) -> float:
        """Return a number, or `default` where the key is not there."""
        return self.number(key, low, high) if self.offers(key) else default

    def integer_or(self, key: str, low: int, high: int, default: int) -> int:
        """Return a whole number likewise."""
        return self.integer(key, low, high) if self.offers(key) else default

    def flag_or(self, key: str, default: bool) -> bool:
        """Return true or false likewise."""
        return self.flag(key) if self.offers(key) else default

    def either(self, one: str, other: str) -> str | None:
        """Return which of two keys is there, of which only one can be; None for neither."""
        given = [key for key in (one, other) if self.offers(key)]
        if len(given) > 1:
            raise self.error(other, f"says the same thing as {one}; leave one of them out")
        return given[0] if given else None

    def nanoseconds(self, key: str) -> int | None:
        """Return a duration or time whose key ends in _us or _ms; None where it is not there."""
        if not self.offers(key):
            return None
        unit_ns = 1_000_000 if key.endswith("_ms") else 1_000
        return round(self.number(key, 0, LONGEST_US * 1_000 / unit_ns) * unit_ns)

    def numbers(self, key: str, low: float, high: float) -> list[float]:
        """Return a list of finite numbers from `low` to `high`."""
        wanted = f"a list of numbers from {low:g} to {high:g}"
        value: Any = self.take(key, wanted)
        if not isinstance(value, list):
            raise self.error(key, f"{value!r} is not {wanted}")
        return [self._in_range(key, one, low, high) for one in value]

    def texts(self, key: str, wanted: str) -> list[str]:
        """Return a list of texts; `wanted` says in words what they are."""
        value: Any = self.take(key, wanted)
        if not isinstance(value, list) or not all(isinstance(one, str) for one in value):
            raise self.error(key, f"{shown(value)} is not {wanted}")
        return value
