"""Words that both controllers' templates share: the programming port and the protocol."""

from typing import Any

from cgagen import bench_protocol as protocol
from cgagen.firmware.columns import con
from cgagen.firmware.pins import PinUse, pin_lines
from cgagen.robot.values import Robot
from cgagen.stamp.chips import Chip
from cgagen.words import COMMANDS

PORT_PIN = 16
"""The programming port as SERIN and SEROUT name it. Ref: S2 p. 394."""

_NIBBLES = "ABCD"


def serin_units(model: Chip, ms: int) -> int:
    """Return a SERIN time-out in the chip's units: 1 ms, or 0.4 ms. Ref: S2 p. 394.

    >>> from cgagen.stamp.chips import chip
    >>> serin_units(chip("BS2"), 10), serin_units(chip("BS2p"), 10)
    (10, 25)
    """
    fast = model.name in ("BS2sx", "BS2p")
    return ms * 5 // 2 if fast else ms


def port_constants(model: Chip, slice_ms: int, tries: int) -> list[str]:
    """Return the constants of the programming port."""
    return [
        con("Port", PORT_PIN, "the programming port"),
        con("Baud", model.debug_baud_word, f"{protocol.BAUD} baud, 8N1, on a {model.name}"),
        con("ListenTime", serin_units(model, slice_ms), f"{slice_ms} ms for each byte"),
        con("ListenTries", tries, f"slices, {protocol.LISTEN_MS} ms in all at least"),
    ]


def common_words(robot: Robot, model: Chip, uses: tuple[PinUse, ...]) -> dict[str, Any]:
    """Return the words that every template of a program may use."""
    return {
        "stamp": model.directive,
        "pin_table": pin_lines(uses),
        "prompt": protocol.PROMPT,
        "request_mark": protocol.REQUEST,
        "answer_mark": protocol.ANSWER,
        "telemetry_mark": protocol.TELEMETRY,
        "dump_mark": protocol.DUMP_LINE,
        "letter": {letter.name: letter.value for letter in protocol.Letter},
        "fault": {fault.name: f"{protocol.FAULT}{fault.value}" for fault in protocol.Fault},
        "step_line": robot.link.step_line is not None,
        "telemetry": robot.telemetry,
    }


def nibble(pins: tuple[int, ...]) -> str:
    """Return the letter of the nibble that the command lines lie in.

    >>> nibble((12, 13, 14))
    'D'
    """
    return _NIBBLES[pins[0] // 4]


def movement_legend(robot: Robot) -> list[str]:
    """Return the movements with their numbers, in two lines."""
    items = [f"{code} {move}" for code, move in enumerate(COMMANDS[robot.role])]
    return ["".join(f"{item:<18}" for item in half).rstrip() for half in (items[:4], items[4:])]
