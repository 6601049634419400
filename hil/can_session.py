"""A host's talk with a rig: greeting, commands, questions. PROTOCOL.md has the rules.

Every wait is bounded, every answer carries the number of what it answers, and what is lost on the
bus is told apart from a robot that does not decide.
"""

import secrets
import time
from itertools import count
from typing import NamedTuple, Never

from cgagen.errors import RigError, TargetTimeout
from hil.can_line import CanLine
from hil.frames import Frame, frame
from hil.messages import (
    BY_ID,
    OBS_DECISION,
    RIG_BANNER,
    RIG_CMD,
    RIG_IDENTITY,
    RIG_STATUS,
    SEQUENCES,
    VERSION,
    Message,
    Op,
    Report,
    State,
    unpack,
)
from hil.rig_url import RigUrl

HELLO_S = 3.0
"""How long a rig may take to say hello, with all tries. Choice."""

TRY_S = 0.5
"""How long one HELLO waits. Choice."""

TAKE_S = 1.0
"""How long a rig may take to say that it has taken a question. Choice."""

ANSWER_S = 10.0
"""How long a rig may take with a question or a command: a whole gait cycle and more. Choice."""

LIFE_S = 2.0
"""A rig from which RIG_STATUS came so short a time ago lives; it says so twice a second. Choice."""

READ_S = 0.05
"""How long one read waits. Choice."""

REFUSALS = {
    Report.BAD_FRAME: "the rig cannot present it; compare its DBC file with rig.dbc",
    Report.UNKNOWN_FAULT: "the rig cannot make that fault",
    Report.NO_POWER: "the robot is off; switch it on",
    Report.NO_SERVOS: "no servo pulses came in time",
    Report.SICK: "the rig has failed; reset the robot, or restart the rig",
}
"""What a rig refuses, in words."""


class Came(NamedTuple):
    """A frame of the rig, taken apart."""

    message: Message
    values: dict[str, int]
    data: bytes


class Rig(NamedTuple):
    """What a rig says of itself.

    Attributes:
        nonce: ours, given back.
        values: RIG_IDENTITY.
        banner: genome and source that the main controller's banner has; zeros for none heard.
    """

    nonce: int
    values: dict[str, int]
    banner: tuple[int, int]


class Answer(NamedTuple):
    """What came of a question.

    Attributes:
        number: of the question, not cut to 16 bits.
        data: of OBS_DECISION.
        fired: whether its fault has made a difference; None for no word of it.
    """

    number: int
    data: bytes
    fired: bool | None


class CanSession:
    """A session with one rig.

    Args:
        place: where it is.
        name: what messages call it.

    Attributes:
        stale: answers to earlier questions, and greetings with another nonce.
    """

    def __init__(self, place: RigUrl, name: str) -> None:
        self.stale = 0
        self.line = CanLine(place, name)
        self._name = name
        self._numbers = count(secrets.randbelow(SEQUENCES // 2))
        self._heard_s = -LIFE_S

    def greet(self) -> Rig:
        """Say hello until the rig returns our nonce.

        Raises:
            RigError: nobody is there, or not for us, or with other messages.
        """
        nonce, strangers = secrets.randbits(32), self.stale
        deadline_s = time.monotonic() + HELLO_S
        while time.monotonic() < deadline_s:
            rig = self._hello(nonce)
            if rig is None:
                continue
            if rig.values["PROTOCOL"] != VERSION:
                raise RigError(
                    f"{self._name}: the rig speaks version {rig.values['PROTOCOL']} of the "
                    f"messages, we speak version {VERSION}; bring the older one up to date"
                )
            return rig
        if self.stale > strangers:
            raise RigError(
                f"{self._name}: the rig greets with another nonce than ours; another host is "
                "asking it, or it repeats old answers, so leave it to one host and restart it"
            )
        self._give_up("does not say hello")

    def command(self, op: Op, argument: int = 0, wait_s: float | None = None) -> list[Came]:
        """Have a command done; returns what came meanwhile.

        Args:
            op: which.
            argument: of it.
            wait_s: how long it may take; None for `ANSWER_S`.

        Raises:
            RigError: it is refused, or not done in time.
        """
        seq = next(self._numbers) % SEQUENCES
        self.line.send((frame(RIG_CMD, OP=op, SEQ=seq, ARG=argument),))
        found: list[Came] = []
        wait_s = ANSWER_S if wait_s is None else wait_s
        deadline_s = time.monotonic() + wait_s
        while time.monotonic() < deadline_s:
            came = self._next()
            if came is None:
                continue
            found.append(came)
            if came.message is RIG_STATUS and came.values["SEQ"] == seq:
                if came.values["ERROR"]:
                    raise self._refused(came.values["ERROR"], op.name)
                if came.values["STATE"] != State.RUNNING:
                    return found
        self._give_up(f"{op.name} is not done in {wait_s:g} s")

    def number(self) -> int:
        """Return the number of the next question."""
        return next(self._numbers)

    def ask(self, number: int, frames: tuple[Frame, ...], what: str) -> Answer | None:
        """Ask once.

        Args:
            number: see `number`; the frames have its low 16 bits.
            frames: of the question.
            what: what messages call it.

        Returns:
            The answer; None where question or answer was lost on the way.

        Raises:
            TargetTimeout: the rig has asked the robot, and the robot does not decide.
            RigError: the rig refuses, or is silent.
        """
        seq, taken, fired = number % SEQUENCES, False, None
        self.line.send(frames)
        began_s = time.monotonic()
        while (now_s := time.monotonic()) < began_s + ANSWER_S:
            came = self._next()
            if came is None:
                if not taken and now_s > began_s + TAKE_S:
                    return None if self._lives() else self._give_up("takes no question")
            elif came.message is OBS_DECISION:
                if came.values["SEQ"] == seq:
                    return self._decided(Answer(number, came.data, fired), came.values, what)
                self.stale += 1
            elif came.message is RIG_STATUS and came.values["SEQ"] == seq:
                report, running = came.values["ERROR"], came.values["STATE"] == State.RUNNING
                if report in (Report.FAULT_FIRED, Report.FAULT_SILENT):
                    fired = report == Report.FAULT_FIRED
                elif report in (Report.INCOMPLETE, Report.OLD_SEQ):
                    return None
                elif report == Report.NO_DECISION:
                    self._decided(Answer(number, b"", fired), {"VALID": 0}, what)
                elif report:
                    raise self._refused(report, what)
                elif taken and not running:
                    return None
                taken = taken or running
        self._give_up(f"no decision on {what} in {ANSWER_S:g} s", taken)

    def _decided(self, answer: Answer, values: dict[str, int], what: str) -> Answer:
        if not values["VALID"]:
            raise TargetTimeout(
                f"{self._name}: the rig saw no decision on {what}; the program hangs there"
            )
        return answer

    def _hello(self, nonce: int) -> Rig | None:
        seq, values, banner = next(self._numbers) % SEQUENCES, None, (0, 0)
        self.line.send((frame(RIG_CMD, OP=Op.HELLO, SEQ=seq, ARG=nonce),))
        until_s = time.monotonic() + TRY_S
        while time.monotonic() < until_s:
            came = self._next()
            if came is None:
                continue
            if came.message is RIG_IDENTITY and came.values["NONCE"] == nonce:
                values = came.values
            elif came.message is RIG_IDENTITY:
                self.stale += 1
            elif came.message is RIG_BANNER:
                banner = (came.values["GENOME"], came.values["SOURCE"])
            elif came.message is RIG_STATUS and came.values["SEQ"] == seq:
                break
        return None if values is None else Rig(nonce, values, banner)

    def _next(self) -> Came | None:
        """Return the next frame of the rig; None where none came for a while."""
        one = self.line.receive(READ_S)
        if one is None:
            return None
        message = BY_ID[one.id]
        values = unpack(message, one.data)
        if message is RIG_STATUS:
            self._heard_s = time.monotonic()
        return Came(message, values, one.data)

    def _lives(self) -> bool:
        return time.monotonic() - self._heard_s < LIFE_S

    def _refused(self, report: int, what: str) -> RigError:
        why = REFUSALS.get(Report(report)) if report in list(Report) else None
        return RigError(f"{self._name}: {what}: {why or f'report {report} of the rig'}")

    def _give_up(self, what: str, taken: bool = False) -> Never:
        """Raise what fits: a hanging program, a rig that lives, or a silent one."""
        if self._lives() and taken:
            raise TargetTimeout(f"{self._name}: {what}, though the rig lives; the program hangs")
        if self._lives():
            raise RigError(f"{self._name}: {what}, though the rig lives; restart it")
        raise RigError(
            f"{self._name}: {what}, and no status comes either ({self.line.odd()}); look at the "
            "wiring, the bitrate (500,000 bit/s) and the rig's supply"
        )
