"""Random PBASIC 2.5 programs over every instruction of a chip, the same ones for the same seed."""

import random
from collections.abc import Callable

from cgagen.stamp.chips import Chip

UNARY = ("SQR", "ABS", "~", "-", "DCD", "NCD", "COS", "SIN")
BINARY = "HYP ATN & | ^ MIN MAX + - */ * ** // / DIG << >> REV".split()
COMPARISONS = (">=", "<=", "=", "<>", ">", "<")

DECLARATIONS = """\
wa VAR Word
wb VAR Word
ba VAR Byte
bb VAR Byte(4)
na VAR Nib
nb VAR Nib(3)
ta VAR Bit
tb VAR Bit(5)
upper VAR wa.HIGHBYTE
Led PIN 7
Key PIN 12
Limit CON 300
"""

WRITABLE = (
    "wa wb ba na ta bb nb tb Led upper W9 W12 B20 B25 OUTS OUTL OUTC OUT9 DIRS DIRH DIRA DIR15 "
    "wa.NIB2 wb.BIT11 ba.LOWNIB ba.BIT7 wb.HIGHBYTE.HIGHNIB B21.NIB1 INS"
).split()
READABLE = [*WRITABLE, "IN3", "INL", "INH", "IND", "INS", "Key"]
INDEXED = "wa wb ba bb nb tb W3 B3 OUT0 IN0 DIRA wa.LOWBIT wb.LOWNIB INS".split()


class RandomProgram:
    """One program.

    Args:
        seed: which one.
        model: for which chip; its own instructions are among the statements.
    """

    def __init__(self, seed: int, model: Chip) -> None:
        self._random = random.Random(f"{seed} {model.name}")
        self._model = model
        self._labels = [f"place{number}" for number in range(6)]
        self._kinds: list[Callable[[], str]] = [*self._all_chips(), *self._structures()]
        if model.name != "BS2":
            self._kinds += self._scratch_chips()
        if model.name.startswith("BS2p"):
            self._kinds += self._p_chips()

    def source(self, statements: int = 14) -> str:
        """Return the source: every label defined, every block closed."""
        lines = [f"' {{$STAMP {self._model.name}}}", "' {$PBASIC 2.5}", *DECLARATIONS.split("\n")]
        pending = list(self._labels)
        for _ in range(statements):
            if pending and self._random.random() < 0.4:
                lines.append(f"{pending.pop()}:")
            lines.append(self._statement(depth=0))
        lines += [f"{label}:" for label in pending]
        lines += self._data()
        return "\n".join(lines) + "\n"

    def _statement(self, depth: int) -> str:
        self._depth = depth
        return self._random.choice(self._kinds)()

    def _block(self) -> str:
        depth = self._depth
        lines = []
        for _ in range(self._random.randint(1, 2)):
            self._depth = depth + 1
            if depth >= 2:
                lines.append(f"TOGGLE {self._pin()}")
            else:
                lines.append(self._statement(depth + 1))
        self._depth = depth
        return "\n".join(lines)

    def _const(self) -> str:
        number = min(65535, self._random.getrandbits(self._random.randint(1, 17)))
        forms = (str(number), f"${number:X}", f"%{number:b}", "Limit", '"A"')
        return self._random.choices(forms, (10, 2, 1, 1, 1))[0]

    def _index(self) -> str:
        return self._expr(2) if self._random.random() < 0.5 else str(self._random.randint(0, 5))

    def _atom(self) -> str:
        kind = self._random.random()
        if kind < 0.4:
            return self._const()
        if kind < 0.8:
            return self._random.choice(READABLE)
        return f"{self._random.choice(INDEXED)}({self._index()})"

    def _expr(self, cells: int = 3) -> str:
        kind = self._random.random()
        if cells <= 1 or kind < 0.45:
            return self._atom()
        if kind < 0.6:
            operand = self._expr(cells - 1)
            text = operand if operand.replace("_", "").isalnum() else f"({operand})"
            return f"{self._random.choice(UNARY)} {text}"
        right = self._expr(cells - 1)
        if " " in right:
            right = f"({right})"
        return f"{self._expr(cells - 1)} {self._random.choice(BINARY)} {right}"

    def _condition(self, depth: int = 2) -> str:
        kind = self._random.random()
        if depth == 0 or kind < 0.5:
            if kind < 0.08:
                return self._expr(2)
            comparison = self._random.choice(COMPARISONS)
            return f"{self._expr(2)} {comparison} {self._expr(2)}"
        if kind < 0.6:
            return f"NOT {self._condition(0)}"
        word = self._random.choice(("AND", "OR", "XOR"))
        left, right = self._condition(depth - 1), self._condition(depth - 1)
        if self._random.random() < 0.4:
            right = f"({right})"
        return f"{left} {word} {right}"

    def _target(self) -> str:
        return self._random.choice(self._labels)

    def _write(self) -> str:
        if self._random.random() < 0.3:
            return f"{self._random.choice(INDEXED)}({self._index()})"
        return self._random.choice(WRITABLE)

    def _some(self, item: Callable[[], str], most: int = 3) -> str:
        return ", ".join(item() for _ in range(self._random.randint(1, most)))

    def _pin(self) -> str:
        computed = f"{self._random.choice(READABLE)} + {self._expr(1)}"
        pins = (str(self._random.randint(0, 15)), "Led", computed)
        return self._random.choices(pins, (3, 1, 1))[0]

    def _text(self) -> str:
        return '"' + "".join(self._random.choices("abc XYZ09!'{$}:", k=3)) + '"'

    def _formatter(self, also: tuple[str, ...] = ()) -> str:
        words = "DEC SDEC HEX IHEX SHEX ISHEX BIN IBIN SBIN ISBIN".split()
        word = self._random.choice([*words, *also])
        most = {"C": 5, "X": 4, "N": 16}.get(word[-1], 0)
        digits = self._random.randint(0, most)
        return f"{word}{digits or ''}"

    def _output(self) -> str:
        x, n = self._expr(2), self._expr(2)
        forms = (
            x,
            self._text(),
            "CR",
            f"{self._formatter()} {x}",
            f"STR bb\\{n}",
            "STR ba",
            "STR OUTH\\2",
            f"REP {x}\\{n}",
            f"DEC ? {x}",
            "? wb",
        )
        return self._random.choice(forms)

    def _input(self) -> str:
        v, x = self._write(), self._expr(2)
        forms = [
            v,
            f"{self._formatter(('NUM', 'SNUM'))} {v}",
            f"STR bb\\{x}",
            f"STR bb\\4\\{x}",
            f"SKIP {x}",
            "WAITSTR bb",
            f"WAITSTR bb\\{x}",
            f'WAIT("{self._random.choice(("a", "abc", "sixchr"))}")',
            f"WAIT({x}, 3)",
        ]
        if self._model.name.startswith("BS2p"):
            forms.append(f"SPSTR {x}")
        return self._random.choice(forms)

    def _stored(self) -> str:
        return self._random.choice((self._expr(2), f"WORD {self._expr(2)}"))

    def _fetched(self) -> str:
        return self._random.choice((self._write(), "WORD wa", "WORD wb(2)"))

    def _serial_options(self, serin: bool) -> str:
        flow = self._random.random() < 0.4
        pin = f"{self._pin()}\\{self._pin()}" if flow else self._random.choice((self._pin(), "16"))
        options = [""]
        if flow or serin:
            options.append(f"{self._expr(1)}, {self._target()}, ")
        if not flow and not serin:
            options.append(f"{self._expr(1)}, ")
        if serin:
            options += [
                f"{self._target()}, ",
                f"{self._target()}, {self._expr(1)}, {self._target()}, ",
            ]
        return f"{pin}, {self._expr(1)}, {self._random.choice(options)}"

    def _all_chips(self) -> list[Callable[[], str]]:
        e, p, w, t = self._expr, self._pin, self._write, self._target
        one_pin = "OUTPUT HIGH TOGGLE LOW REVERSE INPUT".split()
        return [
            lambda: f"{w()} = {e(4)}",
            lambda: f"{w()} = {e(5)}",
            lambda: f"{self._random.choice(one_pin)} {p()}",
            lambda: self._random.choice(("END", "STOP", "RETURN")),
            lambda: f"{self._random.choice(('SLEEP', 'NAP', 'PAUSE'))} {e()}",
            lambda: f"GOTO {t()}",
            lambda: f"GOSUB {t()}",
            lambda: f"IF {self._condition()} THEN {t()}",
            lambda: f"BRANCH {e()}, [{self._some(t)}]",
            lambda: f"ON {e()} GOTO {self._some(t)}",
            lambda: f"ON {e()} GOSUB {self._some(t)}",
            lambda: f"LOOKUP {e()}, [{self._some(e)}, {self._text()}], {w()}",
            lambda: f"LOOKDOWN {e()}, {self._comparison()} [{self._some(e)}], {w()}",
            lambda: f"RANDOM {self._random.choice(('wa', 'ba', 'Led', 'Key', 'wb(2)'))}",
            lambda: f"READ {e(2)}, {self._some(self._fetched)}",
            lambda: f"WRITE {e(2)}, {self._some(self._stored)}",
            lambda: f"FREQOUT {p()}, {e()}, {e()}",
            lambda: f"FREQOUT {p()}, {e()}, {e()}, {e()}",
            lambda: f"DTMFOUT {p()}, [{self._some(e)}]",
            lambda: f"DTMFOUT {p()}, {e()}, {e()}, [{self._some(e)}]",
            lambda: f"XOUT {p()}, {p()}, [{e(2)}\\{e(2)}, {e(2)}\\{e(2)}\\{e(2)}]",
            lambda: f"DEBUG {self._some(self._output, 4)}",
            lambda: f"SEROUT {self._serial_options(False)}[{self._some(self._output)}]",
            lambda: f"DEBUGIN {self._some(self._input, 4)}",
            lambda: f"SERIN {self._serial_options(True)}[{self._some(self._input)}]",
            lambda: f"PULSOUT {p()}, {e()}",
            lambda: f"PULSIN {p()}, {e()}, {w()}",
            lambda: f"RCTIME {p()}, {e()}, {w()}",
            lambda: f"COUNT {p()}, {e()}, {w()}",
            lambda: f"PWM {p()}, {e()}, {e()}",
            lambda: f"SHIFTOUT {p()}, {p()}, {e(2)}, [{e()}\\{e()}, {e()}]",
            lambda: f"SHIFTIN {p()}, {p()}, {e(2)}, [{w()}\\{e()}, {w()}]",
            lambda: (
                f"BUTTON {p()}, {e(2)}, {e(2)}, {e(1)}, "
                f"{self._random.choice(('ba', 'bb(2)', 'Led', 'B25'))}, {e(1)}, {t()}"
            ),
        ]

    def _comparison(self) -> str:
        return self._random.choice((*COMPARISONS, ""))

    def _scratch_chips(self) -> list[Callable[[], str]]:
        return [
            lambda: f"GET {self._expr(2)}, {self._some(self._fetched)}",
            lambda: f"PUT {self._expr(2)}, {self._some(self._stored)}",
            lambda: f"RUN {self._expr()}",
        ]

    def _p_chips(self) -> list[Callable[[], str]]:
        e, p, outs, ins = self._expr, self._pin, self._output, self._input
        one = "IOTERM STORE POLLRUN POLLMODE POLLWAIT".split()
        return [
            lambda: self._random.choice(("MAINIO", "AUXIO")),
            lambda: f"{self._random.choice(one)} {e()}",
            lambda: f"{self._random.choice(one)} {e()}",
            lambda: f"{self._random.choice(('POLLIN', 'POLLOUT', 'LCDCMD'))} {p()}, {e()}",
            lambda: f"LCDOUT {p()}, {e()}, [{self._some(outs)}]",
            lambda: f"LCDIN {p()}, {e()}, [{self._some(ins)}]",
            lambda: f"OWOUT {p()}, {e()}, [{self._some(outs)}]",
            lambda: f"OWIN {p()}, {e()}, [{self._some(ins)}]",
            lambda: f"I2COUT {p()}, {e(2)}, {self._address()}[{self._some(outs)}]",
            lambda: f"I2CIN {p()}, {e(2)}, {self._address()}[{self._some(ins)}]",
        ]

    def _address(self) -> str:
        a = self._expr(2)
        return self._random.choice(("", f"{a}, ", f"{a}\\{self._expr(2)}, "))

    def _structures(self) -> list[Callable[[], str]]:
        c, b = self._condition, self._block
        return [
            lambda: f"IF {c()} THEN\n{b()}\nENDIF",
            lambda: f"IF {c()} THEN\n{b()}\nELSE\n{b()}\nENDIF",
            lambda: f"IF {c()} THEN\n{b()}\nELSEIF {c()} THEN\n{b()}\nELSE\n{b()}\nENDIF",
            lambda: f"IF {c()} THEN HIGH 1 ELSE LOW {self._pin()}",
            lambda: f"DO\n{b()}\nIF {c(0)} THEN EXIT\nLOOP",
            lambda: f"DO {self._random.choice(('WHILE', 'UNTIL'))} {c()}\n{b()}\nLOOP",
            lambda: f"DO\n{b()}\nLOOP {self._random.choice(('WHILE', 'UNTIL'))} {c()}",
            self._for,
            self._select,
        ]

    def _for(self) -> str:
        counter = self._random.choice(("wa", "ba", "na", "bb(1)", "Led", "W9", "B20", "wb(na)"))
        step = f" STEP {self._expr(2)}" if self._random.random() < 0.5 else ""
        leave = "IF IN2 THEN EXIT\n" if self._random.random() < 0.3 else ""
        head = f"FOR {counter} = {self._expr(2)} TO {self._expr(2)}{step}"
        return f"{head}\n{self._block()}\n{leave}NEXT"

    def _select(self) -> str:
        cases = (
            f"{self._const()}, {self._const()}",
            f"{self._const()} TO {self._expr(1)}",
            f"{self._random.choice(COMPARISONS)} {self._expr(2)}",
        )
        lines = [f"SELECT {self._expr(2)}"]
        for case in self._random.sample(cases, self._random.randint(1, 3)):
            lines += [f"CASE {case}", self._block()]
        if self._random.random() < 0.5:
            lines += ["CASE ELSE", self._block()]
        return "\n".join([*lines, "ENDSELECT"])

    def _data(self) -> list[str]:
        if self._random.random() < 0.5:
            return []
        number = self._random.randint(0, 255)
        return [
            f'DATA {number}, "text", 0, WORD {number}(3), (4), 7(20)',
            f"DATA @{self._random.randint(100, 300)}, {number}, 0, 0, (2), 1",
        ]
