"""A TOML table that is read once, key by key, and refuses what it does not know.

Every refusal is one sentence with the file, the table, the key and what is allowed.
"""

import difflib
import math
from typing import Any, ClassVar, Self

from cgagen.errors import CgagenError
from cgagen.notations import parse_toml
from cgagen.shown import LONGEST_MESSAGE, short, shown


class Table:
    """One table of a file. Take its keys, then call `done()`.

    Each kind of file has a class of its own, whose `REFUSAL` is the error that it raises.

    >>> table = Table("mine.toml", "sonar.front", {"pin": 4, "cone": 60})
    >>> table.integer("pin", 0, 15)
    4
    >>> table.done()
    Traceback (most recent call last):
    ...
    cgagen.errors.CgagenError: mine.toml: [sonar.front] cone: no such key; known here: pin
    """

    REFUSAL: ClassVar[type[CgagenError]] = CgagenError

    def __init__(self, file: str, path: str, content: dict[str, Any]) -> None:
        self.file = file
        self.path = path
        self._content = content
        self._known: list[str] = []

    @classmethod
    def parse(cls, file: str, text: str) -> Self:
        """Parse a whole file.

        Raises:
            CgagenError: it is not TOML; the sentence names the line.
        """
        try:
            return cls(file, "", parse_toml(text))
        except ValueError as error:
            raise cls.REFUSAL(f"{file}: not TOML: {error}") from error

    def error(self, key: str, sentence: str) -> CgagenError:
        """Return (not raise) a refusal of one key of this table."""
        where = f"[{self.path}] {key}" if self.path else key
        # A key may hold any character, and any number of them.
        whole = f"{self.file}: {short(where, 120)}: {sentence}"
        return self.REFUSAL(short(whole, LONGEST_MESSAGE).replace("\n", r"\n"))

    def take(self, key: str, kind: str) -> Any:
        """Return a key's value, whatever it is; `kind` says in words what is wanted."""
        self._known.append(key)
        if key not in self._content:
            raise self.error(key, f"missing; wanted {kind}")
        return self._content[key]

    def has(self, key: str) -> bool:
        """Say whether the key is there."""
        return key in self._content

    def offers(self, key: str) -> bool:
        """Say likewise, of a key that may be left out."""
        self._known.append(key)
        return key in self._content

    def number(self, key: str, low: float, high: float) -> float:
        """Return a finite number from `low` to `high`, both allowed."""
        return self._in_range(key, self.take(key, f"a number from {low:g} to {high:g}"), low, high)

    def integer(self, key: str, low: int, high: int) -> int:
        """Return a whole number from `low` to `high`, both allowed."""
        value = self.take(key, f"a whole number from {low} to {high}")
        return self._whole(key, value, low, high)

    def integers(self, key: str, count: int, low: int, high: int) -> tuple[int, ...]:
        """Return a list of exactly `count` whole numbers."""
        wanted = f"a list of {count} whole numbers from {low} to {high}"
        value = self.take(key, wanted)
        if not isinstance(value, list) or len(value) != count:
            raise self.error(key, f"{shown(value)} is not {wanted}")
        return tuple(self._whole(key, one, low, high) for one in value)

    def pair(self, key: str, low: float, high: float) -> tuple[float, float]:
        """Return two numbers, the first less than the second."""
        wanted = f"two rising numbers from {low:g} to {high:g}"
        value = self.take(key, wanted)
        if not isinstance(value, list) or len(value) != 2:
            raise self.error(key, f"{shown(value)} is not {wanted}")
        first, second = (self._in_range(key, one, low, high) for one in value)
        if not first < second:
            raise self.error(key, f"{shown(value)} is not {wanted}")
        return first, second

    def text(self, key: str, allowed: tuple[str, ...] | None = None) -> str:
        """Return a text, one of `allowed` where that is given."""
        wanted = f"one of {', '.join(allowed)}" if allowed else "a text"
        value = self.take(key, wanted)
        if not isinstance(value, str) or not value or (allowed and value not in allowed):
            raise self.error(key, f"{shown(value)} is not {wanted}")
        return value

    def flag(self, key: str) -> bool:
        """Return true or false."""
        value = self.take(key, "true or false")
        if not isinstance(value, bool):
            raise self.error(key, f"{shown(value)} is not true or false")
        return value

    def table(self, key: str) -> Self:
        """Return the table under a key."""
        value = self.take(key, f"a table [{self._under(key)}]")
        if not isinstance(value, dict):
            raise self.error(key, f"{shown(value)} is not a table [{self._under(key)}]")
        return type(self)(self.file, self._under(key), value)

    def tables(self, key: str) -> list[Self]:
        """Return the tables of an array `[[key]]`, each named by its `name` or its number."""
        value = self.take(key, f"tables [[{self._under(key)}]]")
        if not isinstance(value, list) or not all(isinstance(one, dict) for one in value):
            raise self.error(key, f"wanted tables [[{self._under(key)}]]")
        return [
            type(self)(self.file, f"{self._under(key)}.{one.get('name', number)}", one)
            for number, one in enumerate(value, start=1)
        ]

    def keys(self) -> list[str]:
        """Return the keys that the file has here, in its order."""
        return list(self._content)

    def done(self) -> None:
        """Refuse keys that nobody asked for.

        Raises:
            CgagenError: the first such key, with the likeliest one meant.
        """
        for key in self._content:
            if key not in self._known:
                near = difflib.get_close_matches(key, self._known, n=1)
                hint = f"did you mean {near[0]}?" if near else f"known here: {self._names()}"
                raise self.error(key, f"no such key; {hint}")

    def _names(self) -> str:
        return ", ".join(dict.fromkeys(self._known)) or "none"

    def _under(self, key: str) -> str:
        return f"{self.path}.{key}" if self.path else key

    def _in_range(self, key: str, value: object, low: float, high: float) -> float:
        number = value if isinstance(value, int | float) and not isinstance(value, bool) else None
        if number is None or not math.isfinite(number) or not low <= number <= high:
            raise self.error(key, f"{shown(value)} is not a number from {low:g} to {high:g}")
        return float(number)

    def _whole(self, key: str, value: object, low: int, high: int) -> int:
        if not isinstance(value, int) or isinstance(value, bool) or not low <= value <= high:
            raise self.error(key, f"{shown(value)} is not a whole number from {low} to {high}")
        return value
