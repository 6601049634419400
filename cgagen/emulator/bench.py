"""A bench: one clock, and the chips, wires and parts on it."""

from collections.abc import Callable
from typing import NamedTuple, TypeVar

from cgagen.emulator.chip import Chip, ChipState
from cgagen.emulator.clock import NEVER_NS, Clock
from cgagen.emulator.lookup import found
from cgagen.emulator.parts.part import Part, PartState
from cgagen.emulator.parts.uart import Uart
from cgagen.emulator.pins import PINS
from cgagen.emulator.wires import Wire, WireState
from cgagen.errors import BenchError
from cgagen.stamp.compiled import Compiled

PartT = TypeVar("PartT", bound=Part)


class BenchState(NamedTuple):
    """A moment of a bench, for `Bench.restore` of the same bench."""

    clock: tuple[int, int]
    wires: tuple[tuple[Wire, WireState], ...]
    parts: tuple[tuple[str, PartState], ...]
    chips: tuple[tuple[str, ChipState], ...]


class Bench:
    """Everything that shares a clock.

    Every pin of a chip and every lead of a part is an end, called `main.P3` or `front.signal`;
    a wire joins ends. The programming port's ends are `main.SIN` and `main.SOUT`.

    Attributes:
        clock: the time of all of them.
        chips: by name.
        parts: by name.
        wires: those with a name of their own.
        floated: pins that were read while nobody drove or pulled them, such as "main.P7".
        on_floating: told each of them when it happens.
        on_restore: told, each of them, when the bench has gone back, and from which time.

    >>> from cgagen.emulator.parts.whisker import Whisker
    >>> bench = Bench()
    >>> left = bench.add_part(Whisker("left", bench.clock, bench.end("left.signal")))
    >>> bench.connect("antenna", "left.signal").level
    1
    """

    def __init__(self) -> None:
        self.clock = Clock()
        self.chips: dict[str, Chip] = {}
        self.parts: dict[str, Part] = {}
        self.wires: dict[str, Wire] = {}
        self.floated: list[str] = []
        self.on_floating: Callable[[str], None] = _nothing
        self.on_restore: list[Callable[[int], None]] = []
        self._ends: dict[str, Wire] = {}
        self._on: dict[str, str] = {}

    @property
    def programs(self) -> dict[str, dict[int, Compiled]]:
        """What is known of the sources that run, by chip and slot."""
        return {name: chip.programs for name, chip in self.chips.items() if chip.programs}

    def add_chip(self, chip: Chip) -> Chip:
        """Put a chip on the bench, by its own name.

        Raises:
            BenchError: the name is taken.
        """
        self._refuse_taken(chip.name)
        self.chips[chip.name] = chip
        ends = [*chip.pins.wires, chip.pins.sout]
        self._ends |= dict(zip(chip_ends(chip.name), ends, strict=True))
        return chip

    def add_part(self, part: PartT) -> PartT:
        """Put a part on the bench, by its own name; its leads are `end(...)`.

        Raises:
            BenchError: the name is taken.
        """
        self._refuse_taken(part.name)
        self.parts[part.name] = part
        return part

    def end(self, name: str) -> Wire:
        """Return a pin's or a lead's own end, such as "main.P3" or "front.signal".

        The end of a chip must be there; a part's comes into being, for the part to be made with.

        Raises:
            BenchError: the chip has no such end.
        """
        owner, _, lead = name.partition(".")
        if name not in self._ends:
            if owner in self.chips or not lead:
                raise BenchError(
                    f"{name}: no such end; a chip's are P0 to P15, SIN and SOUT, "
                    f"as in {owner}.P3, and a part's its name and its lead"
                )
            self._ends[name] = Wire(name)
        return self._ends[name]

    def connect(self, wire: str, *ends: str, pull: int | None = None) -> Wire:
        """Put ends on a wire, which is made where there is none of that name.

        Args:
            wire: its name.
            ends: such as "main.P3".
            pull: level that a resistor gives it while nobody drives it.

        Raises:
            BenchError: there is no such end, or it is on another wire already.
            ContentionError: outputs disagree.
        """
        if wire not in self.wires:
            self.wires[wire] = Wire(wire, pull)
        for name in ends:
            end = self.end(name)
            if self._on.get(name, wire) != wire:
                raise BenchError(
                    f"{wire}: {name} is on the wire {self._on[name]} already; "
                    "put all ends that are joined on one wire"
                )
            self._on[name] = wire
            self.wires[wire].join(end)
        return self.wires[wire]

    def wire(self, name: str) -> Wire:
        """Return a wire by its name, or an end that exists by its.

        Raises:
            BenchError: there is none.
        """
        return found(self.wires | self._ends, name, "wire")

    def wire_of(self, end: str) -> str | None:
        """Return the name of the wire that an end is on; None for none."""
        return self._on.get(end)

    @property
    def connected(self) -> tuple[str, ...]:
        """Names of all ends that are on wires."""
        return tuple(self._on)

    def floats(self, end: str) -> None:
        """Remember a pin that was read while nobody drove it."""
        self.floated.append(end)
        self.on_floating(end)

    def host(self, chip: str, echo: bool = True) -> Uart:
        """Return the computer on a chip's programming port; it comes with the first call.

        Args:
            chip: its name.
            echo: what it sends comes back to it, as on every board.

        Raises:
            BenchError: there is no such chip, or something else is on its port.
        """
        name = f"{chip}_host"
        if name not in self.parts:
            self.chip(chip)
            sin, sout = self.end(f"{name}.transmit"), self.end(f"{name}.receive")
            self.connect(f"{chip}_SIN", f"{chip}.SIN", f"{name}.transmit")
            self.connect(f"{chip}_SOUT", f"{chip}.SOUT", f"{name}.receive")
            self.add_part(Uart(name, self.clock, sin, sout, mark=0, echo=echo))
        return self.part(name, Uart)

    def chip(self, name: str) -> Chip:
        """Return a chip.

        Raises:
            BenchError: there is none of that name.
        """
        return found(self.chips, name, "chip")

    def variable(self, name: str) -> int:
        """Return a variable of a chip's program, such as "main.count"; see `Chip.variable`."""
        owner, _, variable = name.partition(".")
        return self.chip(owner).variable(variable)

    def part(self, name: str, kind: type[PartT]) -> PartT:
        """Return a part of a kind, for example `part("front", Ping)`.

        Raises:
            BenchError: there is none of that name, or it is of another kind.
        """
        part = found(self.parts, name, "part")
        if not isinstance(part, kind):
            raise BenchError(
                f"{name}: is a {type(part).__name__}, where a {kind.__name__} is wanted; "
                "name another part"
            )
        return part

    def parts_of(self, kind: type[PartT]) -> dict[str, PartT]:
        """Return all parts of a kind by name, in the order in which they came."""
        return {name: part for name, part in self.parts.items() if isinstance(part, kind)}

    def run(self, until_ns: int) -> None:
        """Let everything happen up to a time, that time included, or until `clock.stop()`."""
        self.clock.run_until(until_ns)

    def run_until(self, condition: Callable[[], bool], limit_ns: int) -> bool:
        """Go on until something is the case, asked after everything that happens.

        This is exact, and slower than `run`: chips move no clock by themselves meanwhile.
        `Chip.run_until` looks between the instructions of one chip.

        Args:
            condition: asked before, and after everything that is booked.
            limit_ns: the time at which to give up.

        Returns:
            Whether it is the case; the clock stands at that moment, or at `limit_ns`.
        """
        clock = self.clock
        while not condition():
            if clock.next_ns() > min(limit_ns, NEVER_NS - 1):
                clock.run_until(limit_ns)
                return condition()
            clock.run_next()
        return True

    def reset(self, chip: str, hold_ns: int = 0) -> None:
        """Pull the ATN of a chip: its pins are inputs while that lasts, then it starts anew.

        Raises:
            BenchError: there is none of that name.
        """
        self.chip(chip).reset(hold_ns)

    def snapshot(self) -> BenchState:
        """Return this moment, for `restore`.

        Raises:
            BenchError: something is booked that no chip and no part knows of.
        """
        self._refuse_strays()
        return BenchState(
            self.clock.state(),
            tuple((wire, wire.state()) for wire in self._all_wires()),
            tuple((name, part.state()) for name, part in self.parts.items()),
            tuple((name, chip.state()) for name, chip in self.chips.items()),
        )

    def restore(self, state: BenchState) -> None:
        """Go back to a moment of this bench; what follows then follows again.

        Raises:
            BenchError: parts or chips have been added since.
        """
        if [name for name, _ in state.parts + state.chips] != [*self.parts, *self.chips]:
            raise BenchError(
                "the snapshot is of a bench with other parts or chips; take another one"
            )
        left_ns = self.clock.now_ns
        self.clock.restore(state.clock)
        for wire, before in state.wires:
            wire.restore(before)
        for name, part_state in state.parts:
            self.parts[name].restore(part_state)
        for name, chip_state in state.chips:
            self.chips[name].restore(chip_state)
        for told in self.on_restore:
            told(left_ns)

    def _all_wires(self) -> list[Wire]:
        return [*self.wires.values(), *self._ends.values()]

    def _refuse_strays(self) -> None:
        known = {booking for part in self.parts.values() for booking in part.bookings()}
        known |= {booking for chip in self.chips.values() for booking in chip.bookings()}
        for booking in self.clock.bookings():
            if booking not in known:
                raise BenchError(
                    f"something is booked at {booking[0]} ns that no part and no chip knows of, "
                    "so this moment cannot be remembered; book it with Part.timer"
                )

    def _refuse_taken(self, name: str) -> None:
        if name in self.chips or name in self.parts:
            raise BenchError(f"{name}: there is one of that name already; choose another name")


def chip_ends(chip: str) -> tuple[str, ...]:
    """Return the names of a chip's ends.

    >>> chip_ends("main")[3], chip_ends("main")[-2:]
    ('main.P3', ('main.SIN', 'main.SOUT'))
    """
    return (*(f"{chip}.P{pin}" for pin in range(PINS)), f"{chip}.SIN", f"{chip}.SOUT")


def _nothing(_end: str) -> None:
    pass
