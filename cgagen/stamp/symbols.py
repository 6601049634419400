"""The names of a program: variables, pins, constants, DATA and labels, and where each of them is.

The tokenizer reports no names, so the source is read here, and what was read is compared with
what the tokenizer says of the same source: as many variables of each size, the very bytes that
are DATA. Where that differs, nothing is claimed.
"""

import difflib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from cgagen.errors import SymbolError
from cgagen.stamp.compiled import Compiled, VariableCounts
from cgagen.stamp.conditional import live_text
from cgagen.stamp.constants import NotUnderstoodError
from cgagen.stamp.data import DataBlock, data_of
from cgagen.stamp.decode import decode
from cgagen.stamp.definitions import Definition, constants_of, definitions_of
from cgagen.stamp.layout import FIXED, SIZES, Place, place_in, places_of
from cgagen.stamp.scan import Label, blanked, labels_of

PINS = 16

_MOST_SHOWN = 12


@dataclass(frozen=True)
class Symbols:
    """What the names of one program mean. Names are in lower case; lookups take any case.

    Attributes:
        name: of the source.
        variables: where each is in the register file, aliases included.
        pins: the number of each PIN.
        constants: the value of each CON.
        data: DATA blocks by label; None where they cannot be told apart.
        labels: stream bit of the first instruction behind each label.
        spelled: each of those names as the source has it, by the name in lower case.
    """

    name: str
    variables: Mapping[str, Place]
    pins: Mapping[str, int]
    constants: Mapping[str, int]
    data: Mapping[str, DataBlock] | None
    labels: Mapping[str, int]
    spelled: Mapping[str, str]

    def place(self, text: str) -> Place:
        """Return where a variable is, written as a program writes it.

        A PIN is the bit of INS that a program reads by its name.

        Args:
            text: `count`, `count.LOWBYTE`, `row(2)`; also a fixed name (`W0`, `OUTS`, `IN3`).

        Raises:
            SymbolError: there is no such variable; the nearest names.
        """
        places = {name: Place(1, pin, 1) for name, pin in self.pins.items()} | dict(self.variables)
        found = place_in(places, text)
        if found is None:
            raise self.unknown(text, "variable", [*places, *map(str.lower, FIXED)], [*places])
        return found

    def pin(self, name: str) -> int:
        """Return the number of a pin: a PIN, a CON that is used as one, or `P3`.

        Raises:
            SymbolError: there is no such pin; the nearest names.
        """
        low = name.strip().lower()
        known = {f"p{pin}": pin for pin in range(PINS)} | dict(self.constants) | dict(self.pins)
        if not 0 <= known.get(low, PINS) < PINS:
            raise self.unknown(name, "pin", [*self.pins, *known], [*self.pins])
        return known[low]

    def block(self, label: str) -> DataBlock:
        """Return a DATA block.

        Raises:
            SymbolError: there is none of that label, or they cannot be told apart.
        """
        if self.data is None:
            raise SymbolError(
                f"{self.name}: its DATA could not be told apart by label; read the EEPROM by number"
            )
        if label.strip().lower() not in self.data:
            raise self.unknown(label, "DATA label", self.data, self.data)
        return self.data[label.strip().lower()]

    def label(self, name: str) -> int:
        """Return the stream bit of the first instruction behind a label.

        Raises:
            SymbolError: there is no such label; the nearest names.
        """
        if name.strip().lower() not in self.labels:
            raise self.unknown(name, "label", self.labels, self.labels)
        return self.labels[name.strip().lower()]

    def unknown(
        self, text: str, kind: str, near: Iterable[str], shown: Iterable[str]
    ) -> SymbolError:
        """Return the sentence that says what a program does not have, and what is like it."""
        close = difflib.get_close_matches(text.strip().lower(), dict.fromkeys(near), n=3)
        words = [self.spelled.get(word, word) for word in close]
        names = [self.spelled.get(word, word) for word in dict.fromkeys(shown)]
        if words:
            hint = f"did you mean {' or '.join(words)}?"
        else:
            more = ", ..." if len(names) > _MOST_SHOWN else ""
            hint = f"there are {', '.join(names[:_MOST_SHOWN]) or 'none'}{more}"
        return SymbolError(f"{self.name}: no {kind} {text.strip()}; {hint}")


def symbols_of(compiled: Compiled) -> Symbols:
    """Return the names of a program.

    Raises:
        SymbolError: the source could not be read as the tokenizer read it.
    """
    try:
        code = live_text(compiled.source)
        definitions, labels = list(definitions_of(code)), list(labels_of(blanked(code)))
        constants = constants_of(definitions)
        blocks = data_of(compiled)
        addresses = {block.name.upper(): block.address for block in blocks or ()}
        places = places_of(definitions, addresses | constants)
    except NotUnderstoodError as error:
        raise _unread(compiled, f"{error} is not understood") from error
    counted = _counted(definitions, places)
    if counted != compiled.variables:
        raise _unread(compiled, f"{counted} were found where it has {compiled.variables}")
    kinds = {one.name.upper(): one.kind for one in definitions}
    values = {name: value for name, value in constants.items() if name in kinds}
    names = [one.name for one in definitions] + [one.name for one in labels]
    return Symbols(
        name=compiled.name,
        variables=places,
        pins={name.lower(): n for name, n in values.items() if kinds[name] == "PIN"},
        constants={name.lower(): n for name, n in values.items() if kinds[name] == "CON"},
        data=None if blocks is None else {block.name.lower(): block for block in blocks},
        labels=_bits(compiled, labels),
        spelled={name.lower(): name for name in names},
    )


def _bits(compiled: Compiled, labels: Iterable[Label]) -> dict[str, int]:
    statements = compiled.source_map.statements
    bits: dict[str, int] = {}
    for label in labels:
        behind = [one.bit for one in statements if one.offset >= label.offset]
        bits[label.name.lower()] = behind[0] if behind else _last_end(compiled)
    return bits


def _last_end(compiled: Compiled) -> int:
    """Return the stream bit of the END that every program gets behind its last statement."""
    image = compiled.image
    return decode(image.eeprom, image.model, image.flags).instructions[-1].address


def _counted(definitions: list[Definition], places: Mapping[str, Place]) -> VariableCounts:
    counts = dict.fromkeys(SIZES.values(), 0)
    for one in definitions:
        first = one.rest.replace("(", " ").split()
        if one.kind == "VAR" and first and first[0].upper() in SIZES:
            place = places[one.name.lower()]
            counts[place.size_bits] += place.length
    return VariableCounts(counts[1], counts[4], counts[8], counts[16])


def _unread(compiled: Compiled, why: str) -> SymbolError:
    return SymbolError(
        f"{compiled.name}: its names cannot be told from its source ({why}); "
        "look at registers by number instead, as in W0"
    )
