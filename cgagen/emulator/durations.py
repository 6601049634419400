"""How long the labelled routines of a program take, in the chip's own time.

A routine that GOSUB calls lasts from its first instruction until the program is back behind the
GOSUB, whatever it calls or jumps to in between. A label that is reached in any other way lasts
until the program reaches a label again, be it the same one: calls made in between belong to it.
So `Main:` at the head of a loop is measured pass by pass. A label that jumps to itself inside its
own call is one call. What has not ended is not counted, and neither is a call whose way back was
lost (a fifth GOSUB, RUN, a reset).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from cgagen.emulator.machine import GOSUB_LEVELS, Machine
from cgagen.stamp.symbols import Symbols


class Duration(NamedTuple):
    """What one routine took.

    Attributes:
        label: as the source spells it.
        slot: of its program.
        called: by GOSUB; otherwise it was reached by a jump or by running on.
        times: how often it ended.
        best_ns: the shortest.
        mean_ns: all of them together by `times`, rounded.
        worst_ns: the longest.
    """

    label: str
    slot: int
    called: bool
    times: int
    best_ns: int
    mean_ns: int
    worst_ns: int


Place = tuple[int, str, bool]
"""Slot, label and whether it was called."""


@dataclass(slots=True)
class _Open:
    place: Place
    began_ns: int


@dataclass(slots=True)
class _Level:
    """The main program, or one call of it.

    Attributes:
        call: of which routine; None for the main program, and for a call of no label.
        part: the label that was reached last on this level otherwise.
    """

    call: _Open | None = None
    part: _Open | None = None


class Durations:
    """Notes when routines begin and end; `cgagen.emulator.chip.Chip.durations` makes one.

    Args:
        symbols: the names of the programs, by slot.
        labels: those wanted, in any case; none for all.

    Attributes:
        end: ends the measurement; what was measured stays.
    """

    def __init__(self, symbols: Mapping[int, Symbols], labels: Sequence[str] = ()) -> None:
        wanted = {label.strip().lower() for label in labels}
        all_labels = [
            ((slot, bit), label)
            for slot, names in symbols.items()
            for label, bit in names.labels.items()
        ]
        # Of several labels at one place, one that is wanted gives the name.
        self._labels = dict(sorted(all_labels, key=lambda row: row[1] in wanted))
        self._wanted = wanted or set(self._labels.values())
        self._symbols = symbols
        self._levels = [_Level()]
        self._took: dict[Place, list[int]] = {}
        self._before = ""
        self._slot = 0
        self._life: object = None
        self.end: Callable[[], None] = lambda: None

    def rows(self) -> tuple[Duration, ...]:
        """Return what was measured so far, by slot and in the order of the source."""
        order = {(slot, label): bit for (slot, bit), label in self._labels.items()}
        places = sorted(self._took, key=lambda place: (place[0], order[place[:2]], place[2]))
        return tuple(
            Duration(
                self._symbols[slot].spelled[label],
                slot,
                called,
                count,
                best,
                (2 * total + count) // (2 * count),
                worst,
            )
            for slot, label, called in places
            for count, total, best, worst in [self._took[slot, label, called]]
        )

    def note(self, machine: Machine, now_ns: int) -> None:
        """Take note of an instruction that is about to begin."""
        place = (machine.slot, machine.pc)
        # A reset and a return to a snapshot make the polling table anew, and nothing else does.
        if machine.polling is not self._life or machine.slot != self._slot:
            self._levels = [_Level()]
            self._life, self._slot, self._before = machine.polling, machine.slot, ""
        elif self._before == "RETURN":
            self._return(now_ns)
        label = self._labels.get(place)
        if self._before == "GOSUB":
            self._call(label, now_ns)
        elif label is not None:
            self._reach(label, now_ns)
        self._before = machine.memory.slots[machine.slot].at(machine.pc).name

    def _call(self, label: str | None, now_ns: int) -> None:
        call = None if label is None else _Open((self._slot, label, True), now_ns)
        self._levels.append(_Level(call))
        if len(self._levels) > GOSUB_LEVELS + 1:
            del self._levels[1]

    def _return(self, now_ns: int) -> None:
        if len(self._levels) == 1:  # nothing to return to: the program begins anew
            self._levels = [_Level()]
            return
        level = self._levels.pop()
        for open_one in (level.part, level.call):
            if open_one is not None:
                self._end(open_one, now_ns)

    def _reach(self, label: str, now_ns: int) -> None:
        level = self._levels[-1]
        if len(self._levels) > 1 and level.call is None and level.part is None:
            level.call = _Open((self._slot, label, True), now_ns)  # ON .. GOSUB came here
            return
        if level.part is not None:
            self._end(level.part, now_ns)
            level.part = None
        if level.call is None or level.call.place[1] != label:
            level.part = _Open((self._slot, label, False), now_ns)

    def _end(self, one: _Open, now_ns: int) -> None:
        if one.place[1] not in self._wanted:
            return
        took_ns = now_ns - one.began_ns
        known = self._took.setdefault(one.place, [0, 0, took_ns, took_ns])
        known[0] += 1
        known[1] += took_ns
        known[2] = min(known[2], took_ns)
        known[3] = max(known[3], took_ns)


def durations_text(rows: Sequence[Duration]) -> str:
    """Return a table of what was measured, in microseconds.

    >>> print(durations_text([Duration("walk", 0, True, 3, 1_000, 2_500, 12_000_000)]))
    label slot reached times best_us mean_us  worst_us
    walk     0 GOSUB       3   1.000   2.500 12000.000
    """
    cells: list[tuple[str, ...]] = [
        ("label", "slot", "reached", "times", "best_us", "mean_us", "worst_us")
    ]
    for row in rows:
        times = (f"{ns // 1000}.{ns % 1000:03d}" for ns in row[4:])
        reached = "GOSUB" if row.called else "jump"
        cells.append((row.label, str(row.slot), reached, str(row.times), *times))
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    left = (0, 2)
    return "\n".join(
        " ".join(
            cell.ljust(width) if number in left else cell.rjust(width)
            for number, (cell, width) in enumerate(zip(line, widths, strict=True))
        ).rstrip()
        for line in cells
    )
