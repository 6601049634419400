"""Where a main controller's image decides and what it decides by, found in the image itself.

No name and no spelling of the source is used: two sources that compile to the same instructions
are judged alike, whatever their author calls a variable.
"""

from dataclasses import dataclass

from cgagen.bench_protocol import TELEMETRY
from cgagen.errors import ImageError, LackingError, UnprovenError
from cgagen.robot import Robot
from cgagen.stamp.decode import decode
from cgagen.stamp.image import Image
from cgagen.stamp.program import Kind, Program, Token
from hil.followed import table_read
from hil.places import Place, Places, find_places
from hil.target import Stimulus


@dataclass(frozen=True, slots=True)
class Anchors:
    """The routine that decides, and its registers.

    Attributes:
        places: where it begins, and what sensing leaves where.
        read: stream address of the READ that looks the answer up.
        state: the register by which it does.
    """

    places: Places
    read: int
    state: Place

    def sensed(self, words: list[int], stimulus: Stimulus) -> list[int]:
        """Return a register file as sensing leaves it."""
        words = list(words)
        counts = (*stimulus.sonars, *stimulus.lights)
        for word, count in zip(self.places.words, counts, strict=True):
            words[word] = count
        for bit, bent in zip(self.places.antennas, stimulus.touched, strict=True):
            words[bit >> 4] = words[bit >> 4] & ~(1 << (bit & 15)) | (not bent) << (bit & 15)
        return words

    def state_in(self, words: list[int]) -> int:
        """Return the state that a register file says."""
        word, shift, mask = self._state_bits
        return words[word] >> shift & mask

    def with_state(self, words: list[int], state: int) -> list[int]:
        """Return a register file with another state."""
        word, shift, mask = self._state_bits
        words = list(words)
        words[word] = words[word] & ~(mask << shift) | (state & mask) << shift
        return words

    @property
    def _state_bits(self) -> tuple[int, int, int]:
        size, element = self.state
        word, shift = divmod(size * element, 16)
        return word, shift, (1 << size) - 1


def anchors_of(image: Image, robot: Robot) -> Anchors:
    """Return where an image decides.

    Raises:
        LackingError: it does not sense, decide and look its answer up as every generated
            program does; the sentence says what is missing.
    """
    try:
        program = decode(image.eeprom, image.model)
        places = find_places(program, robot)
        read, state = table_read(program, _routine(program, places.entry))
    except (ImageError, UnprovenError) as error:
        raise LackingError(str(error)) from error
    return Anchors(places, read, state)


def number_place(image: Image) -> Place:
    """Return the register whose number telemetry says first, the decision's.

    Raises:
        LackingError: no line is said that begins so.
    """
    try:
        program = decode(image.eeprom, image.model)
    except ImageError as error:
        raise LackingError(str(error)) from error
    for one in program.instructions:
        if one.name == "SEROUT":
            tokens = [token for item in one.items for part in item.values for token in part]
            first = next((token for token in tokens if token.kind is Kind.READ), None)
            if first and not first.indexed and tokens[0] == Token(Kind.CONSTANT, ord(TELEMETRY)):
                return first.size_bits, first.value
    raise LackingError(f'no statement says "{TELEMETRY}" and the number of a variable behind it')


def _routine(program: Program, entry: int) -> set[int]:
    """Return the addresses that a routine may come to, up to its RETURN."""
    found, ahead = set[int](), [entry]
    while ahead:
        instruction = program.at(ahead.pop())
        if instruction is None or instruction.address in found:
            continue
        found.add(instruction.address)
        ahead += instruction.targets
        if instruction.name not in ("GOTO", "RETURN", "END", "STOP"):
            ahead.append(instruction.end)
    return found
