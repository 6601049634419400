"""A program as PBASIC that the tokenizer makes the same image of.

Variables have their fixed names, jump targets are labels of their stream address, and what the
tokenizer takes apart (IF with blocks, DO, SELECT) stays taken apart. Only FOR with its NEXT, and
ON with GOSUB, cannot be written otherwise and are put together again.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from cgagen.stamp.bits import refused
from cgagen.stamp.image import Image, Use
from cgagen.stamp.program import Expression, Instruction, Program, constant_of
from cgagen.stamp.statements import changed_text, label_name, pin_name, statement_text
from cgagen.stamp.wording import expression_text, pin_of

_DATA_PER_LINE = 16


@dataclass(frozen=True, slots=True)
class Line:
    """One line of a listing.

    Attributes:
        text: the statement, indented where no label is.
        address: the stream bit of its first token; None where it makes none.
    """

    text: str
    address: int | None = None


def listing(
    program: Program, image: Image, notes: Mapping[int, Sequence[str]] | None = None
) -> tuple[Line, ...]:
    """Return the lines of a program.

    Args:
        program: what `decode` made of the image.
        image: its bytes; flags tell reserved DATA from empty EEPROM.
        notes: comments to stand before the instruction of a stream bit.

    Raises:
        ImageError: the program cannot have come from the tokenizer; with the stream bit.
    """
    statements = _Statements(program)
    lines = [Line(f"' {{$STAMP {program.model.name}}}"), Line("' {$PBASIC 2.5}")]
    lines += [Line(f"{pin_name(pin)} PIN {pin}") for pin in sorted(statements.pins)]
    data = _data_lines(program, image)
    body: list[Line] = []
    for address, text in statements.texts:
        body += [Line(f"{'':8}' {note}") for note in (notes or {}).get(address, ())]
        label = f"{label_name(address)}:" if address in statements.labels else ""
        body.append(Line(f"{label:8}{' ' if len(label) >= 8 else ''}{text}".rstrip(), address))
    if not any(line.text.strip() for line in body):
        body.append(Line(f"{'':8}END", program.start_bit))
    return (*lines, *(line for line in body if line.text.strip()), *data)


def listing_text(
    program: Program, image: Image, notes: Mapping[int, Sequence[str]] | None = None
) -> str:
    """Return the lines as one source.

    Raises:
        ImageError: see `listing`.

    >>> from cgagen.stamp.chips import chip
    >>> from cgagen.stamp.decode import decode
    >>> image = Image(chip("BS2"), bytes(2044) + bytes.fromhex("140e07c0"))
    >>> print(listing_text(decode(image.eeprom, image.model), image), end="")
    ' {$STAMP BS2}
    ' {$PBASIC 2.5}
            HIGH 3
    """
    return "".join(f"{line.text}\n" for line in listing(program, image, notes))


class _Statements:
    """Statements in order, with the labels and PIN symbols that they need."""

    def __init__(self, program: Program) -> None:
        self._program = program
        self.labels: set[int] = set()
        self.pins: set[int] = set()
        self.texts: list[tuple[int, str]] = []
        self._fors = self._loops()
        self._open: list[Instruction] = []
        self._gosubs = 0
        index = 0
        while index < len(program.instructions) - 1:
            index += self._statement(index)
        if self._open:
            raise refused(self._open[-1].address, "a FOR has no NEXT behind it")
        self.texts.append((program.instructions[-1].address, ""))
        starts = {address for address, _ in self.texts}
        for target in sorted(self.labels - starts):
            raise refused(target, "a jump leads here, where no statement starts")

    def _loops(self) -> dict[int, Instruction]:
        """Return the NEXT of every FOR by the address of FOR's assignment."""
        by_end = {instruction.end: instruction for instruction in self._program.instructions}
        loops: dict[int, Instruction] = {}
        for instruction in self._program.instructions:
            if instruction.name != "NEXT":
                continue
            start = by_end.get(instruction.targets[0])
            if start is None or start.name != "LET" or start.address in loops:
                raise refused(instruction.address, "a NEXT has no FOR of its own")
            loops[start.address] = instruction
        return loops

    def _statement(self, index: int) -> int:
        """Add the statement of one instruction; return how many instructions it took."""
        instruction = self._program.instructions[index]
        took, targets = 1, instruction.targets
        if instruction.address in self._fors:
            text = self._for(instruction, self._fors[instruction.address])
        elif instruction.name == "NEXT":
            text, targets = self._next(instruction), ()
        elif instruction.name == "GOSUB":
            text, targets, took = self._gosub(index)
        else:
            text = statement_text(instruction, self._program.model)
            self._note_pin(instruction)
        self.labels.update(targets)
        self.texts.append((instruction.address, text))
        return took

    def _for(self, start: Instruction, end: Instruction) -> str:
        self._open.append(end)
        (counter, step) = end.items[0].values
        if start.write is None or end.write != start.write or end.operands[1] != start.operands[0]:
            raise refused(end.address, "a NEXT does not fit the assignment of its FOR")
        name = changed_text(counter, start.write, end.address)
        self._use_pin(counter, start.write)
        stepped = "" if constant_of(step) == 1 else f" STEP {expression_text(step)}"
        return (
            f"FOR {name} = {expression_text(start.operands[0])} "
            f"TO {expression_text(end.operands[0])}{stepped}"
        )

    def _next(self, instruction: Instruction) -> str:
        if not self._open or self._open.pop() is not instruction:
            raise refused(instruction.address, "a NEXT crosses another FOR")
        return "NEXT"

    def _gosub(self, index: int) -> tuple[str, tuple[int, ...], int]:
        """Return the text of GOSUB, or of ON with GOSUB, which is three instructions."""
        gosub, *following = self._program.instructions[index : index + 3]
        self._gosubs += 1
        slots = self._program.gosub_slots
        if gosub.number != self._gosubs or gosub.number > len(slots):
            raise refused(gosub.address, f"GOSUB has the number {gosub.number} out of order")
        back = slots[gosub.number - 1]
        if back == gosub.end:
            return statement_text(gosub, self._program.model), gosub.targets, 1
        names = [instruction.name for instruction in following]
        if names != ["BRANCH", "RETURN"] or back != following[1].end:
            raise refused(gosub.address, f"GOSUB {gosub.number} returns to a strange place")
        branch = following[0]
        labels = ", ".join(label_name(target) for target in branch.targets)
        return f"ON {expression_text(branch.operands[0])} GOSUB {labels}", branch.targets, 3

    def _note_pin(self, instruction: Instruction) -> None:
        if instruction.name in ("RANDOM", "BUTTON") and instruction.write is not None:
            read = instruction.operands[0 if instruction.name == "RANDOM" else 4]
            self._use_pin(read, instruction.write)

    def _use_pin(self, read: Expression, write: Expression) -> None:
        pin = pin_of(read, write)
        if pin is not None:
            self.pins.add(pin)


def _data_lines(program: Program, image: Image) -> list[Line]:
    """Return DATA for every byte below the program that has a value or is reserved."""
    lines: list[Line] = []
    limit = len(image.eeprom) - program.program_bytes
    uses = [
        flag & 3 if image.flags is not None else Use.DATA if byte else Use.EMPTY
        for flag, byte in zip(image.flags or image.eeprom, image.eeprom, strict=True)
    ][:limit]
    address = 0
    while address < limit:
        use, end = uses[address], address + 1
        most = limit if use == Use.RESERVED else min(limit, address + _DATA_PER_LINE)
        while end < most and uses[end] == use:
            end += 1
        if use == Use.RESERVED:
            lines.append(Line(f"{'':8}DATA @{address}, ({end - address})"))
        elif use == Use.DATA:
            values = ", ".join(map(str, image.eeprom[address:end]))
            lines.append(Line(f"{'':8}DATA @{address}, {values}"))
        address = end
    return lines
