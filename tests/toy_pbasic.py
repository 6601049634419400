"""A toy that runs routines of the generated PBASIC from their text, to test what they say.

No timing and no tokens: assignments, IF, FOR, READ, LOOKUP, jumps and calls, with PBASIC's
left-to-right arithmetic of 16 bits; SERIN takes what `inbox` holds, pins are what `level` says. It
knows just what the templates use and refuses the rest.
"""

import re
from collections.abc import Callable
from functools import cache

SIZES = {"BIT": 1, "NIB": 4, "BYTE": 8, "WORD": 16}
TOKEN = re.compile(
    r'\s*("[^"]"|%[01]+|\$[0-9A-F]+|\d+|[A-Z_]\w*(?:\.[A-Z]+\d*)?|//|<<|>>|<=|>=|<>|[-+*/&|^=<>(),])',
    re.IGNORECASE,
)
ARITHMETIC: dict[str, Callable[[int, int], int]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a // b,
    "//": lambda a, b: a % b,
    "&": lambda a, b: a & b,
    "MIN": max,
    "MAX": min,
}
COMPARISONS: dict[str, Callable[[int, int], bool]] = {
    "=": lambda a, b: a == b,
    "<>": lambda a, b: a != b,
    "<": lambda a, b: a < b,
    ">": lambda a, b: a > b,
}


@cache
def _tokens(text: str) -> tuple[str, ...]:
    tokens = tuple(TOKEN.findall(text))
    assert "".join(tokens) == re.sub(r'\s+(?=([^"]*"[^"]*")*[^"]*$)', "", text), text
    return tokens


class SilenceError(Exception):
    """The program listens, and `inbox` is empty."""


class Toy:
    """One program; `run` executes a routine up to its RETURN."""

    def __init__(self, source: str, eeprom: bytes, labels: dict[str, int]) -> None:
        self.eeprom = eeprom
        self.constants = {name.upper(): address for name, address in labels.items()}
        self.sizes: dict[str, int] = {}
        self.alias: dict[str, str] = {}
        self.bytes: list[str] = []
        self.values: dict[tuple[str, int], int] = {}
        self.lines: list[str] = []
        self.numbers: list[int] = []
        self.targets: dict[str, int] = {}
        self.frames: list[dict[str, int]] = []
        self.pins: dict[str, int] = {}
        self.level: Callable[[str], int] = lambda pin: 1
        self.events: list[str] = []
        self.sent = ""
        self.inbox: list[str] = []
        pending = ""
        for number, text in enumerate(source.splitlines(), 1):
            pending = f"{pending} {re.sub(chr(39) + '.*', '', text).strip()}".strip()
            if pending and not pending.endswith(","):
                self._declare(pending, number)
                pending = ""

    def _declare(self, line: str, number: int) -> None:
        words = line.split()
        if len(words) > 2 and words[1] == "PIN":
            self.pins[words[0].upper()] = int(words[2])
        elif len(words) > 2 and words[1] == "CON":
            self.constants[words[0].upper()] = self.value(" ".join(words[2:]))
        elif len(words) > 2 and words[1] == "VAR":
            size = re.match(r"(Bit|Nib|Byte|Word)\b", words[2])
            if size:
                self.sizes[words[0].upper()] = SIZES[size[1].upper()]
                if words[2] == "Byte":
                    self.bytes.append(words[0].upper())
            else:
                self.alias[words[0].upper()] = words[2].upper()
        elif "DATA" in words[:2]:
            pass
        elif re.fullmatch(r"\w+:", line):
            self.targets[line[:-1].upper()] = len(self.lines)
        else:
            self.lines.append(line)
            self.numbers.append(number)

    # --- expressions

    def value(self, text: str) -> int:
        self.tokens = list(_tokens(text))
        result = self._logic()
        assert not self.tokens, text
        return result

    def _logic(self) -> int:
        left = self._comparison()
        while self.tokens and self.tokens[0] in ("AND", "OR"):
            word, right = self.tokens.pop(0), self._comparison()
            left = left & right if word == "AND" else left | right
        return left

    def _comparison(self) -> int:
        left = self._arithmetic()
        if self.tokens and self.tokens[0] in COMPARISONS:
            return 0xFFFF * COMPARISONS[self.tokens.pop(0)](left, self._arithmetic())
        return left

    def _arithmetic(self) -> int:
        left = self._atom()
        while self.tokens and self.tokens[0] in ARITHMETIC:
            left = ARITHMETIC[self.tokens.pop(0)](left, self._atom()) & 0xFFFF
        return left

    def _atom(self) -> int:
        token = self.tokens.pop(0)
        if token == "(":
            result = self._logic()
            assert self.tokens.pop(0) == ")"
            return result
        if token.startswith('"'):
            return ord(token[1])
        if token[0] in "%$":
            return int(token[1:], 2 if token[0] == "%" else 16)
        if token.isdigit():
            return int(token)
        index = 0
        if self.tokens and self.tokens[0] == "(":
            index = self._atom()
        return self.get(token, index)

    # --- variables

    def _root(self, name: str) -> tuple[str, str]:
        root, _, modifier = name.upper().partition(".")
        return self.alias.get(root, root), modifier

    def get(self, name: str, index: int = 0) -> int:
        root, modifier = self._root(name)
        if root in self.pins:
            return self.level(root)
        if root in self.constants:
            return self.constants[root]
        if modifier:
            bit = index if modifier == "LOWBIT" else int(modifier.removeprefix("BIT"))
            return self.values.get((root, 0), 0) >> bit & 1
        return self.values.get((root, index), 0)

    def set(self, name: str, value: int) -> None:
        index = 0
        if name.endswith(")"):
            name, _, inner = name[:-1].partition("(")
            index = self.value(inner)
        root, modifier = self._root(name.strip())
        if index and root in self.bytes:  # what lies behind it in RAM
            root, index = self.bytes[self.bytes.index(root) + index], 0
        assert not modifier, name
        assert root not in self.constants, name
        self.values[(root, index)] = value & (1 << self.sizes.get(root, 16)) - 1

    # --- statements

    def run(self, routine: str) -> None:
        pc, stack = self.targets[routine.upper()], [-1]
        for _ in range(100_000):
            pc = self.step(pc, stack)
            if pc < 0:
                return
        raise AssertionError(f"{routine} does not return")

    def step(self, pc: int, stack: list[int]) -> int:
        line = self.lines[pc]
        word, _, rest = line.partition(" ")
        if word == "IF":
            return self._if(pc, stack)
        if word in ("ELSE", "ELSEIF"):
            return self._skip(pc, ("ENDIF",)) + 1
        if word == "ENDIF":
            return pc + 1
        if word == "FOR":
            name, start, _, _ = self._for(pc)
            self.set(name, self.value(start))
            return pc + 1
        if word == "NEXT":
            return self._next(pc)
        return self._simple(line, word, rest, pc, stack)

    def _simple(self, line: str, word: str, rest: str, pc: int, stack: list[int]) -> int:
        if word == "GOSUB":
            stack.append(pc + 1)
            assert len(stack) <= 5
            return self.targets[rest.upper()]
        if word == "GOTO":
            return self.targets[rest.upper()]
        if word == "RETURN":
            return stack.pop()
        if word == "READ":
            place, *names = rest.split(", ")
            for offset, name in enumerate(names):
                self.set(name, self.eeprom[self.value(place) + offset])
        elif word == "LOOKUP":
            index, items, name = re.fullmatch(r"(\w+), \[(.*)\], (\w+)", rest).groups()
            self.set(name, self.value(items.split(", ")[self.value(index)]))
        elif word == "BRANCH":
            name, items = re.fullmatch(r"(\w+), \[(.*)\]", rest).groups()
            places = items.split(", ")
            if self.get(name) < len(places):
                return self.targets[places[self.get(name)].upper()]
        elif word == "PULSOUT":
            pin, width = rest.split(", ")
            self.pulse(pin, self.value(width))
        elif word in ("LOW", "HIGH", "INPUT", "PAUSE"):
            self.events.append(line)
        elif word == "RCTIME":
            self.set(rest.rpartition(", ")[2], 0)
        elif word == "SEROUT":
            self.sent += "".join(self._item(item) for item in _items(rest))
        elif word == "SERIN":
            heard = self.receive(_items(rest))
            return pc + 1 if heard else self.targets[rest.split(", ")[3].upper()]
        else:
            name, equals, expression = line.partition(" = ")
            assert equals, f"the toy does not know {line!r}"
            self.set(name, self.value(expression))
        return pc + 1

    def pulse(self, pin: str, width: int) -> None:
        if self.pins[pin.upper()] == 0 or not self.frames:
            self.frames.append({})
        self.frames[-1][pin] = width

    def _item(self, item: str) -> str:
        if item.startswith('"'):
            return item.strip('"')
        word, _, rest = item.partition(" ")
        if item == "CR":
            return "\r"
        if item.startswith("STR"):
            return "".join(chr(self.get("request", index)) for index in range(4))
        if word == "DEC":
            return str(self.value(rest))
        if word.startswith("HEX"):
            digits = int(word[3:])
            return f"{self.value(rest):0{digits}X}"[-digits:]
        return chr(self.value(item))

    def receive(self, items: list[str]) -> bool:
        """Store what came; False for a time-out."""
        self.events.append("listens")
        if not self.inbox:
            raise SilenceError
        text = self.inbox.pop(0)
        for item in items:
            if item.startswith("STR"):
                for index, character in enumerate(text[:4]):
                    self.set(f"request({index})", ord(character))
                return len(text) >= 4
            if item == "WAIT (CR)":
                if "\r" not in text:
                    return False
                text = text.partition("\r")[2]
                continue
            word, _, name = item.partition(" ")
            found = re.match(rf"[^0-9A-F]*([0-9A-F]{{1,{word[3:]}}})", text)
            if not found:
                return False
            self.set(name, int(found[1], 16))
            text = text[found.end() :]
        return True

    def _if(self, pc: int, stack: list[int]) -> int:
        condition, _, then = re.sub(r"^(IF|ELSEIF) ", "", self.lines[pc]).partition(" THEN")
        true = self.value(condition) != 0
        then = then.strip()
        if then:
            if not true:
                return pc + 1
            if then.upper() in self.targets:
                return self.targets[then.upper()]
            word, _, rest = then.partition(" ")
            after = self._simple(then, word, rest, pc, stack)
            return after
        if true:
            return pc + 1
        place = self._skip(pc, ("ELSEIF", "ELSE", "ENDIF"))
        return self._if(place, stack) if self.lines[place].startswith("ELSEIF") else place + 1

    def _skip(self, pc: int, wanted: tuple[str, ...]) -> int:
        depth = 0
        while True:
            pc += 1
            word = self.lines[pc].split()[0]
            if depth == 0 and word in wanted:
                return pc
            if word == "IF" and self.lines[pc].endswith("THEN"):
                depth += 1
            elif word == "ENDIF":
                depth -= 1

    def _for(self, pc: int) -> tuple[str, str, str, str]:
        found = re.fullmatch(r"FOR (\w+) = (.*) TO (.*?)(?: STEP (.*))?", self.lines[pc])
        assert found, self.lines[pc]
        return found[1], found[2], found[3], found[4] or "1"

    def _next(self, pc: int) -> int:
        depth, top = 0, pc
        while True:
            top -= 1
            word = self.lines[top].split()[0]
            if word == "FOR" and depth == 0:
                break
            depth += {"NEXT": 1, "FOR": -1}.get(word, 0)
        name, start, end, step = self._for(top)
        self.set(name, self.get(name) + self.value(step))
        return top + 1 if self.value(start) <= self.get(name) <= self.value(end) else pc + 1


def _items(rest: str) -> list[str]:
    """The items of a list in brackets."""
    inside = rest[rest.index("[") + 1 : rest.rindex("]")]
    return re.findall(r'("[^"]*"|[^,\s][^,]*)', inside)
