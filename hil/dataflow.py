"""What a routine may do with the words that it is given, by data-flow over its tokens.

Abstract execution: a register bit is 0, 1, a certain bit of a sensor's word, or unknown, so that
names that share RAM are followed bit by bit. A comparison with a sensor's word in it goes on both
ways, and is noted. Every state that can be reached is visited once; there are finitely many,
for a sensor's word can only be copied whole. Whatever the chip does with any readings is among
what is visited: other ways may be visited as well, that no reading takes, which can make more
cells, never fewer.

All that is not understood is refused, by name: arithmetic with a sensor's word, a part of one,
a register that nothing has set, a pin, an instruction that takes time.

What has been set is followed to the end: the command lines are numbers there on every way,
neither left as they were nor made of a sensor's bits, and no other pin has been changed.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

from cgagen.emulator.arithmetic import binary_operators, unary_operators
from cgagen.emulator.machine import GOSUB_LEVELS
from cgagen.emulator.unknowns import CHOICES, Unknowns
from cgagen.stamp.opcodes import OPERATORS
from cgagen.stamp.program import Expression, Instruction, Kind, Program, Token
from hil.abstract import (
    DIRS_BIT,
    OUTS_BIT,
    UNKNOWN,
    VARIABLES_BIT,
    Memory,
    Refused,
    Sensor,
    Value,
    nothing_known,
    place_of,
    read,
    sensor_bits,
    written,
)
from hil.criticals import Criticals
from hil.places import Places

MOST_STATES = 100_000
"""Ref: choice; the reference programs have less than 3,000."""

_SYMBOLS = {operator.code: operator.symbol for operator in OPERATORS}
_COMPARISONS = frozenset(("<", ">", "<=", ">=", "=", "<>"))
_TURNED = {"<": ">", ">": "<", "<=": ">=", ">=": "<=", "=": "=", "<>": "<>"}
_LEAST_OR_MOST = {"MIN": ">=", "MAX": "<="}


class State(NamedTuple):
    """Where a program may be, and what its registers may hold."""

    address: int
    calls: tuple[int, ...]
    memory: Memory


@dataclass
class Flow:
    """What a routine does with its sensors' words.

    Attributes:
        criticals: what they are compared with.
        refused: what else is done, by stream address; empty when the routine only compares.
        states: how many abstract states were visited.
        exits: of these, at the end of the routine.
        visited: addresses of the instructions that may be carried out.
        loose: bits of the register file that are no known number at some end: left as they were,
            or a sensor's.
    """

    criticals: Criticals = field(default_factory=Criticals)
    refused: dict[int, str] = field(default_factory=dict)
    states: int = 0
    exits: int = 0
    visited: set[int] = field(default_factory=set)
    loose: set[int] = field(default_factory=set)


def flow_of(
    program: Program,
    eeprom: bytes,
    places: Places,
    levels: tuple[bool, ...],
    unknowns: Unknowns = CHOICES,
) -> Flow:
    """Follow the routine that decides, for one position of the antennas.

    Args:
        program: decoded.
        eeprom: its bytes, for READ.
        places: where the routine and its inputs are.
        levels: of the antennas' bits.
        unknowns: what no document says of operators.
    """
    memory = nothing_known()
    for number, word in enumerate(places.words):
        memory[16 * word : 16 * word + 16] = sensor_bits(number)
    for bit, level in zip(places.antennas, levels, strict=True):
        # The rest of the variable is 0, see `hil.places`.
        memory[bit & ~3 : (bit & ~3) + 4] = [
            0 if old == UNKNOWN else old for old in memory[bit & ~3 : (bit & ~3) + 4]
        ]
        memory[bit] = int(level)
    return Walk(program, eeprom, places, unknowns).run(places.entry, tuple(memory))


class Walk:
    """Visits all states.

    Args:
        program: decoded.
        eeprom: its bytes.
        places: where its inputs and outputs are.
        unknowns: what no document says of operators.
    """

    def __init__(
        self, program: Program, eeprom: bytes, places: Places, unknowns: Unknowns = CHOICES
    ) -> None:
        self._program = program
        self._eeprom = eeprom
        self._places = places
        self._names = places.names
        self._unary = unary_operators(unknowns)
        self._binary = binary_operators(unknowns)
        self._true = unknowns.true_word
        self._flow = Flow()

    def run(self, entry: int, memory: Memory) -> Flow:
        """Visit all that can be reached from an instruction on."""
        flow, queue = self._flow, [State(entry, (), memory)]
        seen = set(queue)
        while queue:
            state = queue.pop()
            flow.visited.add(state.address)
            try:
                for following in self._after(state):
                    if following not in seen:
                        seen.add(following)
                        queue.append(following)
            except Refused as refused:
                flow.refused.setdefault(state.address, str(refused))
            if len(seen) > MOST_STATES:
                flow.refused[state.address] = f"more than {MOST_STATES} states; no end in sight"
                break
        flow.states = len(seen)
        return flow

    # -- Instructions -----------------------------------------------------------------------

    def _after(self, state: State) -> Iterator[State]:
        """Return where the program may be after one instruction."""
        one = self._program.at(state.address)
        if one is None:
            raise Refused("no instruction starts here")
        step = _STEPS.get(one.name)
        if step is None:
            raise Refused(f"{one.name} is carried out, which does more than compute")
        yield from step(self, one, state)

    def _let(self, one: Instruction, state: State) -> Iterator[State]:
        for value in self._values(one.operands[0], state.memory):
            yield from self._stored(one, state, value)

    def _goto(self, one: Instruction, state: State) -> Iterator[State]:
        yield state._replace(address=one.targets[0])

    def _gosub(self, one: Instruction, state: State) -> Iterator[State]:
        calls = (*state.calls, one.number)
        if len(calls) >= GOSUB_LEVELS:
            raise Refused("GOSUB goes deeper than the chip remembers")
        yield state._replace(address=one.targets[0], calls=calls)

    def _return(self, _one: Instruction, state: State) -> Iterator[State]:
        if state.calls:
            back = self._program.gosub_slots[state.calls[-1] - 1]
            yield state._replace(address=back, calls=state.calls[:-1])
        else:
            self._flow.exits += 1
            self._flow.loose |= {n for n, bit in enumerate(state.memory) if bit >= UNKNOWN}

    def _if(self, one: Instruction, state: State) -> Iterator[State]:
        for value in self._values(one.operands[0], state.memory):
            for holds in self._compared("<>", value, 0):
                yield state._replace(address=one.targets[0] if holds else one.end)

    def _next(self, one: Instruction, state: State) -> Iterator[State]:
        """Ref: `cgagen.emulator.instructions`; a loop counts with numbers that are known."""
        end, start = (self._number(operand, state, "end of FOR") for operand in one.operands)
        counter, step = (self._number(v, state, "count of FOR") for v in one.items[0].values)
        moved = counter + step if start <= end else counter - step
        write = _target_of(one)
        stored = moved & (1 << write[-1].size_bits) - 1
        inside = min(start, end) <= stored <= max(start, end)
        for following in self._stored(one, state, stored):
            yield following._replace(address=one.targets[0]) if inside else following

    def _branch(self, one: Instruction, state: State) -> Iterator[State]:
        index = self._number(one.operands[0], state, "index of BRANCH")
        inside = index < len(one.targets)
        yield state._replace(address=one.targets[index] if inside else one.end)

    def _lookup(self, one: Instruction, state: State) -> Iterator[State]:
        index = self._number(one.operands[0], state, "index of LOOKUP")
        if index >= len(one.items):
            yield state._replace(address=one.end)
            return
        for value in self._values(one.items[index].values[0], state.memory):
            yield from self._stored(one, state, value)

    def _read(self, one: Instruction, state: State) -> Iterator[State]:
        location = self._number(one.operands[0], state, "location of READ")
        yield from self._stored(one, state, self._eeprom[location & len(self._eeprom) - 1])

    def _stored(self, one: Instruction, state: State, value: Value) -> Iterator[State]:
        *index, target = _target_of(one)
        for stack in self._stacks(tuple(index), state.memory, ()):
            memory = self._write(state.memory, target, stack, value)
            yield State(one.end, state.calls, memory)

    # -- Expressions ------------------------------------------------------------------------

    def _number(self, expression: Expression, state: State, what: str) -> int:
        values = self._values(expression, state.memory)
        if len(values) != 1:
            raise Refused(f"a comparison of sensors is the {what}")
        (value,) = values
        return self._known(value, what)

    def _known(self, value: Value, what: str) -> int:
        if isinstance(value, Sensor):
            raise Refused(f"{self._names[value.number]} is the {what}")
        return value

    def _values(self, expression: Expression, memory: Memory) -> list[Value]:
        found = [stack[-1] for stack in self._stacks(expression, memory, ())]
        return list(dict.fromkeys(found))

    def _stacks(
        self, expression: Expression, memory: Memory, stack: tuple[Value, ...]
    ) -> list[tuple[Value, ...]]:
        """Return every stack that tokens may leave."""
        stacks = [stack]
        for token in expression:
            stacks = [after for before in stacks for after in self._token(token, before, memory)]
        return stacks

    def _token(
        self, token: Token, stack: tuple[Value, ...], memory: Memory
    ) -> list[tuple[Value, ...]]:
        if token.kind is Kind.CONSTANT:
            return [(*stack, token.value)]
        if token.kind is Kind.READ:
            element, rest = self._element(token, stack)
            return [(*rest, read(memory, token.size_bits, element, self._names))]
        symbol = _SYMBOLS[token.value]
        if token.value in self._unary:
            number = self._operand(stack[-1], symbol)
            return [(*stack[:-1], self._unary[token.value](number))]
        *rest_list, left, right = stack
        found = self._operated(token.value, symbol, left, right)
        return [(*rest_list, value) for value in dict.fromkeys(found)]

    def _operated(self, code: int, symbol: str, left: Value, right: Value) -> list[Value]:
        """Return what an operator of two operands may leave."""
        if isinstance(left, int) and isinstance(right, int):
            return [self._binary[code](left, right)]
        if symbol in _COMPARISONS:
            return [self._true if holds else 0 for holds in self._compared(symbol, left, right)]
        if symbol in _LEAST_OR_MOST:
            chosen = self._compared(_LEAST_OR_MOST[symbol], left, right)
            return [left if first else right for first in chosen]
        return [self._operand(left, symbol), self._operand(right, symbol)]

    def _operand(self, value: Value, symbol: str) -> int:
        if isinstance(value, Sensor):
            raise Refused(f"{self._names[value.number]} is used in arithmetic, with {symbol}")
        return value

    def _compared(self, symbol: str, left: Value, right: Value) -> list[bool]:
        """Return how a comparison may come out, and note it."""
        if isinstance(left, Sensor) and isinstance(right, Sensor) and left != right:
            self._flow.criticals.pair(left.number, right.number)
            return [True, False]
        if isinstance(left, Sensor) and isinstance(right, int):
            self._flow.criticals.constant(left.number, symbol, right)
            return [True, False]
        if isinstance(right, Sensor) and isinstance(left, int):
            return self._compared(_TURNED[symbol], right, left)
        a, b = (left, right) if isinstance(left, int) and isinstance(right, int) else (0, 0)
        code = next(row.code for row in OPERATORS if row.symbol == symbol)
        return [bool(self._binary[code](a, b))]

    # -- Registers --------------------------------------------------------------------------

    def _element(self, token: Token, stack: tuple[Value, ...]) -> tuple[int, tuple[Value, ...]]:
        if not token.indexed:
            return token.value, stack
        return token.value + self._known(stack[-1], "index of an array"), stack[:-1]

    def _write(
        self, memory: Memory, target: Token, stack: tuple[Value, ...], value: Value
    ) -> Memory:
        element, _ = self._element(target, stack)
        first = place_of(element, target.size_bits)
        self._check_pins(range(first, first + target.size_bits), memory)
        return written(memory, target.size_bits, element, value)

    def _check_pins(self, bits: range, memory: Memory) -> None:
        """Refuse what changes pins other than those around the command lines."""
        if DIRS_BIT <= bits.start < VARIABLES_BIT:
            raise Refused("directions of pins are changed")
        lines = set(self._places.lines)
        near = {line & ~3 for line in lines}
        if OUTS_BIT <= bits.start < DIRS_BIT and any(bit & ~3 not in near for bit in bits):
            raise Refused("pins are changed that are no command lines")
        at_once = lines <= set(bits) and all(memory[line] >= UNKNOWN for line in lines)
        if self._places.step_line is None and lines & set(bits) and not at_once:
            raise Refused("the command lines, which may be read at any time, are not set at once")


_STEPS: dict[str, Callable[[Walk, Instruction, State], Iterator[State]]] = {
    "LET": Walk._let,
    "GOTO": Walk._goto,
    "GOSUB": Walk._gosub,
    "RETURN": Walk._return,
    "IF": Walk._if,
    "NEXT": Walk._next,
    "BRANCH": Walk._branch,
    "LOOKUP": Walk._lookup,
    "READ": Walk._read,
}


def _target_of(one: Instruction) -> Expression:
    if one.write is None:
        raise Refused(f"{one.name} stores nothing")
    return one.write
