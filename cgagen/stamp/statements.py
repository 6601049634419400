"""One instruction as one PBASIC statement, in a form that the tokenizer encodes identically."""

from collections.abc import Callable

from cgagen.stamp.bits import refused
from cgagen.stamp.chips import Chip
from cgagen.stamp.list_items import input_text, output_text
from cgagen.stamp.opcodes import Tail
from cgagen.stamp.pins import PROGRAMMING_PORT
from cgagen.stamp.program import Expression, Instruction, Kind, constant_of, label_address
from cgagen.stamp.wording import (
    expression_text,
    operand_text,
    operator_text,
    pin_of,
    read_by,
    write_text,
)

_TEMPLATES = {
    # name: what stands behind the word; {items} is the list, {write} the variable
    **dict.fromkeys(("END", "STOP", "RETURN", "MAINIO", "AUXIO"), ""),
    **dict.fromkeys(("OUTPUT", "HIGH", "TOGGLE", "LOW", "REVERSE", "INPUT"), "{pin}"),
    **dict.fromkeys(("RUN", "STORE", "POLLRUN"), "{slot}"),
    **dict.fromkeys(("NAP", "PAUSE", "POLLWAIT"), "{period}"),
    **dict.fromkeys(("SHIFTIN", "SHIFTOUT"), "{data_pin}, {clock_pin}, {mode}, [{items}]"),
    **dict.fromkeys(("PULSIN", "RCTIME"), "{pin}, {state}, {write}"),
    **dict.fromkeys(("POLLIN", "POLLOUT"), "{pin}, {state}"),
    **dict.fromkeys(("LCDIN", "LCDOUT"), "{pin}, {command}, [{items}]"),
    **dict.fromkeys(("OWIN", "OWOUT"), "{pin}, {mode}, [{items}]"),
    **dict.fromkeys(("I2CIN", "I2COUT"), "{pin}, {slave}, {address}, [{items}]"),
    **dict.fromkeys(
        ("I2CIN_LOW", "I2COUT_LOW"), "{pin}, {slave}, {address}\\{low_address}, [{items}]"
    ),
    "SLEEP": "{seconds}",
    "GOTO": "{label}",
    "GOSUB": "{label}",
    "IF": "{condition} THEN {label}",
    "BRANCH": "{index}, [{labels}]",
    "LOOKUP": "{index}, [{items}], {write}",
    "LOOKDOWN": "{target}, {comparison} [{items}], {write}",
    "RANDOM": "{same}",
    "READ": "{location}, {write}",
    "WRITE": "{location}, {value}",
    "GET": "{location}, {write}",
    "PUT": "{location}, {value}",
    "FREQOUT": "{pin}, {duration}, {frequency}",
    "FREQOUT_TWO": "{pin}, {duration}, {frequency}, {second}",
    "DTMFOUT": "{pin}, {on_time}, {off_time}, [{items}]",
    "XOUT": "{pin}, {zero_pin}, [{items}]",
    "PULSOUT": "{pin}, {duration}",
    "COUNT": "{pin}, {duration}, {write}",
    "BUTTON": "{pin}, {down_state}, {delay}, {rate}, {same}, {target_state}, {label}",
    "PWM": "{pin}, {duty}, {duration}",
    "LCDCMD": "{pin}, {command}",
    "POLLMODE": "{mode}",
    "IOTERM": "{port}",
}

_READ_AND_WRITTEN = {"RANDOM": "variable", "BUTTON": "workspace"}
_OPERATOR_TOKENS = {"//": 0x14, "*": 0x12, "+": 0x0F, "~": 0x02}


def label_name(address: int) -> str:
    """Return the label of a stream address.

    >>> label_name(125)
    'L125'
    """
    return f"L{address}"


def pin_name(pin: int) -> str:
    """Return the PIN symbol of a pin, for the statements that need one.

    >>> pin_name(3)
    'Pin3'
    """
    return f"Pin{pin}"


def statement_text(instruction: Instruction, model: Chip) -> str:
    """Return an instruction as a statement; NEXT without its FOR is just NEXT.

    Raises:
        ImageError: PBASIC has no statement for it.
    """
    word = instruction.opcode.word
    if word == "LET":
        return f"{_write(instruction)} = {expression_text(instruction.operands[0])}"
    if word == "NEXT":
        return "NEXT"
    if word in ("SERIN", "SEROUT"):
        return _serial(instruction, model)
    named = {
        name: expression_text(operand)
        for name, operand in zip(instruction.form, instruction.operands, strict=True)
    }
    labels = [label_name(target) for target in instruction.targets]
    text = _TEMPLATES[instruction.name].format(
        **named,
        items=_items(instruction),
        write=write_text(instruction.write) if instruction.write else "",
        same=_same(instruction),
        label=labels[0] if labels else "",
        labels=", ".join(labels),
        comparison=operator_text(instruction.comparison) if instruction.comparison else "",
    )
    return f"{word} {text}".rstrip()


def changed_text(read: Expression, write: Expression, bit: int) -> str:
    """Return the name of what one statement reads and writes: a variable or a PIN symbol.

    Raises:
        ImageError: they are two different variables.
    """
    pin = pin_of(read, write)
    if pin is not None:
        return pin_name(pin)
    if read != read_by(write):
        raise refused(bit, "an instruction reads one variable and writes another")
    return write_text(write)


def _write(instruction: Instruction) -> str:
    if instruction.write is None:
        raise refused(instruction.address, f"{instruction.name} stores nothing")
    return write_text(instruction.write)


def _same(instruction: Instruction) -> str:
    operand = instruction.operand(_READ_AND_WRITTEN.get(instruction.name, ""))
    if operand is None or instruction.write is None:
        return ""
    return changed_text(operand, instruction.write, instruction.address)


def _items(instruction: Instruction) -> str:
    if Tail.OUTPUT in instruction.opcode.tail:
        quoted = instruction.opcode.word in ("SEROUT", "LCDOUT")
        return output_text(instruction.items, instruction.address, quoted)
    if Tail.INPUT in instruction.opcode.tail:
        return input_text(instruction.items, instruction.address)
    if instruction.name in _ITEMS:
        return _ITEMS[instruction.name](instruction)
    return ", ".join(expression_text(item.values[0]) for item in instruction.items)


def _shiftout_items(instruction: Instruction) -> str:
    return ", ".join(
        f"{operand_text(item.values[1])}\\{operand_text(item.values[0])}"
        for item in instruction.items
    )


def _shiftin_items(instruction: Instruction) -> str:
    words = []
    for item in instruction.items:
        if item.write is None or constant_of(item.values[1]) != 0:
            raise refused(instruction.address, "an item of SHIFTIN does not start from 0")
        words.append(f"{write_text(item.write)}\\{operand_text(item.values[0])}")
    return ", ".join(words)


def _xout_items(instruction: Instruction) -> str:
    """Undo what the tokenizer makes of house, key and cycles: house // 16 + key * 16, ~ cycles."""
    words = []
    for item in instruction.items:
        command, cycles = item.values
        split = _house_and_key(command)
        if split is None or cycles[-1] != (Kind.OPERATOR, _OPERATOR_TOKENS["~"], 0, False):
            raise refused(instruction.address, "an item of XOUT is not house, key and cycles")
        house, key = split
        words.append(f"{operand_text(house)}\\{operand_text(key)}\\{operand_text(cycles[:-1])}")
    return ", ".join(words)


def _house_and_key(command: Expression) -> tuple[Expression, Expression] | None:
    """Return the two expressions in front of `16 //`, and between it and `16 * +`."""
    head = ((Kind.CONSTANT, 16, 0, False), (Kind.OPERATOR, _OPERATOR_TOKENS["//"], 0, False))
    tail = (
        (Kind.CONSTANT, 16, 0, False),
        (Kind.OPERATOR, _OPERATOR_TOKENS["*"], 0, False),
        (Kind.OPERATOR, _OPERATOR_TOKENS["+"], 0, False),
    )
    if command[-3:] != tail:
        return None
    for cut in range(1, len(command) - 5):
        house, key = command[:cut], command[cut + 2 : -3]
        if command[cut : cut + 2] == head and _is_whole(house) and _is_whole(key):
            return house, key
    return None


def _is_whole(expression: Expression) -> bool:
    """Return whether an expression leaves one word and needs none from below."""
    depth = 0
    for token in expression:
        needed = 1 if token.indexed else 0
        if token.kind is Kind.OPERATOR:
            needed = 1 if token.value < 0x08 else 2
        if depth < needed:
            return False
        depth += 1 - needed
    return depth == 1


_ITEMS: dict[str, Callable[[Instruction], str]] = {
    "SHIFTOUT": _shiftout_items,
    "SHIFTIN": _shiftin_items,
    "XOUT": _xout_items,
}


def _serial(instruction: Instruction, model: Chip) -> str:
    """Return SERIN or SEROUT in the form that its operands tell, DEBUG where it is one."""
    items = _items(instruction)
    operand = {
        name: expression_text(value)
        for name, value in zip(instruction.form, instruction.operands, strict=True)
    }
    plain = len(instruction.operands) == instruction.opcode.operand_counts[0]
    port = operand["pin"] == str(PROGRAMMING_PORT) and operand["baud"] == str(model.debug_baud_word)
    word = instruction.opcode.word
    if plain and operand.get("timeout", "1") != "1":
        raise refused(instruction.address, f"{word} has a timeout without a label")
    if plain and port and "flow_pin" not in operand:
        return f"{'DEBUG' if word == 'SEROUT' else 'DEBUGIN'} {items}"
    pin = "\\".join(operand[name] for name in ("pin", "flow_pin") if name in operand)
    words = [pin, operand["baud"], *_serial_options(instruction, operand), f"[{items}]"]
    return f"{word} {', '.join(words)}"


def _serial_options(instruction: Instruction, operand: dict[str, str]) -> list[str]:
    """Return what stands between baud mode and list: pace, or labels and timeout."""
    words = []
    if "pace" in operand:
        words.append(operand["pace"])
    if "parity_target" in operand:
        words.append(_label_operand(instruction, "parity_target"))
        if operand["timeout_target"] == "0" and operand["timeout"] == "1":
            return words
    if "timeout_target" in operand:
        words += [operand["timeout"], _label_operand(instruction, "timeout_target")]
    return words


def _label_operand(instruction: Instruction, name: str) -> str:
    value = constant_of(instruction.operand(name) or ())
    address = None if value is None else label_address(value)
    if address is None:
        raise refused(instruction.address, f"{instruction.opcode.word} has a label that is none")
    return label_name(address)
