"""Mutants of a generated PBASIC program: one plausible slip each, named by kind and line.

What a generator, its templates or a robot's file could get wrong is listed as data: operators
that are taken for each other, constants that are off by one, rows and statements in the wrong
order, pins, indices and labels that are another's, and lines that are missing. Comments and
texts are left alone, so nearly every mutant compiles.
"""

import random
import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

SEED = 4
"""Of the choice among all mutants of a kind."""

COMPARISONS = {"<": ("<=", ">"), ">": (">=", "<"), "=": ("<>",), "<>": ("=",)}
OPERATORS = {"+": "-", "-": "+", "*": "+", "//": "/", "&": "|", "MAX": "MIN"}
LOGIC = {"AND": "OR", "OR": "AND"}
ABSENT = ""
"""What a lost line leaves."""

_STRING = re.compile(r'"[^"\n]*"')
_DATA = re.compile(r"^(\w*)[ \t]+DATA[ \t]+(.*)$")
_PIN = re.compile(r"^(\w+)([ \t]+PIN[ \t]+)(\d+)$")
_CONSTANT = re.compile(r"^(\w+)([ \t]+CON[ \t]+)(\d+)$")
_LIMIT = re.compile(r"^(Echo\w+(Near|Middle|Far)|Lamp\w+|Alarm)$")
_LABEL = re.compile(r"^(\w+):$")
_NUMBER = re.compile(r"(?<![\w%])\d+\b|(?<=HEX)\d\b")
_BINARY = re.compile(r"%([01]+)")
_BLOCK = re.compile(r"^(IF\b.*THEN|ELSEIF\b.*|ELSE|ENDIF|FOR\b.*|NEXT|RETURN)$")
_INDEX = re.compile(r"\b(\w+)\((\w+)\)|\.BIT(\d)")


@dataclass(frozen=True, slots=True, order=True)
class Mutant:
    """One change of a source.

    Attributes:
        kind: of slip.
        line: the first line that is changed, from 1.
        before: the line or lines as they are, without comments at their ends.
        after: what stands there instead.
    """

    kind: str
    line: int
    before: str
    after: str

    def apply(self, source: str) -> str:
        """Return the changed source; it has as many lines as before."""
        lines = source.split("\n")
        count = self.before.count("\n") + 1
        lines[self.line - 1 : self.line - 1 + count] = self.after.split("\n")
        return "\n".join(lines)

    def text(self) -> str:
        """Return the change in one line, for people and for lists.

        >>> Mutant("comparison", 7, "  IF a < b THEN", "  IF a > b THEN").text()
        'comparison: IF a < b THEN -> IF a > b THEN'
        """
        before, after = (
            " | ".join(" ".join(part.split()) for part in text.split("\n"))
            for text in (self.before, self.after)
        )
        return f"{self.kind}: {before} -> {after or '(nothing)'}"


@dataclass(frozen=True, slots=True)
class _Line:
    """A line of a source: number, code without comment, and the code with its texts blanked."""

    number: int
    code: str
    bare: str


def all_mutants(source: str) -> tuple[Mutant, ...]:
    """Return every mutant of a source, sorted; the same source gives the same."""
    lines = [_line(number, text) for number, text in enumerate(source.split("\n"), 1)]
    return tuple(sorted(set(_mutants(lines))))


def choose(mutants: tuple[Mutant, ...], number: int, seed: int = SEED) -> tuple[Mutant, ...]:
    """Return so many mutants, all kinds in turn as long as they last, sorted.

    >>> some = tuple(Mutant("a", line, "", "") for line in range(9)) + (Mutant("b", 1, "", ""),)
    >>> [one.kind for one in choose(some, 4)]
    ['a', 'a', 'a', 'b']
    """
    chance = random.Random(seed)
    piles: dict[str, list[Mutant]] = {}
    for mutant in mutants:
        piles.setdefault(mutant.kind, []).append(mutant)
    for kind in sorted(piles):
        chance.shuffle(piles[kind])
    chosen: list[Mutant] = []
    while len(chosen) < number and any(piles.values()):
        for kind in sorted(piles):
            if piles[kind] and len(chosen) < number:
                chosen.append(piles[kind].pop())
    return tuple(sorted(chosen))


def _line(number: int, text: str) -> _Line:
    blanked = _STRING.sub(lambda found: '"' + "\0" * (len(found[0]) - 2) + '"', text)
    length = len(blanked.partition("'")[0].rstrip())
    return _Line(number, text[:length], blanked[:length])


def _mutants(lines: list[_Line]) -> Iterator[Mutant]:
    code = [line for line in lines if line.code]
    labels = [found[1] for line in code if (found := _LABEL.match(line.bare))]
    pins = [found[1] for line in code if (found := _PIN.match(line.bare))]
    for line in code:
        if _DATA.match(line.bare):
            yield from _of_data(line)
        elif found := _PIN.match(line.bare):
            for value in (int(found[3]) - 1, int(found[3]) + 1):
                yield _changed(line, "pin", *found.span(3), str(value % 16))
        elif found := _CONSTANT.match(line.bare):
            kind = "threshold" if _LIMIT.match(found[1]) else "constant"
            for value in (int(found[3]) - 1, int(found[3]) + 1):
                if value >= 0:
                    yield _changed(line, kind, *found.span(3), str(value))
        elif line.code.startswith(" "):
            yield from _of_statement(line, labels, pins)
    yield from _swapped_rows(code)
    yield from _swapped_statements(lines)
    yield from _swapped_tests(code)


def _changed(line: _Line, kind: str, start: int, end: int, new: str) -> Mutant:
    return Mutant(kind, line.number, line.code, line.code[:start] + new + line.code[end:])


def _of_data(line: _Line) -> Iterator[Mutant]:
    """Every value of a table, off by one."""
    head = line.bare.index("DATA") + 4
    for place, found in enumerate(_NUMBER.finditer(line.bare, head)):
        value = int(found[0])
        other = (value + 1) % 8 if value < 8 else value + (1 if place % 2 else -1)
        yield _changed(line, "table", *found.span(), str(other))


def _of_statement(line: _Line, labels: list[str], pins: list[str]) -> Iterator[Mutant]:
    yield from _words(line)
    for found in _NUMBER.finditer(line.bare):
        for value in (int(found[0]) - 1, int(found[0]) + 1):
            if value >= 0:
                yield _changed(line, "constant", *found.span(), str(value))
    for found in _BINARY.finditer(line.bare):
        kind = "masking" if "masked" in line.bare else "constant"
        for at in range(*found.span(1)):
            flipped = "10"[int(line.bare[at])]
            yield _changed(line, kind, at, at + 1, flipped)
    yield from _names(line, "label", labels, r"\b(?:GOSUB|GOTO|THEN|Time,)\s+(\w+)")
    yield from _names(line, "pin", pins, r"\b(\w+)\b")
    yield from _indices(line)
    if not _BLOCK.match(line.bare.strip()):
        kind = "masking" if "masked" in line.bare else "lost line"
        yield Mutant(kind, line.number, line.code, ABSENT)


def _words(line: _Line) -> Iterator[Mutant]:
    """Operators taken for each other; the = of an assignment is none."""
    tests = line.bare.rpartition("THEN")[0] if re.match(r"\s*(ELSE)?IF\b", line.bare) else ""
    for found in re.finditer(r"<>|<=|>=|[<>=]", tests):
        for other in COMPARISONS.get(found[0], ()):
            yield _changed(line, "comparison", *found.span(), other)
    for found in re.finditer(r"\b(AND|OR)\b", tests):
        yield _changed(line, "logic", *found.span(), LOGIC[found[0]])
    for found in re.finditer(r"(?<= )(//|[-+*&]|MAX)(?= )", line.bare):
        yield _changed(line, "operator", *found.span(), OPERATORS[found[0]])
    for found in re.finditer(r"\b(LOW|HIGH|INPUT)\b", line.bare):
        other = {"LOW": "HIGH", "HIGH": "LOW", "INPUT": "LOW"}[found[0]]
        yield _changed(line, "pin", *found.span(), other)
    for found in re.finditer(r'"[\0]"', line.bare):
        letter = line.code[found.start() + 1]
        yield _changed(line, "constant", *found.span(), f'"{chr(ord(letter) + 1)}"')


def _names(line: _Line, kind: str, names: list[str], pattern: str) -> Iterator[Mutant]:
    """A name of a list taken for the one before it or behind it."""
    for found in re.finditer(pattern, line.bare):
        if found[1] in names:
            at = names.index(found[1])
            for other in {names[at - 1], names[(at + 1) % len(names)]} - {found[1]}:
                yield _changed(line, kind, *found.span(1), other)


_NEIGHBOURS = {
    "Front": "Right",
    "Right": "Left",
    "Left": "0",
    "FrontLeft": "FrontRight",
    "FrontRight": "FrontLeft",
    "RearLeft": "RearRight",
    "RearRight": "Left",
}


def _indices(line: _Line) -> Iterator[Mutant]:
    for found in _INDEX.finditer(line.bare):
        if found[3]:
            yield _changed(line, "index", *found.span(3), str(1 - int(found[3])))
        elif found[2].isdigit():
            yield _changed(line, "index", *found.span(2), str((int(found[2]) + 1) % 4))
        elif found[2] in _NEIGHBOURS:
            yield _changed(line, "index", *found.span(2), _NEIGHBOURS[found[2]])


def _swapped_rows(code: list[_Line]) -> Iterator[Mutant]:
    """Neighbouring rows of a table; the label stays where it is."""
    for first, second in pairwise(code):
        if not (_DATA.match(first.bare) and _DATA.match(second.bare)):
            continue
        at, to = (line.bare.index("DATA") + 4 for line in (first, second))
        if first.code[at:].strip() != second.code[to:].strip() and second.code.startswith(" "):
            before = _range_text(first, second)
            after = f"{first.code[:at]}{second.code[to:]}\n{second.code[:to]}{first.code[at:]}"
            yield Mutant("rows", first.number, before, after)


def _swapped_statements(lines: list[_Line]) -> Iterator[Mutant]:
    for first, second in pairwise(lines):
        simple = all(
            line.code.startswith("  ")
            and not line.code.endswith(",")
            and not _DATA.match(line.bare)
            and not _BLOCK.match(line.bare.strip())
            for line in (first, second)
        )
        if simple and _indent(first) == _indent(second):
            before = _range_text(first, second)
            yield Mutant("order", first.number, before, f"{second.code}\n{first.code}")


def _swapped_tests(code: list[_Line]) -> Iterator[Mutant]:
    """Conditions of an IF and its ELSEIF, each with what follows the other."""
    for at, second in enumerate(code):
        if not second.bare.strip().startswith("ELSEIF"):
            continue
        opened = re.compile(rf"^ {{{_indent(second)}}}(ELSE)?IF\b")
        first = next(line for line in reversed(code[:at]) if opened.match(line.bare))
        tests = [re.search(r"IF (.*) THEN", line.code) for line in (first, second)]
        if not all(tests):
            continue
        one, two = (found[1] for found in tests if found)
        span = code[code.index(first) : at + 1]
        texts = {line.number: line.code for line in span}
        after = {
            **texts,
            first.number: first.code.replace(one, two),
            second.number: second.code.replace(two, one),
        }
        numbers = range(first.number, second.number + 1)
        before_text, after_text = (
            "\n".join(table.get(number, "") for number in numbers) for table in (texts, after)
        )
        yield Mutant("order", first.number, before_text, after_text)


def _range_text(first: _Line, second: _Line) -> str:
    gap = [""] * (second.number - first.number - 1)
    return "\n".join([first.code, *gap, second.code])


def _indent(line: _Line) -> int:
    return len(line.code) - len(line.code.lstrip())
