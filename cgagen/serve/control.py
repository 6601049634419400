r"""DTR and BREAK as lines of text, for ports that have neither: a plain socket and a pty.

A host writes `DTR 1`, `DTR 0`, `BREAK 1` or `BREAK 0` and a line end; the line comes back when
the chip has seen it. What is something else comes back as a line with `ERROR` in front.
"""

from typing import Protocol

MOST_LINE_BYTES = 64
"""A line without an end is given up there. Choice."""

HELP = "ERROR say DTR 0, DTR 1, BREAK 0 or BREAK 1"


class Lines(Protocol):
    """What can be set."""

    dtr: bool
    break_condition: bool


class ControlText:
    r"""The text of one host.

    >>> class Port:
    ...     dtr = break_condition = False
    >>> port = Port()
    >>> text = ControlText(port)
    >>> text.take(b"BREAK 1\r\nDT"), text.take(b"R 1\n"), text.take(b"fly\n")[0][:5]
    (['BREAK 1'], ['DTR 1'], 'ERROR')
    >>> port.dtr, port.break_condition
    (True, True)
    """

    def __init__(self, port: Lines) -> None:
        self._port = port
        self._rest = b""

    def take(self, data: bytes) -> list[str]:
        """Do what complete lines say; returns the answers."""
        *lines, self._rest = (self._rest + data).split(b"\n")
        answers = [self._do(line) for line in lines]
        if len(self._rest) > MOST_LINE_BYTES:
            self._rest = b""
            answers.append(HELP)
        return answers

    def _do(self, line: bytes) -> str:
        words = line.decode("ascii", "replace").upper().split()
        match words:
            case ["DTR", ("0" | "1") as level]:
                self._port.dtr = level == "1"
            case ["BREAK", ("0" | "1") as level]:
                self._port.break_condition = level == "1"
            case _:
                return HELP
        return " ".join(words)
