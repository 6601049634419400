"""A chip as its program names things: variables, pins, DATA and labels.

Looking changes nothing: a pin that floats is not reported, and nothing is read twice.
"""

from collections.abc import Callable, Iterator

from cgagen.emulator.durations import Durations
from cgagen.emulator.pins import PINS, SIN, Pins
from cgagen.emulator.registers import DIRS, FIRST_VARIABLE, OUTS, Registers
from cgagen.emulator.runner import Runner
from cgagen.errors import SymbolError
from cgagen.notations import small_number
from cgagen.stamp.compiled import Compiled
from cgagen.stamp.layout import Place
from cgagen.stamp.symbols import Symbols, symbols_of


class Ram:
    """The variables of the program that runs, by name in any case; also the chip's own names.

    What may be asked for is what a program could write: `count`, an element `row(2)`, a part
    `count.HIGHNIB`, a fixed name `W0`, a PIN (its level). An array without an element is its
    first one, as in PBASIC.
    """

    def __init__(self, registers: Registers, symbols: Callable[[], Symbols]) -> None:
        self._registers = registers
        self._symbols = symbols

    def __getitem__(self, name: str) -> int:
        """Return a variable's value.

        Raises:
            SymbolError: there is none of that name; the nearest ones.
        """
        place = self._symbols().place(name)
        return self._at(place, place.element)

    def __setitem__(self, name: str, value: int) -> None:
        """Store a value, cut to the variable's size.

        Raises:
            SymbolError: there is no variable of that name; the nearest ones.
        """
        size_bits, element, _ = self._symbols().place(name)
        self._registers.write(size_bits, element, value)

    def __contains__(self, name: object) -> bool:
        """Return whether there is a variable of that name, so that it may be asked for."""
        try:
            return isinstance(name, str) and bool(self._symbols().place(name))
        except SymbolError:
            return False

    def __iter__(self) -> Iterator[str]:
        """Return the names of the program's variables, in lower case."""
        return iter(self._symbols().variables)

    def keys(self) -> Iterator[str]:
        """Return the same: `dict(chip.ram)` has all variables with their values."""
        return iter(self)

    def __len__(self) -> int:
        """Return how many variables the program names."""
        return len(self._symbols().variables)

    def array(self, name: str) -> tuple[int, ...]:
        """Return all elements of an array; of any other variable, its value alone.

        Raises:
            SymbolError: there is none of that name; the nearest ones.
        """
        place = self._symbols().place(name)
        return tuple(self._at(place, place.element + n) for n in range(place.length))

    def _at(self, place: Place, element: int) -> int:
        bit = element * place.size_bits
        index = bit >> 4 & 15
        if index >= FIRST_VARIABLE:
            word = self._registers.words[index]
        else:
            word = _pins_word(self._registers.pins, index)
        return word >> (bit & 15) & (1 << place.size_bits) - 1


class Named(Runner):
    """The part of `cgagen.emulator.chip.Chip` that knows names.

    They are those of the program in the slot that runs, unless a slot is given.
    """

    @property
    def ram(self) -> Ram:
        """The program's variables: `chip.ram["count"]`; see `Ram`.

        Between two runs of the clock they are as they are at `local_ns`, where the chip is.
        """
        return Ram(self.machine.registers, self.symbols)

    def variable(self, name: str, slot: int | None = None) -> int:
        """Return a variable's value; the same as `ram[name]` where the slot runs.

        Raises:
            SymbolError: there is none of that name; the nearest ones.
        """
        return Ram(self.machine.registers, lambda: self.symbols(slot))[name]

    def symbols(self, slot: int | None = None) -> Symbols:
        """Return the names of the program in a slot; without one, in the slot that runs.

        Raises:
            SymbolError: its source is not known, or could not be read.
        """
        number = self.machine.slot if slot is None else slot
        compiled = self.source(number)
        known = self._symbols.get(number)
        if known is None or known[0] is not compiled:
            known = self._symbols[number] = (compiled, symbols_of(compiled))
        return known[1]

    def source(self, slot: int = 0) -> Compiled:
        """Return the source of the program in a slot.

        Raises:
            SymbolError: it is not known.
        """
        if slot not in self.programs:
            raise SymbolError(
                f"{self.name}: the source in slot {slot} is not known, so it has no names; "
                "make the chip with the compiled source, or ask for registers such as W0"
            )
        return self.programs[slot]

    def durations(self, *labels: str) -> Durations:
        """Begin to measure how long labelled routines take; slower, and no time is added.

        Args:
            labels: those wanted; without any, all of all slots whose source is known.

        Raises:
            SymbolError: there is no such label, or no source is known.
        """
        symbols = {slot: self.symbols(slot) for slot in sorted(self.programs)}
        if not symbols:
            self.symbols()
        for label in labels:
            if not any(label.strip().lower() in names.labels for names in symbols.values()):
                next(iter(symbols.values())).label(label)
        found = Durations(symbols, labels)

        def note(_chip: Runner) -> None:
            found.note(self.machine, self.clock.now_ns)

        self._each.append(note)
        found.end = lambda: self._each.remove(note)
        return found

    def pin_number(self, pin: int | str) -> int:
        """Return the number of a pin, given by its number or by name: a PIN, a CON, or P3.

        Raises:
            SymbolError: there is no pin of that name.
            ValueError: there is none of that number; 16 is SIN.
        """
        if isinstance(pin, int):
            if not 0 <= pin <= SIN:
                raise ValueError(f"{self.name}: no pin {pin}; give 0 to {PINS - 1}, or 16 for SIN")
            return pin
        low = pin.strip().lower()
        number = small_number(low[1:]) if low[:1] == "p" else None
        if number is not None and number < PINS:
            return number
        return self.symbols().pin(pin)

    def level(self, pin: int | str) -> int | None:
        """Return the level of the wire that a pin is on; None where it floats.

        Raises:
            SymbolError: there is no such pin.
        """
        return self.machine.main_pins.wires[self.pin_number(pin)].level

    def data(self, label: str, slot: int | None = None) -> bytes:
        """Return the bytes behind a DATA label as they are in the EEPROM now.

        Args:
            label: those of the DATA lines below it without a label included, up to the next.
            slot: of the program; without one, the slot that runs.

        Raises:
            SymbolError: there is no such label; the nearest ones.
        """
        block = self.symbols(slot).block(label)
        held = self.machine.memory.slots[self.machine.slot if slot is None else slot].data
        return bytes(held[block.address : block.address + block.bytes])


def _pins_word(pins: Pins, index: int) -> int:
    """Return INS, OUTS or DIRS; nothing is reported, and what floats is 0."""
    if index == OUTS:
        return pins.latch
    if index == DIRS:
        return pins.directions
    return sum(1 << pin for pin in range(PINS) if pins.wires[pin].level)
