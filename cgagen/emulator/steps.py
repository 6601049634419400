"""An instruction, ready to be carried out: what it takes, and by whom it is done."""

from dataclasses import dataclass

from cgagen.emulator.commands import COMMANDS, CommandFunction
from cgagen.emulator.costs import LISTS_LATER, instruction_ns, item_ns
from cgagen.emulator.expressions import Evaluator, depends_on_pins
from cgagen.emulator.instructions import ACTIONS, CONDITIONAL, ON_PINS, Action
from cgagen.emulator.pauses import PAUSES
from cgagen.emulator.timing import Timing
from cgagen.stamp.program import Expression, Instruction, Item, Kind, label_address

FUNCTIONS: dict[str, CommandFunction] = {**COMMANDS, **PAUSES}
"""All instructions that are generators, by name."""


@dataclass(frozen=True, slots=True)
class Step:
    """One instruction of one chip.

    Attributes:
        instruction: as it was decoded.
        ns: what passes before it acts.
        jump_ns: what passes besides when it jumps.
        on_pins: it reads or changes pins, so the bench must have reached its time.
        action: what it does; None where it is a generator.
        function: the generator; None for STOP, which the chip knows itself.
        items_ns: what each item of a list takes that is evaluated when its turn comes.
    """

    instruction: Instruction
    ns: int
    jump_ns: int
    on_pins: bool
    action: Action | None
    function: CommandFunction | None
    items_ns: tuple[int, ...]

    @property
    def pure(self) -> bool:
        """Whether neither pins nor time of its own are in it."""
        return self.action is not None and not self.on_pins


def step_of(instruction: Instruction, timing: Timing) -> Step:
    """Return an instruction with everything about it that never changes."""
    name = instruction.name
    action = ACTIONS.get(name)
    items = instruction.items if name in LISTS_LATER else ()
    return Step(
        instruction=instruction,
        ns=instruction_ns(instruction, timing),
        jump_ns=timing.jump_ns if name in CONDITIONAL else 0,
        on_pins=action is None or name in ON_PINS or _on_pins(instruction),
        action=action,
        function=FUNCTIONS.get(name),
        items_ns=tuple(item_ns(instruction, item, timing) for item in items),
    )


def arguments(step: Step, evaluator: Evaluator) -> dict[str, object]:
    """Return the keyword arguments of an instruction's generator, evaluated now."""
    instruction = step.instruction
    made: dict[str, object] = {}
    values = evaluator.values(instruction.operands)
    for name, value in zip(instruction.form, values, strict=True):
        made[name] = label_address(value) if name.endswith("_target") else value
    if instruction.name in LISTS_LATER:
        made["items"] = [
            ListItem(item, evaluator, ns)
            for item, ns in zip(instruction.items, step.items_ns, strict=True)
        ]
    return made


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


def _on_pins(instruction: Instruction) -> bool:
    expressions: list[Expression] = [*instruction.operands]
    expressions += [value for item in instruction.items for value in item.values]
    if instruction.write is not None:
        expressions.append(instruction.write)
    return any(
        depends_on_pins(token)
        for expression in expressions
        for token in expression
        if token.kind in (Kind.READ, Kind.WRITE)
    )
