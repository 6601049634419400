"""How each module is asked who it is, what it answers, and what its loader wants afterwards.

Where no other source stands, the bytes are those of bs2-serial 0.15.0 (Parallax's own programmer
in JavaScript), stampbc 2.1 and bstamp (two loaders written from Parallax's sheet on the
protocol), which agree. None of them has been compared with silicon by us.
"""

from collections.abc import Iterable
from dataclasses import dataclass

from cgagen.stamp.chips import CHIPS, Chip, chip


@dataclass(frozen=True, slots=True)
class Package:
    """The answers of one package of a model: `first` is version 1.0, the next 1.1, and so on.

    Attributes:
        pins: of the module, 24 or 40.
        first: the lowest answer.
        last: the highest known one.
    """

    pins: int
    first: int
    last: int


@dataclass(frozen=True, slots=True)
class Calling:
    """How a model is called.

    Attributes:
        model: its row.
        greeting: challenge and answer, byte by byte, before the one that asks for the version.
        version: the challenge that asks for the version.
        packages: what it answers to that; empty where the answer is two decimal digits.
    """

    model: Chip
    greeting: tuple[tuple[int, int], ...]
    version: int
    packages: tuple[Package, ...]

    @property
    def takes_slot(self) -> bool:
        """A byte with the number of the program slot comes before the packets."""
        return self.model.slots > 1


CALLINGS: tuple[Calling, ...] = (
    Calling(chip("BS2"), ((0x42, 0xBE), (0x53, 0xAD), (0x32, 0xCE)), 0x00, ()),
    Calling(chip("BS2e"), (), 0x65, (Package(24, 0x65, 0x67),)),
    Calling(chip("BS2sx"), (), 0x58, (Package(24, 0x58, 0x5B),)),
    Calling(chip("BS2p"), (), 0x50, (Package(24, 0x70, 0x77), Package(40, 0x50, 0x57))),
    Calling(chip("BS2pe"), (), 0x49, (Package(24, 0x69, 0x6D), Package(40, 0x49, 0x4D))),
)
"""In the order in which an unknown module is asked. The BS2 comes first for a second reason: it
answers 256 less the challenge, so that a line that echoes twice shows itself."""

if tuple(calling.model for calling in CALLINGS) != CHIPS:
    raise AssertionError("every model has its calling")


@dataclass(frozen=True, slots=True)
class Module:
    """A module that has answered.

    Attributes:
        model: its row.
        pins: 24 or 40.
        version: of its interpreter, such as "1.0".
    """

    model: Chip
    pins: int
    version: str

    @property
    def name(self) -> str:
        """The module as Parallax sells it; only the BS2p and BS2pe exist in both packages.

        >>> module_of(calling_of(chip("BS2p")), 0x74).name
        'BS2p24'
        """
        both = len(calling_of(self.model).packages) > 1
        return f"{self.model.name}{self.pins}" if both else self.model.name


def calling_of(model: Chip) -> Calling:
    """Return how a model is called."""
    return CALLINGS[CHIPS.index(model)]


def callings_from(likely: Iterable[Chip]) -> tuple[Calling, ...]:
    """Return all callings in their order, those of likely models before the others.

    >>> [calling.model.name for calling in callings_from([chip("BS2p"), chip("BS2")])]
    ['BS2', 'BS2p', 'BS2e', 'BS2sx', 'BS2pe']
    """
    names = {model.name for model in likely}
    return tuple(sorted(CALLINGS, key=lambda calling: calling.model.name not in names))


def module_of(calling: Calling, answer: int) -> Module | None:
    """Return the module that gives this answer for a version; None where none does.

    >>> module_of(calling_of(chip("BS2")), 0x10)
    ... # doctest: +ELLIPSIS
    Module(model=Chip(name='BS2', ...), pins=24, version='1.0')
    """
    if not calling.packages:
        whole, part = divmod(answer, 16)
        return Module(calling.model, 24, f"{whole}.{part}") if 0 < whole < 10 > part else None
    for package in calling.packages:
        if package.first <= answer <= package.last:
            return Module(calling.model, package.pins, f"1.{answer - package.first}")
    return None
