"""The instructions that take time, as generator functions by their name in the opcode table.

See `cgagen.emulator.port` for the signature. Everything else is the chip's own.
"""

from collections.abc import Callable

from cgagen.emulator.port import Result
from cgagen.emulator.requests import Command

CommandFunction = Callable[..., Command[Result]]

COMMANDS: dict[str, CommandFunction] = {}
