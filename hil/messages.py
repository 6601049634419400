"""The CAN messages of a stimulus rig: one table for target, rig, traces and DBC file.

A rig stands in for the robot's sensors and looks at its wires. A host tells it what the main
controller is to measure, and it tells what the controller has decided. PROTOCOL.md explains the
exchange to a reader; `rig.dbc` beside this file is this table in every CAN tool's language.

All messages have standard identifiers and 8 bytes; signals are unsigned and little-endian. Times
are raw counts of `TICK_NS`, so hardly a unit is rounded: 2 us are 40, 0.8 us 16, 0.75 us 15;
a BS2pe's 1.88 us are 37.6, so there the middle of a count is met within one of them.
"""

from collections.abc import Mapping
from enum import IntEnum
from typing import NamedTuple

VERSION = 1
"""Of the messages; a rig tells its own in RIG_IDENTITY.PROTOCOL. Choice."""

TICK_NS = 50
"""One raw count of a time. It divides all units of `cgagen.stamp.chips` but one. Choice."""

BITRATE = 500_000
"""Bits per second. Choice: an 8-byte frame takes 0.27 ms at most."""

FRAME_BYTES = 8
"""Of every message."""

SONARS, LIGHTS, SERVOS = 6, 2, 12
"""As many as the messages have room for."""

SEQUENCES = 1 << 16
"""Numbers of questions; they begin again at 0."""

HOST, RIG = "HOST", "RIG"


class Op(IntEnum):
    """What RIG_CMD asks for."""

    NOP = 0
    RESET = 1
    POWER_OFF = 2
    POWER_ON = 3
    HELLO = 4
    SERVOS = 5


class State(IntEnum):
    """What a rig is doing, in RIG_STATUS."""

    IDLE = 0
    """The robot is on, and no question is open."""
    ARMED = 1
    """Some frames of a question have come, STIM_APPLY has not."""
    RUNNING = 2
    """The robot is at a question, or walks."""
    OFF = 3
    """The robot has no supply."""
    FAULT = 255
    """The rig itself is sick."""


class Report(IntEnum):
    """What a rig has to say about a message, in RIG_STATUS under the name of ERROR."""

    NONE = 0
    BAD_FRAME = 1
    """Wrong length, unknown operation, or a value that this rig cannot present."""
    INCOMPLETE = 2
    """STIM_APPLY came, and not all frames of its number had come."""
    OLD_SEQ = 3
    """The number is not newer than the last one that was answered."""
    NO_DECISION = 4
    """The robot has not decided in time."""
    UNKNOWN_FAULT = 5
    """This rig cannot make that fault."""
    NO_POWER = 6
    """The robot is off."""
    NO_SERVOS = 7
    """No servo frame came in time, or this rig does not see servos."""
    SICK = 8
    """The rig itself has failed."""
    FAULT_FIRED = 64
    """The fault of this question has made a difference."""
    FAULT_SILENT = 65
    """The fault of this question was on and made no difference."""


class Fault(IntEnum):
    """What STIM_APPLY can spoil for the length of one question: kind and part, a byte each."""

    NONE = 0x0000
    NO_ECHO_0 = 0x0100
    NO_ECHO_1 = 0x0101
    NO_ECHO_2 = 0x0102
    NO_ECHO_3 = 0x0103
    NO_ECHO_4 = 0x0104
    NO_ECHO_5 = 0x0105
    TOUCHED_L = 0x0200
    TOUCHED_R = 0x0201
    TORN_L = 0x0300
    TORN_R = 0x0301
    DARK_L = 0x0400
    DARK_R = 0x0401
    COMMAND_CUT_0 = 0x0500
    COMMAND_CUT_1 = 0x0501
    COMMAND_CUT_2 = 0x0502


class Signal(NamedTuple):
    """A number in a message.

    Attributes:
        name: unique in its message.
        start: first bit, counted from the lowest of byte 0.
        length: in bits.
        scale: what one raw count is in `unit`, as a decimal number.
        unit: "" for none.
        choices: names of values.
    """

    name: str
    start: int
    length: int
    scale: str = "1"
    unit: str = ""
    choices: type[IntEnum] | None = None

    @property
    def most(self) -> int:
        """The largest raw value."""
        return (1 << self.length) - 1


class Message(NamedTuple):
    """A frame with a meaning: its identifier, name, sender and signals."""

    id: int
    name: str
    sender: str
    signals: tuple[Signal, ...]


def _time(name: str, start: int, length: int) -> Signal:
    return Signal(name, start, length, "0.05", "us")


_SEQ = Signal("SEQ", 48, 16)


def _sonars(id: int, letter: str, first: int) -> Message:  # noqa: A002  a frame's
    echoes = (_time(f"SONAR{first + n}_ECHO", 24 * n, 24) for n in range(2))
    return Message(id, f"STIM_SONAR_{letter}", HOST, (*echoes, _SEQ))


def _servos(id: int, letter: str, first: int) -> Message:  # noqa: A002  a frame's
    pulses = (_time(f"SERVO{first + n:02d}_PULSE", 16 * n, 16) for n in range(3))
    return Message(id, f"OBS_SERVO_{letter}", RIG, (*pulses, Signal("FRAME", 48, 16)))


RIG_CMD = Message(
    0x080,
    "RIG_CMD",
    HOST,
    (Signal("OP", 0, 8, choices=Op), Signal("SEQ", 8, 16), Signal("ARG", 24, 32)),
)
RIG_STATUS = Message(
    0x081,
    "RIG_STATUS",
    RIG,
    (
        Signal("STATE", 0, 8, choices=State),
        Signal("SEQ", 8, 16),
        Signal("ERROR", 24, 8, choices=Report),
        Signal("RIG_TIME_MS", 32, 32, unit="ms"),
    ),
)
RIG_IDENTITY = Message(
    0x082,
    "RIG_IDENTITY",
    RIG,
    (
        Signal("NONCE", 0, 32),
        Signal("PROTOCOL", 32, 8),
        Signal("SONARS", 40, 4),
        Signal("LIGHTS", 44, 4),
        Signal("HEARS", 48, 1),
        Signal("SWITCHES_POWER", 49, 1),
        Signal("SEES_SERVOS", 50, 1),
        _time("JITTER", 56, 8),
    ),
)
RIG_BANNER = Message(0x083, "RIG_BANNER", RIG, (Signal("GENOME", 0, 32), Signal("SOURCE", 32, 32)))
STIM_SONARS = (
    _sonars(0x100, "A", 0),
    _sonars(0x101, "B", 2),
    _sonars(0x102, "C", 4),
)
STIM_LIGHT = Message(
    0x103,
    "STIM_LIGHT",
    HOST,
    (_time("LIGHT_L_RC", 0, 24), _time("LIGHT_R_RC", 24, 24), _SEQ),
)
STIM_APPLY = Message(
    0x104,
    "STIM_APPLY",
    HOST,
    (
        Signal("WHISKER_L", 0, 1),
        Signal("WHISKER_R", 1, 1),
        Signal("SONAR_MASK", 8, 6),
        Signal("FAULT", 16, 16, choices=Fault),
        _SEQ,
    ),
)
OBS_DECISION = Message(
    0x200,
    "OBS_DECISION",
    RIG,
    (
        Signal("COMMAND", 0, 3),
        Signal("VALID", 3, 1),
        Signal("STATE_VALID", 7, 1),
        Signal("STATE", 8, 6),
        Signal("SEQ", 16, 16),
        _time("LATENCY", 32, 32),
    ),
)
OBS_SERVOS = (
    _servos(0x201, "A", 0),
    _servos(0x202, "B", 3),
    _servos(0x203, "C", 6),
    _servos(0x204, "D", 9),
)

MESSAGES: tuple[Message, ...] = (
    RIG_CMD,
    RIG_STATUS,
    RIG_IDENTITY,
    RIG_BANNER,
    *STIM_SONARS,
    STIM_LIGHT,
    STIM_APPLY,
    OBS_DECISION,
    *OBS_SERVOS,
)
"""All of them, by rising identifier."""

BY_ID = {message.id: message for message in MESSAGES}


def pack(message: Message, values: Mapping[str, int]) -> bytes:
    """Return a message's 8 bytes.

    Args:
        message: of the table.
        values: raw value of every signal, by name.

    Raises:
        ValueError: a signal is missing, unknown, or has no room for its value.

    >>> pack(RIG_CMD, {"OP": Op.HELLO, "SEQ": 1, "ARG": 0xCAFE}).hex()
    '040100feca000000'
    """
    names = {signal.name for signal in message.signals}
    if names != set(values):
        odd = ", ".join(sorted(names ^ set(values)))
        raise ValueError(f"{message.name}: {odd}: missing, or none of its signals")
    word = 0
    for signal in message.signals:
        value = values[signal.name]
        if not 0 <= value <= signal.most:
            raise ValueError(f"{message.name}.{signal.name}: {value} is not 0 to {signal.most}")
        word |= value << signal.start
    return word.to_bytes(FRAME_BYTES, "little")


def unpack(message: Message, data: bytes) -> dict[str, int]:
    """Return the raw value of every signal; bits between them do not count.

    Raises:
        ValueError: there are not 8 bytes.

    >>> unpack(RIG_CMD, bytes.fromhex("040100feca000000"))
    {'OP': 4, 'SEQ': 1, 'ARG': 51966}
    """
    if len(data) != FRAME_BYTES:
        raise ValueError(f"{message.name}: {len(data)} bytes, not {FRAME_BYTES}")
    word = int.from_bytes(data, "little")
    return {signal.name: word >> signal.start & signal.most for signal in message.signals}
