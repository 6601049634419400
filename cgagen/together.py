"""Options that do not go together: rules as data, and the sentence for the first that is broken.

An option that another one takes the place of, or that has no effect without another one, is
refused before anything is done. Otherwise a user who names two things is told of one of them, and
believes it of both.
"""

from collections.abc import Collection, Iterable
from typing import NamedTuple

EXCLUDED = "{first} and {second} exclude each other; leave one out"


class Apart(NamedTuple):
    """Two options that exclude each other.

    Attributes:
        first: as a user types it, `--for`; with a word of its own, `--port emu`.
        second: likewise.
        told: the sentence, with both in their places.
    """

    first: str
    second: str
    told: str = EXCLUDED

    @property
    def options(self) -> tuple[str, ...]:
        """All that the rule speaks of."""
        return self.first, self.second

    def broken(self, given: Collection[str]) -> str:
        """Return the sentence about what was given; "" where the rule holds."""
        if self.first not in given or self.second not in given:
            return ""
        return self.told.format(first=self.first, second=self.second)


class Needs(NamedTuple):
    """An option that has no effect without another one.

    Attributes:
        option: see `Apart`.
        others: one of these has to be there.
    """

    option: str
    others: tuple[str, ...]

    @property
    def options(self) -> tuple[str, ...]:
        """All that the rule speaks of."""
        return self.option, *self.others

    def broken(self, given: Collection[str]) -> str:
        """Return the sentence about what was given; "" where the rule holds."""
        if self.option not in given or any(one in given for one in self.others):
            return ""
        return f"{self.option} is for {' or '.join(self.others)}; give both"


class Together(NamedTuple):
    """Options that say one thing only if all of them are there.

    Attributes:
        options: see `Apart`.
    """

    options: tuple[str, ...]

    def broken(self, given: Collection[str]) -> str:
        """Return the sentence about what was given; "" where the rule holds."""
        if len(set(self.options) & set(given)) in (0, len(self.options)):
            return ""
        names = f"{', '.join(self.options[:-1])} and {self.options[-1]}"
        return f"{names} belong together; give all of them"


Rule = Apart | Needs | Together


def apart(firsts: Iterable[str], seconds: Iterable[str], told: str = EXCLUDED) -> tuple[Apart, ...]:
    """Return the rules by which each of some options excludes each of some others.

    >>> [one.options for one in apart(["--a"], ["--b", "--c"])]
    [('--a', '--b'), ('--a', '--c')]
    """
    others = tuple(seconds)
    return tuple(Apart(first, second, told) for first in firsts for second in others)


def among(options: Iterable[str], told: str = EXCLUDED) -> tuple[Apart, ...]:
    """Return the rules by which each of some options excludes all the others of them.

    >>> [one.options for one in among(["--a", "--b", "--c"])]
    [('--a', '--b'), ('--a', '--c'), ('--b', '--c')]
    """
    names = tuple(options)
    pairs = ((one, two) for at, one in enumerate(names) for two in names[at + 1 :])
    return tuple(Apart(one, two, told) for one, two in pairs)


def trouble(rules: Iterable[Rule], given: Collection[str]) -> str:
    """Return the sentence for the first rule that is broken; "" where none is.

    Args:
        rules: in the order in which they are looked at.
        given: options that a user has typed; one with a value also with that, `--port emu`.

    >>> trouble([Apart("--for", "--until-end")], {"--for", "--until-end"})
    '--for and --until-end exclude each other; leave one out'
    >>> trouble([Needs("--kills", ("--report",))], {"--kills"})
    '--kills is for --report; give both'
    >>> trouble([Needs("--kills", ("--report",))], {"--kills", "--report"})
    ''
    """
    return next((words for rule in rules if (words := rule.broken(given))), "")
