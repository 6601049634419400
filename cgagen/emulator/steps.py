"""An instruction, ready to be carried out: what it takes, and by whom it is done."""

from dataclasses import dataclass

from cgagen.emulator.arguments import Arguments
from cgagen.emulator.commands import COMMANDS, CommandFunction
from cgagen.emulator.costs import LISTS_LATER, instruction_ns, item_ns
from cgagen.emulator.expressions import depends_on_pins
from cgagen.emulator.instructions import ACTIONS, CONDITIONAL, ON_PINS, Action
from cgagen.emulator.pauses import PAUSES
from cgagen.emulator.timing import Timing
from cgagen.stamp.program import Expression, Instruction, Kind

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
        arguments: what the generator is called with.
        pulse: it is PULSOUT, with arguments that have nothing to do with pins.
    """

    instruction: Instruction
    ns: int
    jump_ns: int
    on_pins: bool
    action: Action | None
    function: CommandFunction | None
    arguments: Arguments
    pulse: bool


def step_of(instruction: Instruction, timing: Timing, compile_after: int | None = None) -> Step:
    """Return an instruction with everything about it that never changes.

    Args:
        instruction: as it was decoded.
        timing: of the chip.
        compile_after: see `cgagen.emulator.chip.Chip`.
    """
    name = instruction.name
    action = ACTIONS.get(name)
    items = instruction.items if name in LISTS_LATER else ()
    items_ns = tuple(item_ns(instruction, item, timing) for item in items)
    return Step(
        instruction=instruction,
        ns=instruction_ns(instruction, timing),
        jump_ns=timing.jump_ns if name in CONDITIONAL else 0,
        on_pins=action is None or name in ON_PINS or _on_pins(instruction),
        action=action,
        function=FUNCTIONS.get(name),
        arguments=Arguments(instruction, items_ns, compile_after),
        pulse=name == "PULSOUT" and not _on_pins(instruction),
    )


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
