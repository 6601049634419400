"""The instruction codes and the operators of the token format, as tables.

Every row names its proof: a vector of `tests/vectors/tokens.json`, or a program under `tests/`,
whose image has the row in it. Ref: S3 for every code, order and form, each of them verified by
compiling and decoding again.
"""

from dataclasses import dataclass
from enum import StrEnum

from cgagen.stamp.chips import CHIPS, Chip


class Tail(StrEnum):
    """What follows an instruction's code in the stream, one part after the other."""

    ADDRESS = "ADDRESS"
    """14 bits: where to go on."""
    ADDRESSES = "ADDRESSES"
    """A list of addresses."""
    NUMBER = "NUMBER"
    """8 bits: which GOSUB this is, hence which return slot of the header it uses."""
    NEXT_BIT = "NEXT_BIT"
    """14 bits: the address of the bit behind them, always."""
    WRITE = "WRITE"
    """A write expression: it stores the value that the instruction makes."""
    COMPARISON = "COMPARISON"
    """3 bits: the comparison of LOOKDOWN, its operator's code less 18h."""
    STEP = "STEP"
    """An expression of two values: the counter of FOR, and its step."""
    VALUES = "VALUES"
    """A list of expressions of one value each."""
    PAIRS = "PAIRS"
    """A list of expressions of two values each."""
    OUTPUT = "OUTPUT"
    """A list of output items, expressions of one to three values."""
    INPUT = "INPUT"
    """A list of input items: values, none at all too, and a write expression after some."""
    SHIFTED = "SHIFTED"
    """A list of two values and a write expression: what SHIFTIN reads."""


@dataclass(frozen=True, slots=True)
class Opcode:
    """One instruction code on the chips that have it.

    Attributes:
        code: 6 bits.
        name: unique on a chip: the PBASIC word, with an ending where one word has two codes.
            LET is the end of an assignment.
        models: names of the chips where the code means this.
        forms: the operands by name in the order in which they are pushed; more than one form
            where their number tells what was written.
        tail: what follows the code.
        proof: where the row is met.
    """

    code: int
    name: str
    models: frozenset[str]
    forms: tuple[tuple[str, ...], ...]
    tail: tuple[Tail, ...]
    proof: str

    @property
    def word(self) -> str:
        """The word that a PBASIC statement starts with.

        >>> opcodes_of(CHIPS[0])[0x21].name, opcodes_of(CHIPS[0])[0x21].word
        ('SEROUT_FLOW', 'SEROUT')
        """
        return self.name.partition("_")[0]

    def form_of(self, operands: int) -> tuple[str, ...] | None:
        """Return the form of so many operands; None where there is none."""
        for form in self.forms:
            if len(form) == operands:
                return form
        return None

    @property
    def operand_counts(self) -> tuple[int, ...]:
        """How many operands each form has."""
        return tuple(len(form) for form in self.forms)


@dataclass(frozen=True, slots=True)
class Operator:
    """One operator on the stack of 16-bit words.

    Attributes:
        code: 6 bits.
        symbol: as PBASIC writes it.
        operands: 1, or 2 of which the second was pushed last.
        logical: as a condition writes it where that differs; "" elsewhere.
        proof: where the row is met.
    """

    code: int
    symbol: str
    operands: int
    logical: str
    proof: str


_BS2 = "BS2"
_E = "BS2e BS2sx"
_P = "BS2p BS2pe"
_ALL = f"{_BS2} {_E} {_P}"


def _op(code: int, name: str, models: str, operands: str, tail: str, proof: str) -> Opcode:
    return Opcode(
        code=code,
        name=name,
        models=frozenset(models.split()),
        forms=tuple(tuple(form.split()) for form in operands.split("|")),
        tail=tuple(Tail(part) for part in tail.split()),
        proof=proof,
    )


OPCODES: tuple[Opcode, ...] = (
    #   code  name           chips operands as pushed; tail; proof
    _op(0x00, "END",         _ALL, "", "", "end_only/BS2"),
    _op(0x01, "SLEEP",       _ALL, "seconds", "NEXT_BIT", "sleep_nap/BS2"),
    _op(0x02, "NAP",         _ALL, "period", "NEXT_BIT", "sleep_nap/BS2"),
    _op(0x03, "STOP",        _ALL, "", "", "decode/stop.bs2"),
    _op(0x04, "OUTPUT",      _ALL, "pin", "", "decode/pins.bs2"),
    _op(0x05, "HIGH",        _ALL, "pin", "", "pin_high/BS2"),
    _op(0x06, "TOGGLE",      _ALL, "pin", "", "for_step/BS2"),
    _op(0x07, "LOW",         _ALL, "pin", "", "blink/BS2"),
    _op(0x08, "REVERSE",     _ALL, "pin", "", "decode/pins.bs2"),
    _op(0x09, "GOTO",        _ALL, "", "ADDRESS", "goto/BS2"),
    _op(0x0A, "GOSUB",       _ALL, "", "NUMBER ADDRESS", "gosub/BS2"),
    _op(0x0B, "RETURN",      _ALL, "", "", "gosub/BS2"),
    _op(0x0C, "INPUT",       _ALL, "pin", "", "decode/pins.bs2"),
    _op(0x0D, "IF",          _ALL, "condition", "ADDRESS", "if_eq/BS2"),
    _op(0x0E, "NEXT",        _ALL, "end start", "STEP WRITE ADDRESS", "for_basic/BS2"),
    _op(0x0F, "BRANCH",      _ALL, "index", "ADDRESSES", "branch/BS2"),
    _op(0x10, "LOOKUP",      _ALL, "index", "VALUES WRITE", "lookup/BS2"),
    _op(0x11, "LOOKDOWN",    _ALL, "target", "COMPARISON VALUES WRITE", "lookdown/BS2"),
    _op(0x12, "RANDOM",      _ALL, "variable", "WRITE", "random/BS2"),
    _op(0x13, "READ",        _ALL, "location", "NEXT_BIT WRITE", "read/BS2"),
    _op(0x14, "WRITE",       _ALL, "value location", "NEXT_BIT", "write_multi/BS2"),
    _op(0x15, "PAUSE",       _ALL, "period", "", "pause/BS2"),
    _op(0x16, "FREQOUT",     _ALL, "pin duration frequency", "", "freqout/BS2"),
    _op(0x17, "FREQOUT_TWO", _ALL, "pin duration frequency second", "", "freqout/BS2"),
    _op(0x18, "DTMFOUT",     _ALL, "pin off_time on_time", "VALUES", "dtmfout/BS2"),
    _op(0x19, "XOUT",        _ALL, "pin zero_pin", "PAIRS", "xout/BS2"),
    _op(0x1A, "LET",         _BS2, "value", "", "const_0/BS2"),
    _op(0x1D, "LET",         _E,   "value", "", "decode/assign.bse"),
    _op(0x1F, "LET",         _P,   "value", "", "decode/scratch.bsp"),
    _op(0x1A, "GET",         _E,   "location", "WRITE", "get_put_multi/BS2E"),
    _op(0x1B, "PUT",         _E,   "location value", "", "get_put_multi/BS2E"),
    _op(0x1C, "RUN",         _E,   "slot", "", "run/BS2E"),
    _op(0x1A, "GET",         _P,   "location", "WRITE", "decode/scratch.bsp"),
    _op(0x1B, "PUT",         _P,   "location value", "", "decode/scratch.bsp"),
    _op(0x1C, "RUN",         _P,   "slot", "", "decode/scratch.bsp"),
    _op(0x1D, "MAINIO",      _P,   "", "", "mainio/BS2P"),
    _op(0x1E, "AUXIO",       _P,   "", "", "mainio/BS2P"),
    _op(0x20, "SEROUT",      _ALL, "baud pin | pace baud pin", "OUTPUT", "dbg_text/BS2"),
    _op(0x21, "SEROUT_FLOW", _ALL,
        "baud pin flow_pin "
        "| timeout_target timeout baud pin flow_pin",
        "OUTPUT", "serout_flow/BS2"),
    _op(0x22, "SERIN",       _ALL,
        "timeout baud pin "
        "| timeout_target timeout baud pin "
        "| parity_target timeout_target timeout baud pin",
        "INPUT", "serin/BS2"),
    _op(0x23, "SERIN_FLOW",  _ALL,
        "timeout baud pin flow_pin "
        "| timeout_target timeout baud pin flow_pin "
        "| parity_target timeout_target timeout baud pin flow_pin",
        "INPUT", "decode/serin_flow.bs2"),
    _op(0x24, "PULSOUT",     _ALL, "duration pin", "", "pulsout/BS2"),
    _op(0x25, "PULSIN",      _ALL, "state pin", "WRITE", "pulsin/BS2"),
    _op(0x26, "COUNT",       _ALL, "duration pin", "WRITE", "decode/pulses.bs2"),
    _op(0x27, "SHIFTIN",     _ALL, "mode data_pin clock_pin", "SHIFTED", "shiftin/BS2"),
    _op(0x28, "SHIFTOUT",    _ALL, "mode data_pin clock_pin", "PAIRS", "shiftout/BS2"),
    _op(0x29, "RCTIME",      _ALL, "state pin", "WRITE", "decode/pulses.bs2"),
    _op(0x2A, "BUTTON",      _ALL,
        "down_state delay rate target_state workspace pin",
        "WRITE ADDRESS", "button/BS2"),
    _op(0x2B, "PWM",         _ALL, "duty duration pin", "", "decode/pulses.bs2"),
    _op(0x2C, "LCDIN",       _P,   "command pin", "INPUT", "lcd/BS2P"),
    _op(0x2D, "LCDOUT",      _P,   "command pin", "OUTPUT", "lcd/BS2P"),
    _op(0x2E, "LCDCMD",      _P,   "command pin", "", "lcd/BS2P"),
    _op(0x2F, "I2CIN_LOW",   _P,   "low_address address slave pin", "INPUT", "i2cin/BS2P"),
    _op(0x30, "I2CIN",       _P,   "address slave pin", "INPUT", "i2cin/BS2P"),
    _op(0x31, "I2COUT_LOW",  _P,   "low_address address slave pin", "OUTPUT", "i2cout/BS2P"),
    _op(0x32, "I2COUT",      _P,   "address slave pin", "OUTPUT", "i2cout/BS2P"),
    _op(0x33, "POLLRUN",     _P,   "slot", "", "poll/BS2P"),
    _op(0x34, "POLLMODE",    _P,   "mode", "", "poll/BS2P"),
    _op(0x35, "POLLIN",      _P,   "state pin", "", "poll/BS2P"),
    _op(0x36, "POLLOUT",     _P,   "state pin", "", "poll/BS2P"),
    _op(0x37, "POLLWAIT",    _P,   "period", "NEXT_BIT", "poll/BS2P"),
    _op(0x38, "OWOUT",       _P,   "mode pin", "OUTPUT", "owire/BS2P"),
    _op(0x39, "OWIN",        _P,   "mode pin", "INPUT", "owire/BS2P"),
    _op(0x3A, "IOTERM",      _P,   "port", "", "mainio/BS2P"),
    _op(0x3B, "STORE",       _P,   "slot", "", "decode/scratch.bsp"),
)  # fmt: skip

OPERATORS: tuple[Operator, ...] = (
    #        code  symbol  operands logical proof
    Operator(0x00, "SQR",  1, "",    "decode/operators.bs2"),
    Operator(0x01, "ABS",  1, "",    "decode/operators.bs2"),
    Operator(0x02, "~",    1, "NOT", "un_not/BS2"),
    Operator(0x03, "-",    1, "",    "un_neg/BS2"),
    Operator(0x04, "DCD",  1, "",    "decode/operators.bs2"),
    Operator(0x05, "NCD",  1, "",    "decode/operators.bs2"),
    Operator(0x06, "COS",  1, "",    "decode/operators.bs2"),
    Operator(0x07, "SIN",  1, "",    "decode/operators.bs2"),
    Operator(0x08, "HYP",  2, "",    "decode/operators.bs2"),
    Operator(0x09, "ATN",  2, "",    "bin_atn/BS2"),
    Operator(0x0A, "&",    2, "AND", "decode/operators.bs2"),
    Operator(0x0B, "|",    2, "OR",  "decode/operators.bs2"),
    Operator(0x0C, "^",    2, "XOR", "decode/operators.bs2"),
    Operator(0x0D, "MIN",  2, "",    "decode/operators.bs2"),
    Operator(0x0E, "MAX",  2, "",    "decode/operators.bs2"),
    Operator(0x0F, "+",    2, "",    "bin_add/BS2"),
    Operator(0x10, "-",    2, "",    "decode/operators.bs2"),
    Operator(0x11, "*/",   2, "",    "decode/operators.bs2"),
    Operator(0x12, "*",    2, "",    "decode/operators.bs2"),
    Operator(0x13, "**",   2, "",    "decode/operators.bs2"),
    Operator(0x14, "//",   2, "",    "decode/operators.bs2"),
    Operator(0x15, "/",    2, "",    "decode/operators.bs2"),
    Operator(0x16, "DIG",  2, "",    "decode/operators.bs2"),
    Operator(0x17, "<<",   2, "",    "decode/operators.bs2"),
    Operator(0x18, ">>",   2, "",    "decode/operators.bs2"),
    Operator(0x19, "REV",  2, "",    "decode/operators.bs2"),
    Operator(0x1A, ">=",   2, "",    "lookdown/BS2"),
    Operator(0x1B, "<=",   2, "",    "select/BS2"),
    Operator(0x1C, "=",    2, "",    "if_eq/BS2"),
    Operator(0x1D, "<>",   2, "",    "decode/operators.bs2"),
    Operator(0x1E, ">",    2, "",    "select/BS2"),
    Operator(0x1F, "<",    2, "",    "do_while/BS2"),
)  # fmt: skip

_TABLES = {
    chip.name: {row.code: row for row in OPCODES if chip.name in row.models} for chip in CHIPS
}


def opcodes_of(model: Chip) -> dict[int, Opcode]:
    """Return the rows of a chip by code; treat it as constant."""
    return _TABLES[model.name]
