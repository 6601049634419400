"""The words that both Stamps and a host exchange on the programming port: one table for all.

PROTOCOL.md explains them to a reader. The firmware takes its markers, letters and times from
here, and so do the tools that talk to it. Nothing in here talks to anything.
"""

from enum import StrEnum
from typing import NamedTuple

from cgagen.notations import small_number
from cgagen.words import Role

VERSION = 1
"""Of the protocol, first word of the banner. Choice."""

BAUD = 9600
"""8N1, on pin 16, the programming port. Ref: S2 p. 419."""

PROMPT = ">"
"""The chip listens from now on, for the length of a slice."""

BANNER = "#"
REQUEST = "?"
ANSWER = "!"
TELEMETRY = ":"
FAULT = "*"
DUMP_LINE = "="
END = "\r"
"""Of every line that a chip sends."""

REQUEST_BYTES = 4
"""`?`, a letter, two characters: short enough to fit between two servo frames. Choice."""

LISTEN_MS = 500
"""How long a controller listens for HELLO after a reset, at least. Choice."""

MAIN_SLICE_MS = 50
LOCOMOTION_SLICE_MS = 10
"""How long a controller waits for each byte of a request. Choice; the locomotion controller's
slice, the four bytes (4.2 ms) and a frame must fit into 45 ms."""

READING_MS = 500
"""How long the main controller waits for each byte of the readings. Choice."""

PROMPT_GAP_MS = 2
"""What a host leaves between a prompt and what it sends: a BS2 takes 0.7 ms to get to its SERIN."""

BYTE_GAP_MS = 1
"""What a host leaves between two bytes of the readings: HEX needs time to store a number."""

GO_MS = 100
"""How long the main controller holds the step line low to say GO. Choice: two servo frames."""

FRAME_LIMIT_MS = 45
"""The longest gap between two pulses of a servo; past 50 ms servos go limp. Ref: S10."""

DUMP_BLOCK_BYTES = 32
DUMP_BLOCKS = 64
DUMP_FIRST = "0"
"""Block n of 32 bytes is named by the character "0" + n, so "0" to "o". Choice."""

DUMP_LINE_BYTES = 16

NONCE_BYTES = 2

MOST_NAME = 32
"""Characters of a robot's name in a banner. Choice: with all the rest it stays below a line."""


class Letter(StrEnum):
    """What a request asks for; its answer carries the same letter, or `REFUSED`."""

    HELLO = "H"
    QUESTION = "Q"
    DUMP = "D"
    MOVE = "M"
    CENTRE = "C"
    LEAVE = "X"
    REFUSED = "E"


class Fault(StrEnum):
    """What a controller reports by itself, behind `*`."""

    BUSY = "BUSY"
    """Main: the step line stays low for longer than the longest movement takes."""
    REFUSED = "REFUSED"
    """Main: the step line was high after GO; nobody has accepted the command: the locomotion
    controller is off, starts, or is in bench mode."""
    CUT = "CUT"
    """Main: the legs stood sooner than any movement is over; a reset has cut the step short."""
    BRIGHT = "BRIGHT"
    """Main: both light sensors are lit before the first look; the room is too bright for their
    limits, or the lamp is ahead."""
    LOW = "LOW"
    """Locomotion: the step line stays low although this side has released it."""
    IDLE = "IDLE"
    """Locomotion: no GO for a long time."""
    LINES = "LINES"
    """Locomotion: the command lines never read the same twice."""


CHIP_LETTERS = {"main": "M", "locomotion": "L"}
"""Second word of the banner."""

SONAR_KEYS: dict[Role, tuple[str, ...]] = {
    Role.PREDATOR: ("F", "R", "L"),
    Role.PREY: ("FL", "FR", "L", "R", "RL", "RR"),
}
"""Telemetry words of the sonars, in the order of `cgagen.robot.SONARS`."""

LIGHT_KEYS = ("LL", "LR")
ANTENNA_KEYS = ("AL", "AR")
STATE_KEY = "S"
COMMAND_KEY = "C"

PREY_CALM = 0
PREY_FIRST_SONAR = 1
PREY_ANTENNA_LEFT = 7
PREY_ANTENNA_RIGHT = 8
PREY_BOTH_LEFT_OPEN = 9
PREY_BOTH_RIGHT_OPEN = 10
"""The prey's states: what has decided. 1 to 6 are its sonars. Choice."""


class Banner(NamedTuple):
    """What a controller says of itself at reset."""

    version: int
    chip: str
    robot: str
    genome: str
    source: str


class Answer(NamedTuple):
    """The main controller's answer to a question: two characters, state and command."""

    sequence: str
    state: int
    command: int


def plain(text: str, most: int = MOST_NAME) -> str:
    """Return a user's text as one word of printable ASCII, as banners, sources and files have it.

    A chip says no other name, so who compares what a chip says compares it with this.

    >>> plain('Käfer "2"'), plain(" .. ")
    ('K_fer_2', 'robot')
    """
    word = "".join(c if c.isascii() and (c.isalnum() or c in "._-") else "_" for c in text)
    while "__" in word:
        word = word.replace("__", "_")
    word = word.strip("_")[:most]
    return word if any(c.isalnum() for c in word) else "robot"


def banner_text(banner: Banner) -> str:
    """Return the banner as it is sent, without its end.

    >>> banner_text(Banner(1, "main", "servobot-prey", "12345678", "9abcdef0"))
    '#1 M servobot-prey 12345678 9abcdef0'
    """
    return (
        f"{BANNER}{banner.version} {CHIP_LETTERS[banner.chip]} {banner.robot} "
        f"{banner.genome} {banner.source}"
    )


def parse_banner(line: str) -> Banner | None:
    """Return what a banner says; None where the line is none.

    >>> parse_banner(">>#1 L servobot-prey 12345678 9abcdef0").chip
    'locomotion'
    """
    words = line.rpartition(BANNER)[2].split(" ")
    chips = {letter: chip for chip, letter in CHIP_LETTERS.items()}
    number = small_number(words[0])
    if BANNER not in line or len(words) != 5 or number is None or words[1] not in chips:
        return None
    return Banner(number, chips[words[1]], *words[2:])


def banner_in(eeprom: bytes) -> Banner | None:
    r"""Return the banner that lies in an EEPROM, wherever it does; None where none does.

    >>> banner_in(b"\x07\x23#1 L servobot-prey 12345678 9abcdef0\r\x00").chip
    'locomotion'
    """
    for piece in eeprom.split(END.encode())[:-1]:
        found = parse_banner(piece.decode("latin-1"))
        if found is not None:
            return found
    return None


def request_text(letter: Letter, first: str, second: str) -> str:
    """Return a request.

    Raises:
        ValueError: an argument is not one printable character.

    >>> request_text(Letter.MOVE, "5", "a")
    '?M5a'
    """
    for argument in (first, second):
        if len(argument) != 1 or not "!" <= argument <= "~":
            raise ValueError(f"{argument!r} is not one printable character")
    return f"{REQUEST}{letter}{first}{second}"


def reading_text(antennas: int, counts: tuple[int, ...]) -> str:
    r"""Return the readings that follow a question.

    Args:
        antennas: pin levels, 1 = free: bit 0 left, bit 1 right.
        counts: sonars in the robot's order, then the light sensors, left and right.

    Raises:
        ValueError: a number does not fit its field.

    >>> reading_text(3, (1843, 0, 65535, 170, 0))
    '3 0733 0000 FFFF 00AA 0000 07DF\r'
    """
    if not 0 <= antennas <= 3 or not all(0 <= count <= 0xFFFF for count in counts):
        raise ValueError(f"{antennas} and {counts} are not two bits and 16-bit counts")
    check = (antennas + sum(counts)) & 0xFFFF
    return " ".join([f"{antennas:X}", *(f"{count:04X}" for count in (*counts, check))]) + END


def parse_answer(line: str) -> Answer | None:
    """Return the answer to a question that stands at the end of a line; None where none does.

    The host's own bytes come back on the line and may stand before it.

    >>> parse_answer("?Q5A>!Q5A0F2")
    Answer(sequence='5A', state=15, command=2)
    """
    text = line.rpartition(f"{ANSWER}{Letter.QUESTION}")[2]
    digits = text[NONCE_BYTES:]
    if f"{ANSWER}{Letter.QUESTION}" not in line or len(digits) != 3:
        return None
    try:
        return Answer(text[:NONCE_BYTES], int(digits[:2], 16), int(digits[2], 16))
    except ValueError:
        return None


def dump_request(first_byte: int, last_byte: int) -> str:
    """Return the request for the blocks that hold a range of EEPROM bytes.

    Raises:
        ValueError: the range is empty or leaves the EEPROM.

    >>> dump_request(0, 2047), dump_request(40, 63)
    ('?D0o', '?D11')
    """
    if not 0 <= first_byte <= last_byte < DUMP_BLOCK_BYTES * DUMP_BLOCKS:
        raise ValueError(f"{first_byte} to {last_byte} is not a range of EEPROM bytes")
    first, last = (
        chr(ord(DUMP_FIRST) + address // DUMP_BLOCK_BYTES) for address in (first_byte, last_byte)
    )
    return request_text(Letter.DUMP, first, last)


def parse_dump(line: str) -> tuple[int, bytes] | None:
    r"""Return address and bytes of a dump's line; None where the line is none.

    >>> parse_dump("=7F0 " + "00" * 15 + "C0")
    (2032, b'\x00\x00\x00\x00\x00\x00\x00\x00\x00\x00\x00\x00\x00\x00\x00\xc0')
    """
    address, _, digits = line.rpartition(DUMP_LINE)[2].partition(" ")
    if DUMP_LINE not in line or len(address) != 3 or len(digits) != 2 * DUMP_LINE_BYTES:
        return None
    try:
        return int(address, 16), bytes.fromhex(digits)
    except ValueError:
        return None
