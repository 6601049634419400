"""A DEBUG terminal's control codes as those of today's terminals (ECMA-48).

Ref: S4 (DEBUG) for the codes; what a byte is that no code and no character uses: left out.
"""

from collections.abc import Callable

CR = 13

_PLAIN: dict[int, str] = {
    0: "\x1b[2J\x1b[H",  # CLS
    1: "\x1b[H",  # HOME
    3: "\x1b[D",  # CRSRLF
    4: "\x1b[C",  # CRSRRT
    5: "\x1b[A",  # CRSRUP
    6: "\x1b[B",  # CRSRDN
    7: "\a",  # BELL
    8: "\b \b",  # BKSP
    9: "\t",  # TAB
    10: "\x1bD",  # LF: down, in the same column
    11: "\x1b[K",  # CLREOL
    12: "\x1b[J",  # CLRDN
    CR: "\r\n",
    16: "\x1b[2J\x1b[H",  # CLS, as the first editors had it
}
"""Codes without arguments."""

_WITH_ARGUMENTS: dict[int, tuple[int, Callable[[bytes], str]]] = {
    2: (2, lambda at: f"\x1b[{at[1] + 1};{at[0] + 1}H"),  # CRSRXY
    14: (1, lambda at: f"\x1b[{at[0] + 1}G"),  # CRSRX
    15: (1, lambda at: f"\x1b[{at[0] + 1}d"),  # CRSRY
}
"""Codes with how many bytes follow, and what they make."""


class Screen:
    r"""Turns what a chip sends into what a terminal understands.

    >>> screen = Screen()
    >>> screen.shown(b"a\x0d\x02\x05"), screen.shown(b"\x07b")
    ('a\r\n', '\x1b[8;6Hb')
    """

    def __init__(self) -> None:
        self._code: int | None = None
        self._arguments = bytearray()

    def shown(self, data: bytes) -> str:
        """Return what is to be written for the next bytes."""
        return "".join(self._one(byte) for byte in data)

    def _one(self, byte: int) -> str:
        if self._code is not None:
            self._arguments.append(byte)
            count, made = _WITH_ARGUMENTS[self._code]
            if len(self._arguments) < count:
                return ""
            text = made(bytes(self._arguments))
            self._code = None
            self._arguments.clear()
            return text
        if byte in _WITH_ARGUMENTS:
            self._code = byte
            return ""
        if byte in _PLAIN:
            return _PLAIN[byte]
        character = bytes([byte]).decode("cp1252", "ignore")
        return character if character.isprintable() else ""
