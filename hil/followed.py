"""What a main controller's image may do with any reading, from one look to the next."""

from itertools import product

from cgagen.errors import UnprovenError
from cgagen.stamp.compiled import SourceMap
from cgagen.stamp.image import Image
from cgagen.stamp.program import Kind, Program
from hil.afterwards import flow_afterwards
from hil.dataflow import Flow, flow_of
from hil.places import Place, Places

POSITIONS = tuple(product((False, True), repeat=2))
"""Of the antennas: left and right, touched or not."""


def followed(
    program: Program, image: Image, places: Places, source_map: SourceMap | None
) -> tuple[Flow, Place]:
    """Follow an image from its look to its next one.

    Args:
        program: decoded.
        image: that it is in.
        places: where it senses and decides.
        source_map: for line numbers in reasons.

    Returns:
        What the routine that decides may do, for all positions of the antennas; and the register
        of the state that it names.

    Raises:
        UnprovenError: something is done that is not understood; the text says what, and where.
    """
    flow = _decision(program, image, places)
    rest = flow_afterwards(program, image.eeprom, places)
    for bit, reason in rest.refused.items():
        flow.refused.setdefault(bit, f"after the decision, {reason}")
    if not rest.exits and not rest.refused:
        flow.refused.setdefault(places.stop, "after the decision, nothing is sensed again")
    if flow.refused:
        reasons = sorted(flow.refused.items())
        raise UnprovenError("; ".join(f"{_where(bit, source_map)}: {why}" for bit, why in reasons))
    _, state = table_read(program, flow.visited)
    size, element = state
    if flow.loose & set(places.lines):
        raise UnprovenError("the decision does not always set the command lines to a known number")
    if flow.loose & set(range(size * element, size * element + size)):
        raise UnprovenError("the decision does not always leave a known number as its state")
    return flow, state


def _decision(program: Program, image: Image, places: Places) -> Flow:
    """Return what the routine that decides may do, for all positions of the antennas."""
    whole = Flow()
    for touched in POSITIONS:
        flow = flow_of(program, image.eeprom, places, tuple(not bent for bent in touched))
        whole.criticals.add(flow.criticals)
        whole.visited |= flow.visited
        whole.loose |= flow.loose
        whole.refused |= flow.refused
        if not flow.exits and not flow.refused:
            whole.refused[places.entry] = "the routine does not return"
    return whole


def _where(bit: int, source_map: SourceMap | None) -> str:
    statement = None if source_map is None else source_map.at_bit(bit)
    return f"stream bit {bit}" if statement is None else f"line {statement.line}"


def table_read(program: Program, visited: set[int]) -> tuple[int, Place]:
    """Return where the answer is looked up, and by which register: the only one in the only READ.

    Raises:
        UnprovenError: there is no such READ, or more than one.
    """
    reads = [one for one in program.instructions if one.address in visited and one.name == "READ"]
    tokens = [token for one in reads for token in one.operands[0] if token.kind is Kind.READ]
    if len(reads) != 1 or len(tokens) != 1 or tokens[0].indexed:
        raise UnprovenError("the answer is not looked up by one register, the state")
    return reads[0].address, (tokens[0].size_bits, tokens[0].value)
