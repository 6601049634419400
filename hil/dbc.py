"""`rig.dbc`: the table of CAN messages in the language of every CAN tool."""

import sys
from decimal import Decimal
from enum import IntEnum
from pathlib import Path

from hil.messages import FRAME_BYTES, HOST, MESSAGES, RIG, TICK_NS, VERSION, Message, Signal

DBC_FILE = Path(__file__).parent / "rig.dbc"
"""The file as it is shipped; `python -m hil.dbc > hil/rig.dbc` renders it anew."""


def dbc_text() -> str:
    """Return the table as a DBC file: the same table, the same text."""
    blocks = [[f'VERSION "cgagen-rig-{VERSION}"'], ["NS_ :"], ["BS_:"], [f"BU_: {HOST} {RIG}"]]
    for message in MESSAGES:
        other = RIG if message.sender == HOST else HOST
        head = f"BO_ {message.id} {message.name}: {FRAME_BYTES} {message.sender}"
        blocks.append([head, *(_signal_text(signal, other) for signal in message.signals)])
    blocks.append([f'CM_ "{_COMMENT}";'])
    blocks.append(
        [
            _choices_text(message, signal.name, signal.choices)
            for message in MESSAGES
            for signal in message.signals
            if signal.choices is not None
        ]
    )
    return "\n\n".join("\n".join(block) for block in blocks) + "\n"


_COMMENT = (
    f"One raw count of a time is {TICK_NS} ns: nearly every unit of the chips is whole, "
    "2 us = 40, 0.8 us = 16, 0.75 us = 15; a BS2pe's 1.88 us is not. "
    "An echo of 0 is no echo, an RC time of 0 is dark."
)


def _signal_text(signal: Signal, receiver: str) -> str:
    most = Decimal(signal.scale) * signal.most
    return (
        f" SG_ {signal.name} : {signal.start}|{signal.length}@1+ ({signal.scale},0) [0|{most}] "
        f'"{signal.unit}"  {receiver}'
    )


def _choices_text(message: Message, signal: str, choices: type[IntEnum]) -> str:
    names = " ".join(f'{choice.value} "{choice.name}"' for choice in choices)
    return f"VAL_ {message.id} {signal} {names} ;"


if __name__ == "__main__":
    sys.stdout.write(dbc_text())
