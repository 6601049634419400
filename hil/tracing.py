"""What the simulator's classifier compares, by running its plain Python with words that tell.

The classifier is what Numba compiles; here its Python runs, with a stand-in for each sensor's
word that can be compared and nothing else: whatever else is tried is refused. A comparison
comes out both ways, one run for each. A function that calls another goes on with each of the
values that the other may return, so every way through every function is among those run.
"""

import types
from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

from cgagen.errors import UnprovenError
from cgagen.robot import Robot, SituationCounts
from hil.criticals import Criticals
from sim.numbers import ReflexNumbers
from sim.world import PreyReading, Reading, answer_of_reading, state_of_reading

MOST_WAYS = 100_000
"""Through one function, for one set of arguments. Ref: choice."""


def classifier_criticals(robot: Robot, names: tuple[str, ...]) -> Criticals:
    """Return what the simulator compares to name the state of a reading; do not change it.

    Args:
        robot: its limits are the numbers.
        names: of the sensors with words, sonars first.

    Raises:
        UnprovenError: the classifier does something else with a word.
    """
    limits = robot.situation_counts if robot.limits else None
    masking = robot.limits.masking if robot.limits else False
    return _compared(names, limits, masking, 0 if limits else robot.alarm_count)


@cache
def _compared(
    names: tuple[str, ...], limits: SituationCounts | None, masking: bool, alarm: int
) -> Criticals:
    trace = Trace(names)
    words = [trace.word(number) for number in range(len(names))]
    for touched in ((a, b) for a in (False, True) for b in (False, True)):
        if limits is not None:
            front, right, left, *lights = words
            reading = Reading(front, right, left, *touched, *lights)  # type: ignore[arg-type]
            trace.follow(state_of_reading, reading, masking, limits)
        else:
            prey = PreyReading(*words, *touched)  # type: ignore[call-arg, arg-type]
            trace.follow(answer_of_reading, prey, _told_apart(alarm))
    return trace.criticals


def _told_apart(alarm: int) -> ReflexNumbers:
    """Return a reflex with a different answer for everything: no way looks like another."""
    return ReflexNumbers(alarm, (1, 2, 3, 4, 5, 6), 0, 7, 8, 9, 10)


class Trace:
    """Runs functions with words that may only be compared.

    Args:
        names: of the sensors.

    Attributes:
        criticals: what was compared so far.

    >>> trace = Trace(("sonar", "light"))
    >>> def nearer(a, b): return 1 if a < 7 else (2 if a <= b else 3)
    >>> trace.follow(nearer, trace.word(0), trace.word(1))
    {1, 2, 3}
    >>> trace.criticals
    Criticals(cuts={0: {7}}, pairs={(0, 1)})
    """

    def __init__(self, names: tuple[str, ...]) -> None:
        self.criticals = Criticals()
        self._names = names
        self._known: dict[tuple[object, ...], tuple[object, ...]] = {}
        self._rebound: dict[Callable[..., Any], Callable[..., Any]] = {}
        self._script: list[int] = []
        self._sizes: list[int] = []
        self._asked: dict[tuple[object, ...], bool] = {}

    def word(self, number: int) -> "Word":
        """Return the stand-in for a sensor's word."""
        return Word(self, number)

    def follow(self, function: Callable[..., Any], *arguments: object) -> set[object]:
        """Return what a function may return, whatever the words are.

        Raises:
            UnprovenError: it does something else with a word than compare it.
        """
        return set(self._outcomes(_plain(function), arguments))

    def compared(self, symbol: str, number: int, other: object) -> bool:
        """Note a comparison; returns how it comes out on this way."""
        if isinstance(other, Word):
            if other.number == number:
                return symbol in ("<=", ">=", "=")
            self.criticals.pair(number, other.number)
            key: tuple[object, ...] = (symbol, number, "word", other.number)
        elif isinstance(other, int):
            self.criticals.constant(number, symbol, other)
            key = (symbol, number, "number", other)
        else:
            raise UnprovenError(f"{self._names[number]} is compared with {other!r}, no number")
        if key not in self._asked:
            self._asked[key] = bool(self._choice(2))
        return self._asked[key]

    def _choice(self, size: int) -> int:
        """Return which of so many ways this run goes; it follows the script, then the first."""
        place = len(self._sizes)
        self._sizes.append(size)
        if place == len(self._script):
            self._script.append(0)
        return self._script[place]

    def _outcomes(
        self, plain: types.FunctionType, arguments: tuple[object, ...]
    ) -> tuple[object, ...]:
        key = (plain.__module__, plain.__qualname__, _key(arguments))
        if key not in self._known:
            outer = self._script, self._sizes, self._asked
            try:
                found = {_key(value): value for value in self._runs(plain, arguments)}
                self._known[key] = tuple(found.values())
            except TypeError as error:
                raise UnprovenError(
                    f"{plain.__name__} of the simulator does more than compare: {error}"
                ) from error
            finally:
                self._script, self._sizes, self._asked = outer
        return self._known[key]

    def _runs(self, plain: types.FunctionType, arguments: tuple[object, ...]) -> Iterator[object]:
        """Run a function once for each way through it."""
        function = self._with_calls(plain)
        script: list[int] = []
        for _ in range(MOST_WAYS):
            self._script, self._sizes, self._asked = script, [], {}
            yield function(*arguments)
            while script and script[-1] + 1 == self._sizes[len(script) - 1]:
                script.pop()
            if not script:
                return
            script[-1] += 1
        raise UnprovenError(f"{plain.__name__} of the simulator has more than {MOST_WAYS} ways")

    def _with_calls(self, plain: types.FunctionType) -> Callable[..., Any]:
        """Return a function whose calls of compiled functions are followed, too."""
        if plain not in self._rebound:
            names = {
                name: self._followed(value.py_func) if hasattr(value, "py_func") else value
                for name, value in plain.__globals__.items()
            }
            self._rebound[plain] = types.FunctionType(
                plain.__code__, names, plain.__name__, plain.__defaults__, plain.__closure__
            )
        return self._rebound[plain]

    def _followed(self, plain: types.FunctionType) -> Callable[..., Any]:
        def call(*arguments: object) -> object:
            found = self._outcomes(plain, arguments)
            return found[self._choice(len(found))] if len(found) > 1 else found[0]

        return call


class Word:
    """A word of which nothing is known: it can be compared, and nothing else."""

    __slots__ = ("_trace", "number")

    def __init__(self, trace: Trace, number: int) -> None:
        self._trace = trace
        self.number = number

    def __lt__(self, other: object) -> bool:
        return self._trace.compared("<", self.number, other)

    def __le__(self, other: object) -> bool:
        return self._trace.compared("<=", self.number, other)

    def __gt__(self, other: object) -> bool:
        return self._trace.compared(">", self.number, other)

    def __ge__(self, other: object) -> bool:
        return self._trace.compared(">=", self.number, other)

    def __eq__(self, other: object) -> bool:
        return self._trace.compared("=", self.number, other)

    def __ne__(self, other: object) -> bool:
        return self._trace.compared("<>", self.number, other)

    def __bool__(self) -> bool:
        return self._trace.compared("<>", self.number, 0)

    __hash__ = None  # type: ignore[assignment]


def _key(value: object) -> object:
    """Return what tells one value from another; words cannot be asked whether they are equal."""
    if isinstance(value, Word):
        return ("word", value.number)
    if isinstance(value, tuple):
        return tuple(_key(one) for one in value)
    return (type(value).__name__, value)


def _plain(function: Callable[..., Any]) -> types.FunctionType:
    plain = getattr(function, "py_func", function)
    if not isinstance(plain, types.FunctionType):
        raise UnprovenError(f"{function!r} has no Python to follow")
    return plain
