"""The instructions that take no time of their own: what each does to the machine.

Every function returns where the program goes on if that is not the next instruction.
"""

from collections.abc import Callable

from cgagen.emulator.arithmetic import binary_operators, next_random
from cgagen.emulator.button import button
from cgagen.emulator.machine import Machine, pin_number
from cgagen.stamp.program import Expression, Instruction

Action = Callable[[Machine, Instruction], int | None]


def _let(machine: Machine, instruction: Instruction) -> None:
    _store(machine, instruction, machine.evaluator.value(instruction.operands[0]))


def _goto(_machine: Machine, instruction: Instruction) -> int:
    return instruction.targets[0]


def _gosub(machine: Machine, instruction: Instruction) -> int:
    machine.call(instruction.number)
    return instruction.targets[0]


def _return(machine: Machine, _instruction: Instruction) -> int:
    return machine.returned()


def _if(machine: Machine, instruction: Instruction) -> int | None:
    """Any word but 0 is true. Ref: S9 (2.0c p. 153)."""
    return instruction.targets[0] if machine.evaluator.value(instruction.operands[0]) else None


def _next(machine: Machine, instruction: Instruction) -> int | None:
    """End, start and step are evaluated anew each time. Ref: S3.

    The counter's value after it was cut to its size must lie between start and end. Ref: S2
    p. 193 to 196 (its example 10 TO 300 with a byte).
    """
    end, start = machine.evaluator.values(instruction.operands)
    counter, step = machine.evaluator.values(instruction.items[0].values)
    moved = counter + step if start <= end else counter - step
    size_bits = _written(instruction)[-1].size_bits
    stored = moved & (1 << size_bits) - 1
    _store(machine, instruction, stored)
    inside = min(start, end) <= stored <= max(start, end)
    return instruction.targets[0] if inside else None


def _branch(machine: Machine, instruction: Instruction) -> int | None:
    """An index past the list goes on with the next instruction. Ref: S2 BRANCH."""
    index = machine.evaluator.value(instruction.operands[0])
    return instruction.targets[index] if index < len(instruction.targets) else None


def _lookup(machine: Machine, instruction: Instruction) -> None:
    """An index past the list changes nothing. Ref: S2 LOOKUP."""
    index = machine.evaluator.value(instruction.operands[0])
    if index < len(instruction.items):
        value = machine.evaluator.value(instruction.items[index].values[0])
        _store(machine, instruction, value)


def _lookdown(machine: Machine, instruction: Instruction) -> None:
    """Find the first value that target holds against; with none, nothing changes. Ref: S2."""
    target = machine.evaluator.value(instruction.operands[0])
    holds = binary_operators()[instruction.comparison]
    for index, item in enumerate(instruction.items):
        if holds(target, machine.evaluator.value(item.values[0])):
            _store(machine, instruction, index)
            return


def _random(machine: Machine, instruction: Instruction) -> None:
    seed = machine.evaluator.value(instruction.operands[0])
    _store(machine, instruction, next_random(seed, machine.unknowns))


def _read(machine: Machine, instruction: Instruction) -> None:
    location = machine.evaluator.value(instruction.operands[0])
    _store(machine, instruction, machine.read(location))


def _get(machine: Machine, instruction: Instruction) -> None:
    location = machine.evaluator.value(instruction.operands[0])
    _store(machine, instruction, machine.get(location))


def _put(machine: Machine, instruction: Instruction) -> None:
    machine.put(*machine.evaluator.values(instruction.operands))


def _run(machine: Machine, instruction: Instruction) -> int:
    return machine.run_slot(machine.evaluator.value(instruction.operands[0]))


def _store_slot(machine: Machine, instruction: Instruction) -> None:
    machine.use_slot(machine.evaluator.value(instruction.operands[0]))


def _high(machine: Machine, instruction: Instruction) -> None:
    """The latch comes before the direction, so no other level is ever driven. Ref: choice."""
    bit = _pin_bit(machine, instruction)
    machine.pins.set_latch(machine.pins.latch | bit)
    machine.pins.set_directions(machine.pins.directions | bit)


def _low(machine: Machine, instruction: Instruction) -> None:
    bit = _pin_bit(machine, instruction)
    machine.pins.set_latch(machine.pins.latch & ~bit)
    machine.pins.set_directions(machine.pins.directions | bit)


def _toggle(machine: Machine, instruction: Instruction) -> None:
    bit = _pin_bit(machine, instruction)
    machine.pins.set_latch(machine.pins.latch ^ bit)
    machine.pins.set_directions(machine.pins.directions | bit)


def _input(machine: Machine, instruction: Instruction) -> None:
    machine.pins.set_directions(machine.pins.directions & ~_pin_bit(machine, instruction))


def _output(machine: Machine, instruction: Instruction) -> None:
    machine.pins.set_directions(machine.pins.directions | _pin_bit(machine, instruction))


def _reverse(machine: Machine, instruction: Instruction) -> None:
    machine.pins.set_directions(machine.pins.directions ^ _pin_bit(machine, instruction))


def _mainio(machine: Machine, _instruction: Instruction) -> None:
    machine.choose_port(auxiliary=False)


def _auxio(machine: Machine, _instruction: Instruction) -> None:
    machine.choose_port(auxiliary=True)


def _ioterm(machine: Machine, instruction: Instruction) -> None:
    """0 is the main port; every other number the auxiliary one (choice). Ref: S2 IOTERM."""
    machine.choose_port(machine.evaluator.value(instruction.operands[0]) != 0)


def _pollmode(machine: Machine, instruction: Instruction) -> None:
    machine.polling.set_mode(machine.evaluator.value(instruction.operands[0]))


def _pollrun(machine: Machine, instruction: Instruction) -> None:
    slot = machine.evaluator.value(instruction.operands[0])
    machine.polling.slot = slot % machine.model.slots


def _pollin(machine: Machine, instruction: Instruction) -> None:
    state, pin = machine.evaluator.values(instruction.operands)
    machine.polling.watch(machine.place(pin_number(pin)), state & 1, machine.groups)


def _pollout(machine: Machine, instruction: Instruction) -> None:
    state, pin = machine.evaluator.values(instruction.operands)
    machine.polling.drive(machine.place(pin_number(pin)), state & 1, machine.groups)


def _button(machine: Machine, instruction: Instruction) -> int | None:
    down, delay, rate, target, work, pin = machine.evaluator.values(instruction.operands)
    number = pin_number(pin)
    machine.pins.set_directions(machine.pins.directions & ~(1 << number))
    pressed = machine.pins.level(number) == down & 1
    work, acts = button(pressed, delay & 0xFF, rate & 0xFF, work & 0xFF, target & 1)
    _store(machine, instruction, work)
    return instruction.targets[0] if acts else None


ACTIONS: dict[str, Action] = {
    "LET": _let,
    "GOTO": _goto,
    "GOSUB": _gosub,
    "RETURN": _return,
    "IF": _if,
    "NEXT": _next,
    "BRANCH": _branch,
    "LOOKUP": _lookup,
    "LOOKDOWN": _lookdown,
    "RANDOM": _random,
    "READ": _read,
    "GET": _get,
    "PUT": _put,
    "RUN": _run,
    "STORE": _store_slot,
    "HIGH": _high,
    "LOW": _low,
    "TOGGLE": _toggle,
    "INPUT": _input,
    "OUTPUT": _output,
    "REVERSE": _reverse,
    "MAINIO": _mainio,
    "AUXIO": _auxio,
    "IOTERM": _ioterm,
    "POLLMODE": _pollmode,
    "POLLRUN": _pollrun,
    "POLLIN": _pollin,
    "POLLOUT": _pollout,
    "BUTTON": _button,
}

CONDITIONAL = frozenset({"IF", "NEXT", "BRANCH", "BUTTON"})
"""Instructions whose jump, when it is taken, costs time of its own."""

ON_PINS = frozenset(
    "HIGH LOW TOGGLE INPUT OUTPUT REVERSE MAINIO AUXIO IOTERM POLLMODE POLLRUN POLLIN POLLOUT "
    "BUTTON RUN STORE".split()
)
"""Instructions that act at their own time whatever their operands are."""


def _written(instruction: Instruction) -> Expression:
    if instruction.write is None:
        raise AssertionError(f"{instruction.name} stores nothing")  # the decoder sees to that
    return instruction.write


def _store(machine: Machine, instruction: Instruction, value: int) -> None:
    machine.evaluator.store(_written(instruction), value)


def _pin_bit(machine: Machine, instruction: Instruction) -> int:
    return 1 << pin_number(machine.evaluator.value(instruction.operands[0]))
