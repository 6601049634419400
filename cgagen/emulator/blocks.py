"""Pieces of a program as Python functions.

A block begins at an address and goes on as long as no pin is touched and no time is taken but
what instructions take anyway. Called with the register words and the machine, it returns where
the program is then, and what it took: nanoseconds in the high bits, instructions carried out in
the low `COUNT_BITS`. A negative place is the complement of an instruction that, as it turned
out, touches a pin; nothing of it has happened.
"""

from collections.abc import Callable
from typing import NamedTuple

from cgagen.emulator.arithmetic import next_random
from cgagen.emulator.block_flow import EXIT, Flow, flow_from
from cgagen.emulator.block_text import Text, Writer
from cgagen.emulator.machine import Machine
from cgagen.emulator.steps import Step
from cgagen.emulator.unknowns import Unknowns
from cgagen.stamp.program import Instruction

Function = Callable[[list[int], Machine], tuple[int, int]]


class Block(NamedTuple):
    """A piece of a program.

    Attributes:
        function: carries it out; see above.
        most_ns: it never takes longer.
    """

    function: Function
    most_ns: int


COUNT_BITS = 32

MOST_LINES = 400
"""Of one function. Ref: choice; ways that come together nowhere are written twice."""

_SIGNS = {0x1A: ">=", 0x1B: "<=", 0x1C: "==", 0x1D: "!=", 0x1E: ">", 0x1F: "<"}


def block_at(address: int, step_at: Callable[[int], Step], unknowns: Unknowns) -> Block | None:
    """Return the block that begins at an address; None where none can.

    Args:
        address: stream address.
        step_at: the instructions of the slot.
        unknowns: what no document says.
    """
    flow = flow_from(address, step_at)
    if address not in flow.steps:
        return None
    most_ns = sum(step.ns + step.jump_ns for step in flow.steps.values())
    return Block(_compiled(address, *block_text(address, flow, unknowns)), most_ns)


def block_text(address: int, flow: Flow, unknowns: Unknowns) -> tuple[str, dict[str, object]]:
    """Return a block's Python text, and the names that it needs."""
    writer = _BlockWriter(flow, unknowns)
    writer.way(address, EXIT, 0, False, frozenset())
    body = "\n".join(writer.lines)
    return f"def block(r, m):\n    p = m.pins\n{body}\n", writer.names


def _compiled(address: int, text: str, names: dict[str, object]) -> Function:
    exec(compile(text, f"<block {address}>", "exec"), names)
    block: Function = names["block"]  # type: ignore[assignment]
    return block


class _BlockWriter(Writer):
    """Writes a flow."""

    def __init__(self, flow: Flow, unknowns: Unknowns) -> None:
        super().__init__(unknowns)
        self._flow = flow
        self._unknowns = unknowns

    def way(
        self, address: int, join: int, taken: int, counted: bool, passed: frozenset[int]
    ) -> bool:
        """Write all from an address to a join.

        Args:
            address: where it begins.
            join: where it ends.
            taken: what it took since the last statement that says so.
            counted: `t` holds what it took before that.
            passed: addresses on the way here.

        Returns:
            Whether the join is ever reached.
        """
        while address != join:
            step = self._flow.steps.get(address)
            if step is None or address in passed or len(self.lines) > MOST_LINES:
                self.line(_leave(address, taken, counted))
                return False
            passed |= {address}
            self.leave = _leave(~address, taken, counted)
            taken += step.ns << COUNT_BITS | 1
            instruction = step.instruction
            name = instruction.name
            if name in ("IF", "NEXT"):
                test = self._if(instruction) if name == "IF" else self._next(instruction)
                meet = self._flow.joins[address]
                if not self._fork(step, test, meet, taken, counted, passed):
                    return False
                address, taken, counted = meet, 0, True
            elif name == "RETURN":
                self.line(_leave("m.returned()", taken, counted))
                return False
            else:
                self._plain(instruction, taken + (step.jump_ns << COUNT_BITS), counted)
                jumps = name in ("GOTO", "GOSUB")
                address = instruction.targets[0] if jumps else instruction.end
        if not counted:
            self.line(f"t = {taken}")
        elif taken:
            self.line(f"t += {taken}")
        elif not self.lines[-1].startswith("    " * self.depth):
            self.line("pass")
        return True

    def _fork(
        self, step: Step, test: str, meet: int, taken: int, counted: bool, passed: frozenset[int]
    ) -> bool:
        """Write both ways on from a test; returns whether they meet anywhere."""
        instruction = step.instruction
        self.line(f"if {test}:")
        self.depth += 1
        jumped = taken + (step.jump_ns << COUNT_BITS)
        first = self.way(instruction.targets[0], meet, jumped, counted, passed)
        self.depth -= 1
        self.line("else:")
        self.depth += 1
        second = self.way(instruction.end, meet, taken, counted, passed)
        self.depth -= 1
        return first or second

    def _plain(self, instruction: Instruction, jumped: int, counted: bool) -> None:
        """Write an instruction with one way on, or one that may leave for a table of places."""
        name = instruction.name
        if name == "LET":
            self._write(instruction, self.value(instruction.operands[0]))
        elif name == "GOSUB":
            self.line(f"m.call({instruction.number})")
        elif name == "BRANCH":
            index = self.kept(self.value(instruction.operands[0]).word, 0)
            self.line(f"if {index.code} < {len(instruction.targets)}:")
            place = f"{instruction.targets!r}[{index.code}]"
            self.line(f"    {_leave(place, jumped, counted)}")
        elif name == "LOOKUP":
            self._lookup(instruction)
        elif name == "LOOKDOWN":
            self._lookdown(instruction)
        elif name == "RANDOM":
            unknowns = self._unknowns
            self.names["random"] = lambda seed: next_random(seed, unknowns)
            seed = self.value(instruction.operands[0]).word
            self._write(instruction, Text(f"random({seed})"))
        elif name in ("READ", "GET"):
            location = self.value(instruction.operands[0]).word
            self._write(instruction, Text(f"m.{name.lower()}({location})"))
        elif name == "PUT":
            location, value = (self.value(operand).word for operand in instruction.operands)
            self.line(f"m.put({location}, {value})")

    def _write(self, instruction: Instruction, value: Text) -> None:
        if instruction.write is None:
            raise AssertionError(f"{instruction.name} stores nothing")  # the decoder sees to that
        self.store(instruction.write, value)

    def _if(self, instruction: Instruction) -> str:
        return self.value(instruction.operands[0]).truth

    def _next(self, instruction: Instruction) -> str:
        """Write NEXT's sum and store; returns its test."""
        end, start = (self._fixed(self.value(operand)) for operand in instruction.operands)
        counter, step = (self.value(value) for value in instruction.items[0].values)
        if instruction.write is None:
            raise AssertionError("NEXT stores nothing")
        mask = (1 << instruction.write[-1].size_bits) - 1
        up, down = f"{counter.loose} + {step.loose}", f"{counter.loose} - {step.loose}"
        if start.constant is not None and end.constant is not None:
            low, high = sorted((start.constant, end.constant))
            new = up if start.constant <= end.constant else down
            moved = self.kept(f"{new} & {mask}", mask)
            test = f"{low} <= {moved.code} <= {high}"
        else:
            a, b = start.word, end.word
            moved = self.kept(f"({up} if {a} <= {b} else {down}) & {mask}", mask)
            test = f"{a} <= {moved.code} <= {b} or {b} <= {moved.code} <= {a}"
        self._write(instruction, moved)
        return test

    def _lookup(self, instruction: Instruction) -> None:
        index = self.kept(self.value(instruction.operands[0]).word, 0).code
        values = [self.value(item.values[0]) for item in instruction.items]
        if all(value.constant is not None for value in values):
            found = f"{tuple(value.constant for value in values)!r}[{index}]"
        else:
            found = "0"
            for place, value in reversed([*enumerate(values)]):
                found = f"({value.word} if {index} == {place} else {found})"
        self._when(f"{index} < {len(values)}", instruction, Text(found))

    def _lookdown(self, instruction: Instruction) -> None:
        target = self.kept(self.value(instruction.operands[0]).word, 0).code
        sign, found = _SIGNS[instruction.comparison], "-1"
        for place, item in reversed([*enumerate(instruction.items)]):
            found = f"({place} if {target} {sign} {self.value(item.values[0]).word} else {found})"
        place_name = self.kept(found, 0).code
        self._when(f"{place_name} >= 0", instruction, Text(place_name))

    def _when(self, test: str, instruction: Instruction, value: Text) -> None:
        """Write a store that happens under a condition."""
        self.line(f"if {test}:")
        self.depth += 1
        self._write(instruction, value)
        self.depth -= 1

    def _fixed(self, value: Text) -> Text:
        """Read a value now: what it is made of may change before it is used."""
        return value if value.constant is not None else self.kept(value.word, value.top)


def _leave(place: int | str, taken: int, counted: bool) -> str:
    took = f"t + {taken}" if counted else f"{taken}"
    return f"return ({place}, {took})"
