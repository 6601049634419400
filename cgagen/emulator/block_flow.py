"""Where the program may go from an address without touching pins or taking time of its own."""

from collections.abc import Callable
from typing import NamedTuple

from cgagen.emulator.registers import DIRS, FIRST_VARIABLE, INS
from cgagen.emulator.steps import Step
from cgagen.errors import CgagenError
from cgagen.stamp.program import Expression, Instruction, Kind

MOST_INSTRUCTIONS = 64
"""In one block. Ref: choice; longer ones take longer to compile than they save."""

EXIT = -1
"""Stands for all that is outside."""

COMPILED = frozenset(
    "LET GOTO GOSUB RETURN IF NEXT BRANCH LOOKUP LOOKDOWN RANDOM READ GET PUT".split()
)


class Flow(NamedTuple):
    """A piece of the program without loops.

    Attributes:
        steps: by address.
        joins: for an address with two ways on, where they come together again; `EXIT` where
            they do not.
    """

    steps: dict[int, Step]
    joins: dict[int, int]


def flow_from(address: int, step_at: Callable[[int], Step]) -> Flow:
    """Return what can be compiled from an address on; nothing where even the first cannot."""
    steps: dict[int, Step] = {}
    queue = [address]
    for here in queue:
        if here in steps or len(steps) >= MOST_INSTRUCTIONS:
            continue
        try:
            step = step_at(here)
        except CgagenError:
            continue  # whoever gets there hears of it
        if compilable(step.instruction):
            steps[here] = step
            queue += _ways(step.instruction)
    return Flow(steps, _joins(address, steps))


def compilable(instruction: Instruction) -> bool:
    """Return whether an instruction can be part of a block.

    Reading INS and writing DIRS cannot. Writing OUTS can, and so can an index: the block looks
    whether it concerns a pin, and leaves if so.
    """
    name = instruction.name
    if name not in COMPILED or (name == "GOTO" and instruction.targets[0] == instruction.address):
        return False
    expressions: list[Expression] = [*instruction.operands]
    expressions += [value for item in instruction.items for value in item.values]
    if instruction.write is not None:
        expressions.append(instruction.write)
    for expression in expressions:
        for token in expression:
            word = token.value * token.size_bits >> 4 & 15
            if token.kind is Kind.READ and not token.indexed and word == INS:
                return False
            if token.kind is Kind.WRITE and not token.indexed:
                if word < FIRST_VARIABLE and word in (INS, DIRS):
                    return False
    return True


def _ways(instruction: Instruction) -> list[int]:
    if instruction.name == "RETURN":
        return []
    if instruction.name in ("GOTO", "GOSUB"):
        return [instruction.targets[0]]
    if instruction.name in ("IF", "NEXT"):
        return [instruction.end, instruction.targets[0]]
    return [instruction.end]


def _joins(first: int, steps: dict[int, Step]) -> dict[int, int]:
    """Return the nearest common way on of every fork: its immediate postdominator.

    A jump back to an address that leads here counts as a way out.
    """
    ends: dict[int, dict[int, None]] = {}
    # depth first, without recursion: an address is done when all its ways are
    stack: list[tuple[int, list[int], list[dict[int, None]]]] = []
    open_addresses: set[int] = set()

    def enter(address: int) -> None:
        open_addresses.add(address)
        stack.append((address, list(_ways(steps[address].instruction)), []))

    if first in steps:
        enter(first)
    while stack:
        address, ways, found = stack[-1]
        if not ways:
            stack.pop()
            open_addresses.discard(address)
            ends[address] = _common(address, found)
            continue
        way = ways[0]
        if way not in steps or way in open_addresses:
            found.append({EXIT: None})
        elif way in ends:
            found.append(ends[way])
        else:
            enter(way)
            continue
        ways.pop(0)
    return {address: _nearest(found, address) for address, found in ends.items()}


def _common(address: int, found: list[dict[int, None]]) -> dict[int, None]:
    """Return what all ways on pass, in their order, this address first."""
    if not found:
        return {address: None, EXIT: None}
    others = [way for way in found[0] if all(way in more for more in found[1:])]
    return {address: None, **dict.fromkeys(others)}


def _nearest(found: dict[int, None], address: int) -> int:
    return next((way for way in found if way != address), EXIT)
