"""Routines: what lies between two labels, what it calls, and how deep the calls nest.

The graph is read from the source. A jump is every label that a statement names, so time-out
labels of SERIN and the table of BRANCH are in it. Where it cannot know, it assumes that a way
is taken: the depth may come out too large, never too small. It does not see what another
program slot does (RUN, POLLRUN), nor a program that rewrites itself.
"""

import re
from dataclasses import dataclass, field

from cgagen.stamp.compiled import Compiled
from cgagen.stamp.scan import START, Label, Piece, blanked, labels_of, pieces_of

_ENDS = frozenset({"GOTO", "RETURN", "END", "STOP", "RUN"})
"""Statements that nothing follows. Ref: S2 chapter 5."""

_BLOCK_IF = re.compile(r"\bTHEN[ \t]*[\r\n]", re.IGNORECASE)
"""An IF with nothing behind its THEN is closed by ENDIF; any other ends with its line."""

_OPENS = {"FOR": "NEXT", "DO": "LOOP", "SELECT": "ENDSELECT", "IF": "ENDIF"}


@dataclass(slots=True)
class Routine:
    """The statements from one label to the next.

    Attributes:
        name: the label.
        line: its line, from 1.
        bits: bits of the program that they take.
        calls: labels that are reached by GOSUB.
        ways: labels that are reached by a jump, or by running on.
    """

    name: str
    line: int
    bits: int = 0
    calls: set[str] = field(default_factory=set)
    ways: set[str] = field(default_factory=set)


def routines_of(compiled: Compiled) -> tuple[Routine, ...]:
    """Return the routines of a program in source order, the first being its start.

    The last one's bits hold the END that every program gets, and the last byte's padding.
    """
    code = blanked(compiled.source)
    labels = (Label(START, 0), *labels_of(code))
    pieces = pieces_of(compiled, code, labels)
    groups = _by_label(labels, pieces)
    routines = tuple(Routine(label.name, 1 + _lines_before(code, label.offset)) for label in labels)
    _measure(compiled, routines, groups)
    _connect(routines, groups)
    # A program that begins with a label has nothing before it.
    return routines[1:] if not groups[0] and len(routines) > 1 else routines


def nesting(routines: tuple[Routine, ...]) -> tuple[str, ...] | None:
    """Return the longest chain of calls, from the start; None where a routine calls itself.

    The chain has one name more than calls: ("Main", "Walk", "Pulse") is two deep.
    """
    by_name = {routine.name.upper(): routine for routine in routines}
    known: dict[str, tuple[str, ...]] = {}

    def chain(name: str, above: frozenset[str]) -> tuple[str, ...] | None:
        if name in above:
            return None
        if name not in known:
            longest: tuple[str, ...] = ()
            for callee in sorted(_callees(name, by_name)):
                below = chain(callee, above | {name})
                if below is None:
                    return None
                longest = max(longest, below, key=len)
            known[name] = (by_name[name].name, *longest)
        return known[name]

    return chain(routines[0].name.upper(), frozenset())


def _callees(name: str, by_name: dict[str, Routine]) -> set[str]:
    """Return whom a routine calls, and whom the code calls that it jumps to or runs into."""
    seen: set[str] = set()
    waiting = [name]
    while waiting:
        place = waiting.pop()
        if place not in seen:
            seen.add(place)
            waiting += by_name[place].ways
    return {callee for place in seen for callee in by_name[place].calls}


def _lines_before(code: str, offset: int) -> int:
    return len(code[:offset].replace("\r\n", "\n").replace("\r", "\n").split("\n")) - 1


def _by_label(labels: tuple[Label, ...], pieces: tuple[Piece, ...]) -> list[list[Piece]]:
    groups: list[list[Piece]] = [[] for _ in labels]
    index = 0
    for piece in pieces:
        while index + 1 < len(labels) and labels[index + 1].offset <= piece.statement.offset:
            index += 1
        groups[index].append(piece)
    return groups


def _measure(compiled: Compiled, routines: tuple[Routine, ...], groups: list[list[Piece]]) -> None:
    end = compiled.program_bytes * 8
    for routine, group in zip(reversed(routines), reversed(groups), strict=True):
        if group:
            routine.bits = end - group[0].statement.bit
            end = group[0].statement.bit


def _connect(routines: tuple[Routine, ...], groups: list[list[Piece]]) -> None:
    names = {routine.name.upper() for routine in routines[1:]}
    open_blocks: list[tuple[str, str]] = []  # (word that closes it, routine that opened it)
    for index, (routine, group) in enumerate(zip(routines, groups, strict=True)):
        for piece in group:
            targets = names.intersection(piece.words)
            (routine.calls if "GOSUB" in piece.words else routine.ways).update(targets)
            _nest(piece, routine, open_blocks)
        if index + 1 < len(routines) and (open_blocks or not _stops(group)):
            routine.ways.add(routines[index + 1].name.upper())


def _nest(piece: Piece, routine: Routine, open_blocks: list[tuple[str, str]]) -> None:
    word = piece.words[0] if piece.words else ""
    if open_blocks and word == open_blocks[-1][0]:
        _, opener = open_blocks.pop()
        if word in ("NEXT", "LOOP"):
            routine.ways.add(opener.upper())
    elif word in _OPENS and (word != "IF" or _BLOCK_IF.search(piece.text)):
        open_blocks.append((_OPENS[word], routine.name))


def _stops(group: list[Piece]) -> bool:
    """Tell whether the last statement of a routine never goes on, whatever happened before."""
    return bool(group) and group[-1].starts_line and group[-1].words[0] in _ENDS
