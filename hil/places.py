"""Where a main controller's image keeps what it senses, found in the image itself.

A sensor's word is the register that PULSIN or RCTIME on the sensor's pin stores in; an antenna's
bit is the one that its pin is copied to. The routine that decides is the one that is called
next, with nothing in between. So no name of the source is trusted, and a source that was edited
cannot mislead.

The bits beside the antennas', of the same nibble, are 0 from a reset on: nothing in the program
stores anything else there, but SERIN, which is a host's doing.
"""

from dataclasses import dataclass

from cgagen.errors import UnprovenError
from cgagen.robot import Robot
from cgagen.stamp.opcodes import Tail
from cgagen.stamp.program import Expression, Instruction, Kind, Program, constant_of
from hil.abstract import BITS, OUTS_BIT, VARIABLES_BIT

MEASURING = ("PULSIN", "RCTIME")
_QUIET = frozenset("LET LOW HIGH INPUT OUTPUT PULSOUT PULSIN RCTIME PAUSE".split())
_CHANGING = frozenset(
    "WRITE STORE RUN AUXIO IOTERM POLLRUN POLLMODE POLLIN POLLOUT POLLWAIT".split()
)
"""What could change the table, the program or the pins behind the routine's back."""

_HOST = ("SERIN", "SERIN_FLOW")

Place = tuple[int, int]
"""A register: its bits, and its number among those of that size."""


@dataclass(frozen=True, slots=True)
class Places:
    """The routine that decides, and what it is told by where.

    Attributes:
        entry: stream address of its first instruction.
        call: number of the GOSUB that calls it after sensing.
        stop: where that GOSUB returns.
        names: of the sensors that give words: sonars, then light sensors.
        words: register word of each, 0 to 15.
        antennas: register bit of each antenna, left and right.
        look: stream address of the GOSUB that calls sensing.
        lines: register bits of the command lines' latch, bit 0 of the command first.
        step_line: its pin; None without one.
    """

    entry: int
    call: int
    stop: int
    names: tuple[str, ...]
    words: tuple[int, ...]
    antennas: tuple[int, ...]
    look: int
    lines: tuple[int, ...]
    step_line: int | None


def find_places(program: Program, robot: Robot) -> Places:
    """Return where a program keeps what it senses.

    Raises:
        UnprovenError: the program does not sense and then decide in a way that can be followed.
    """
    changing = [one for one in program.instructions if one.name in _CHANGING]
    if changing:
        raise UnprovenError(
            f"{robot.name}: the program has {changing[0].name} at stream bit "
            f"{changing[0].address}, which can change what the decision is made with"
        )
    pins, names = _sensors(robot)
    sense = _sensing_call(program, pins, robot)
    measured, copied = _stores(program, sense, robot)
    decide = program.at(program.gosub_slots[sense.number - 1])
    if decide is None or decide.name != "GOSUB":
        raise UnprovenError(f"{robot.name}: no routine is called directly after sensing")
    words, antennas = _sensor_places(measured, copied, pins, robot)
    _check_beside(program, antennas, robot)
    line = robot.link.step_line
    return Places(
        decide.targets[0],
        decide.number,
        program.gosub_slots[decide.number - 1],
        names,
        words,
        antennas,
        sense.address,
        tuple(OUTS_BIT + pin for pin in robot.link.main_pins),
        line.main_pin if line else None,
    )


def _sensors(robot: Robot) -> tuple[tuple[int, ...], tuple[str, ...]]:
    """Return the pin that each word is measured at, and its name."""
    sonars = [(sonar.pins[-1], f"sonar {sonar.name}") for sonar in robot.sonars]
    lights = [
        (one.pin, f"light {one.name}") for one in (robot.light.sensors if robot.light else ())
    ]
    pins, names = zip(*sonars, *lights, strict=True)
    return pins, names


def _body(program: Program, entry: int) -> list[Instruction] | None:
    """Return a routine without branches, up to its RETURN; None for any other."""
    body, instruction = [], program.at(entry)
    while instruction is not None and instruction.name in _QUIET:
        body.append(instruction)
        instruction = program.at(instruction.end)
    return body if instruction is not None and instruction.name == "RETURN" else None


def _sensing_call(program: Program, pins: tuple[int, ...], robot: Robot) -> Instruction:
    """Return the only GOSUB of the only routine that measures at all these pins."""
    found = []
    for call in program.instructions:
        body = _body(program, call.targets[0]) if call.name == "GOSUB" else None
        if body and set(pins) <= {_pin(one) for one in body if one.name in MEASURING}:
            found.append(call)
    if len(found) != 1:
        raise UnprovenError(
            f"{robot.name}: {len(found) or 'no'} calls of a routine without branches that measures "
            "at the pins of all sensors, where there is one in a generated program"
        )
    return found[0]


def _stores(
    program: Program, sense: Instruction, robot: Robot
) -> tuple[dict[int, Place], dict[int, Place]]:
    """Return what is stored where while sensing, by pin: measurements, and copies of levels."""
    measured: dict[int, Place] = {}
    copied: dict[int, Place] = {}
    taken: set[int] = set()
    for one in _body(program, sense.targets[0]) or ():
        if one.write is None:
            continue
        place, pin = _fixed_place(one.write), _pin(one)
        bits = set() if place is None else {place[0] * place[1] + n for n in range(place[0])}
        if place is None or pin is None or bits & taken or min(bits) < VARIABLES_BIT:
            raise UnprovenError(
                f"{robot.name}: what {one.name} at stream bit {one.address} stores while sensing "
                "is not one sensor's alone"
            )
        taken |= bits
        (copied if one.name == "LET" else measured)[pin] = place
    return measured, copied


def _sensor_places(
    measured: dict[int, Place], copied: dict[int, Place], pins: tuple[int, ...], robot: Robot
) -> tuple[tuple[int, ...], tuple[int, ...]]:
    words = [measured[pin] for pin in pins]
    antennas = [copied.get(antenna.pin, (0, 0)) for antenna in robot.antennas]
    if any(size != 16 for size, _ in words) or any(size != 1 for size, _ in antennas):
        raise UnprovenError(
            f"{robot.name}: a count is not stored in a word, or an antenna not in a bit"
        )
    return tuple(word for _, word in words), tuple(bit for _, bit in antennas)


def _check_beside(program: Program, antennas: tuple[int, ...], robot: Robot) -> None:
    """Refuse a program that may store something beside the antennas."""
    beside = {(bit & ~3) + n for bit in antennas for n in range(4)} - set(antennas)
    for one in program.instructions:
        if one.name in _HOST:
            continue
        writes = [one.write, *(item.write for item in one.items)]
        strings = Tail.INPUT in one.opcode.tail  # they have no write token of their own
        if strings or any(write and beside & _ones(one, write) for write in writes):
            raise UnprovenError(
                f"{robot.name}: {one.name} at stream bit {one.address} may store something beside "
                "the antennas, whose nibble the decision may look at"
            )


def _ones(instruction: Instruction, write: Expression) -> set[int]:
    """Return the register bits that an instruction may set to 1."""
    place = _fixed_place(write)
    if place is None:
        return set(range(VARIABLES_BIT, BITS))
    size, element = place
    value = constant_of(instruction.operands[0]) if instruction.name == "LET" else None
    return {size * element + n for n in range(size) if value is None or value >> n & 1}


def _pin(instruction: Instruction) -> int | None:
    """Return the pin that an instruction measures, or whose level a LET copies."""
    if instruction.name in MEASURING:
        pin = instruction.operand("pin")
        return None if pin is None else constant_of(pin)
    if instruction.name == "LET" and len(instruction.operands[0]) == 1:
        kind, value, size_bits, indexed = instruction.operands[0][0]
        if kind is Kind.READ and size_bits == 1 and value < 16 and not indexed:
            return value
    return None


def _fixed_place(write: Expression) -> Place | None:
    """Return the register of a write whose index, if any, is a constant."""
    *index, target = write
    if not target.indexed and not index:
        return target.size_bits, target.value
    if target.indexed and len(index) == 1 and index[0].kind is Kind.CONSTANT:
        return target.size_bits, target.value + index[0].value
    return None
