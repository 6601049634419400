"""What a program does between deciding and sensing again, by data-flow over its tokens.

The proof puts readings to the routine that decides. That its answer is also what the robot does,
for every reading alike, needs this: from the end of the routine to the next look, nothing that
was sensed or decided has a say in where the program goes or in what it does to its pins. Then
all readings with one answer fare alike, and eight answers are tried through the pins. What was
sensed and decided may be told, by SEROUT, and counted with.

The step line may go either way. Everything else that is not understood is refused, by name.
"""

from collections.abc import Callable, Iterator

from cgagen.stamp.program import Expression, Instruction, Kind, Program, Token
from hil.abstract import (
    VARIABLES_BIT,
    Memory,
    Refused,
    Unset,
    Value,
    nothing_known,
    place_of,
    written,
)
from hil.dataflow import Flow, State, Walk
from hil.places import Places


def flow_afterwards(program: Program, eeprom: bytes, places: Places) -> Flow:
    """Follow a program from the end of its decision to its next look.

    Args:
        program: decoded.
        eeprom: its bytes, for READ.
        places: where it decides and senses.

    Returns:
        No exits where it never looks again.
    """
    return _Rest(program, eeprom, places).run(places.stop, tuple(nothing_known()))


class _Rest(Walk):
    """Visits all states; a register that depends on what was sensed is unknown."""

    def _after(self, state: State) -> Iterator[State]:
        if state.address == self._places.look:
            if state.calls:
                raise Refused("senses again out of a routine, so calls pile up")
            self._flow.exits += 1
            return
        one = self._program.at(state.address)
        step = None if one is None else _STEPS.get(one.name)
        ways = super()._after(state) if one is None or step is None else step(self, one, state)
        try:
            yield from list(ways)
        except Unset as unset:
            raise Refused(
                f"{one.name if one else 'what follows'} may depend on what was sensed or decided, "
                f"in bit {unset.bit} of the register file"
            ) from None

    def _let(self, one: Instruction, state: State) -> Iterator[State]:
        """Store a number, or what depends on what was sensed."""
        try:
            yield from list(super()._let(one, state))
        except Refused:
            *index, target = one.write or ()
            for stack in self._stacks(tuple(index), state.memory, ()):
                element, _ = self._element(target, stack)
                if place_of(element, target.size_bits) < VARIABLES_BIT:
                    raise
                memory = written(state.memory, target.size_bits, element, None)
                yield State(one.end, state.calls, memory)

    def _write(
        self, memory: Memory, target: Token, stack: tuple[Value, ...], value: Value
    ) -> Memory:
        """Store a number; what pins are is never known here, as other instructions change them."""
        element, _ = self._element(target, stack)
        if place_of(element, target.size_bits) < VARIABLES_BIT:
            return memory
        return written(memory, target.size_bits, element, value)

    def _if(self, one: Instruction, state: State) -> Iterator[State]:
        if self._asks_step_line(one.operands[0]):
            yield state._replace(address=one.targets[0])
            yield state._replace(address=one.end)
        else:
            yield from super()._if(one, state)

    def _asks_step_line(self, condition: Expression) -> bool:
        """Whether the step line's level is all that a condition depends on."""
        reads = [token for token in condition if token.kind is Kind.READ]
        line = self._places.step_line
        return bool(reads) and all(
            (one.value, one.size_bits, one.indexed) == (line, 1, False) for one in reads
        )

    def _return(self, one: Instruction, state: State) -> Iterator[State]:
        if not state.calls:
            raise Refused("RETURN from where nobody has called")
        yield from super()._return(one, state)

    def _with_numbers(self, one: Instruction, state: State) -> Iterator[State]:
        """Work pins or wait, with numbers that are known."""
        for name, operand in zip(one.form, one.operands, strict=True):
            self._number(operand, state, f"{name} of {one.name}")
        yield state._replace(address=one.end)


_STEPS: dict[str, Callable[[_Rest, Instruction, State], Iterator[State]]] = {
    "LET": _Rest._let,
    "IF": _Rest._if,
    "RETURN": _Rest._return,
    **dict.fromkeys(
        ("PAUSE", "HIGH", "LOW", "INPUT", "OUTPUT", "PULSOUT", "SEROUT"), _Rest._with_numbers
    ),
}
"""What is other than in the routine that decides. What SEROUT says does not matter."""
