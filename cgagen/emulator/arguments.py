"""What an instruction with pins or time of its own is called with, evaluated anew each time.

Such arguments are mostly a constant and a variable. An instruction that is carried out again and
again gets a Python function that evaluates them; nothing but speed depends on it.
"""

from collections.abc import Callable
from typing import Any

from cgagen.emulator.block_text import Writer
from cgagen.emulator.costs import LISTS_LATER
from cgagen.emulator.expressions import Evaluator
from cgagen.emulator.machine import Machine
from cgagen.stamp.program import Instruction, Item, label_address

Made = dict[str, Any]
"""Arguments by name."""

WORN = 20
"""So many times as often as a block of a program they are evaluated token by token before they are
compiled. Ref: choice, measured: compiling takes as long as 100 of them save."""


class Arguments:
    """The arguments of one instruction of one chip.

    Args:
        instruction: as it was decoded.
        items_ns: what the chip takes for each item of a list that is evaluated item by item.
        compile_after: see `cgagen.emulator.chip.Chip`.
    """

    __slots__ = ("_function", "_has_list", "_instruction", "_items", "_items_ns", "_left")

    def __init__(
        self, instruction: Instruction, items_ns: tuple[int, ...], compile_after: int | None
    ) -> None:
        self._instruction = instruction
        self._has_list = instruction.name in LISTS_LATER
        self._items_ns = items_ns
        self._items: list[ListItem] | None = None
        self._function: Callable[[list[int], Machine], Made | None] | None = None
        self._left = -1 if compile_after is None else WORN * compile_after

    def of(self, machine: Machine) -> Made:
        """Return the arguments now."""
        made = None
        if self._function is not None:
            made = self._function(machine.registers.words, machine)
        elif self._left >= 0:
            if self._left == 0:
                self._function = _compiled(self._instruction, machine)
            self._left -= 1
        if made is None:  # not compiled yet, or an index has come to a pin
            made = _evaluated(self._instruction, machine.evaluator)
        if self._has_list:
            made["items"] = self._list(machine.evaluator)
        return made

    def _list(self, evaluator: Evaluator) -> list["ListItem"]:
        if self._items is None:
            pairs = zip(self._instruction.items, self._items_ns, strict=True)
            self._items = [ListItem(item, evaluator, ns) for item, ns in pairs]
        return self._items


class ListItem:
    """One item of a list, to be evaluated when its turn comes; see `cgagen.emulator.port`."""

    __slots__ = ("_evaluator", "_item", "fetch_ns")

    def __init__(self, item: Item, evaluator: Evaluator, fetch_ns: int) -> None:
        self._item = item
        self._evaluator = evaluator
        self.fetch_ns = fetch_ns

    @property
    def stores(self) -> bool:
        """Whether `store` does anything."""
        return self._item.write is not None

    def values(self) -> tuple[int, ...]:
        """Evaluate the item now."""
        return self._evaluator.values(self._item.values)

    def store(self, value: int) -> None:
        """Store what was received."""
        if self._item.write is not None:
            self._evaluator.store(self._item.write, value)


def _evaluated(instruction: Instruction, evaluator: Evaluator) -> Made:
    values = evaluator.values(instruction.operands)
    return {
        name: label_address(value) if name.endswith("_target") else value
        for name, value in zip(instruction.form, values, strict=True)
    }


def _compiled(
    instruction: Instruction, machine: Machine
) -> Callable[[list[int], Machine], Made | None]:
    """Return a function that makes the arguments, or None where one of them is on a pin."""
    writer = Writer(machine.unknowns)
    writer.leave = "return None"
    pairs = []
    for name, operand in zip(instruction.form, instruction.operands, strict=True):
        value = writer.value(operand)
        if name.endswith("_target"):
            if value.constant is None:
                writer.line(writer.leave)
            pairs.append(f"{name!r}: {label_address(value.constant or 0)!r}")
        else:
            pairs.append(f"{name!r}: {value.word}")
    body = "\n".join([*writer.lines, f"    return {{{', '.join(pairs)}}}"])
    text = f"def made(r, m):\n    p = m.pins\n{body}\n"
    exec(compile(text, f"<arguments {instruction.address}>", "exec"), writer.names)
    function: Callable[[list[int], Machine], Made | None] = writer.names["made"]  # type: ignore[assignment]
    return function
