"""The host's side of PROTOCOL.md: a conversation with the bench hook of either controller.

::

    from cgagen.link.bench_hook import BenchHook

    with BenchHook("/dev/ttyUSB0") as hook:     # opens the port; asks for no reset
        hook.enter()                            # reset by DTR, and bench mode from here on
        print(hook.banner())
        hook.move(0)

A host speaks after a prompt only, repeats what was not heard, and takes an answer for its own
only by its number. Numbers begin anywhere, so that no answer to an earlier session, which a port's
server may have kept, is taken for one to this. All waits are bounded.
"""

import secrets
import string
import time
from contextlib import suppress
from itertools import count

from cgagen.bench_protocol import (
    ANSWER,
    BANNER,
    BYTE_GAP_MS,
    DUMP_BLOCK_BYTES,
    DUMP_LINE_BYTES,
    END,
    Answer,
    Banner,
    Letter,
    banner_in,
    dump_request,
    parse_answer,
    parse_banner,
    parse_dump,
    request_text,
)
from cgagen.errors import IdentityError, RigError
from cgagen.link.port import reset_by_dtr
from cgagen.link.prompted import PromptedPort
from cgagen.stamp.chips import EEPROM_BYTES

__all__ = ["BenchHook", "banner_in"]

SIGNS = string.ascii_letters + string.digits
"""Characters of which requests are numbered; none of them begins anything else."""

HASTE_S = 2.0
"""How long hello is tried behind a reset before the next one: four times the half second that a
controller listens. Choice."""

RESETS = 3
"""So often: an adapter that is slow to deliver misses that half second now and then. Choice."""

HELLO_S = 6.0
"""How long a chip may take to say hello: its banner and its tries. Choice."""

ANSWER_S = 10.0
"""How long one request may take, with all repetitions. Choice."""

WALK_S = 20.0
"""How long a movement may take until the legs stand. Choice: ten times a shipped robot's."""

GONE_S = 1.0
"""A chip that was told to leave and has not prompted for so long has left. Choice."""

DUMP_S = 60.0
"""The whole EEPROM takes 26 s from a BS2."""

BANNER_PIECE = 128
"""Bytes that are read at a time in search of the banner, which lies among the first DATA: 1.6 s
from a BS2. Choice."""


class BenchHook(PromptedPort):
    """A controller on a port, as a host talks to it.

    Args:
        port: see `choose_port`: a device, `id:SERIAL`, `rfc2217://HOST:PORT`, ...
        gaps: leave the pauses that a Stamp needs; a server of emulated chips leaves them itself.

    Attributes:
        port: its name.
        nonce: of the last hello; "" before.
        stale: answers to earlier questions.
        unheard: requests that had to be repeated.
        greeting: the banner that was heard after the last reset; None where none was.
    """

    def __init__(self, port: str, gaps: bool = True) -> None:
        super().__init__(port, gaps)
        self.nonce = ""
        self.stale = 0
        self.unheard = 0
        self.greeting: Banner | None = None
        self._numbers = count(secrets.randbelow(len(SIGNS) ** 2))

    def enter(self) -> Banner:
        """Reset the chip and enter bench mode, anew where its half second went by unused.

        Raises:
            RigError: this port has no DTR, no banner of ours follows, or nobody answers.
        """
        for _ in range(RESETS - 1):
            banner = self.reset()
            with suppress(RigError):
                self.hello(HASTE_S)
                return banner
        banner = self.reset()
        self.hello()
        return banner

    def reset(self) -> Banner:
        """Pulse ATN by DTR and wait for the banner; `hello` has half a second from then on.

        Raises:
            RigError: this port has no DTR, or no banner of ours follows.
        """
        reset_by_dtr(self.port, self.opened())
        self.greeting = None
        line, deadline_s = "", time.monotonic() + HELLO_S
        while self.greeting is None and time.monotonic() < deadline_s:
            one = self.read()
            line = "" if one == BANNER else line + one
            if one == END:
                self.greeting = parse_banner(BANNER + line.rstrip(END))
        if self.greeting is None:
            self.give_up(
                "DTR was pulsed and no banner came",
                "load a build into it, and look at the wire from DTR to ATN",
            )
        return self.greeting

    def hello(self, limit_s: float | None = None) -> str:
        """Enter bench mode, or make sure of it; returns the nonce that was echoed.

        Args:
            limit_s: how long that may take; None for `HELLO_S`.

        Raises:
            RigError: nobody answers.
            TargetTimeout: something comes, and no hello.
        """
        deadline_s = time.monotonic() + (HELLO_S if limit_s is None else limit_s)
        while time.monotonic() < deadline_s:
            self.nonce = self._sign()
            self.speak(request_text(Letter.HELLO, *self.nonce), deadline_s)
            for line in self.lines(deadline_s):
                if f"{ANSWER}{Letter.HELLO}{self.nonce}" in line:
                    return self.nonce
        self.give_up("does not say hello")

    def leave(self) -> None:
        """Let the robot go its own way again: it hunts, flees, or waits for GO.

        Raises:
            RigError: nobody listens, or it stays in bench mode.
        """
        request = request_text(Letter.LEAVE, *self._sign())
        deadline_s = time.monotonic() + ANSWER_S
        self.speak(request, deadline_s)
        while time.monotonic() < deadline_s:
            if any(f"{ANSWER}{request[1:]}" in line for line in self.lines(_soon(deadline_s))):
                return
            self.unheard += 1
            if not self.await_prompt(_soon(deadline_s)):
                return  # it does not listen any more: it has gone, and its answer was lost
            self.write(request, 0)
        self.give_up(f"no answer to {request} in {ANSWER_S:g} s")

    def question(self, readings: str) -> Answer:
        """Ask a main controller what it makes of these readings.

        Args:
            readings: of `cgagen.bench_protocol.reading_text`.

        Raises:
            TargetTimeout: it listens and does not answer.
            RigError: nothing comes from it any more, or the readings never reach it whole.
        """
        sign, refused = self._sign(), 0
        deadline_s = time.monotonic() + ANSWER_S
        while time.monotonic() < deadline_s:
            self.speak(request_text(Letter.QUESTION, *sign), deadline_s)
            if self.await_prompt(deadline_s):
                self.write(readings, BYTE_GAP_MS)
                for line in self.lines(deadline_s):
                    answer = parse_answer(line)
                    if answer is not None and answer.sequence == sign:
                        return answer
                    if answer is not None:
                        self.stale += 1
                    elif f"{ANSWER}{Letter.REFUSED}{sign}" in line:
                        refused += 1
                        break
            self.unheard += 1
        if refused:
            raise RigError(
                f"{self.port}: the chip refuses the readings {readings.strip()}, {refused} times "
                f"in {ANSWER_S:g} s; they come to it spoiled, so look at the cable and the adapter"
            )
        self.give_up(f"no answer to the readings {readings.strip()} in {ANSWER_S:g} s")

    def move(self, command: int, sign: str | None = None) -> None:
        """Have a locomotion controller walk a movement once; returns when the legs stand.

        Args:
            command: 0 to 7.
            sign: a character; the one of the movement before has it answered and not walked
                again. By itself each call is a movement of its own.

        Raises:
            RigError: it has no such movement, or nothing comes any more.
            TargetTimeout: it listens and does not take it, or does not end it.
        """
        mark = sign or self._sign()[1]
        self._order(Letter.MOVE, str(command), mark)
        if not self.await_prompt(time.monotonic() + WALK_S):
            self.give_up(f"movement {command} is not over after {WALK_S:g} s")

    def centre(self) -> None:
        """Have a locomotion controller put all legs down and straight out, one after another.

        Raises:
            RigError: nothing comes any more.
            TargetTimeout: it listens and does not take it, or does not end it.
        """
        self._order(Letter.CENTRE, *self._sign())
        if not self.await_prompt(time.monotonic() + WALK_S):
            self.give_up(f"the legs are not centred after {WALK_S:g} s")

    def dump(self, first_byte: int = 0, last_byte: int = EEPROM_BYTES - 1) -> bytes:
        """Return a range of the EEPROM of the running slot, read until it is whole.

        Raises:
            RigError: a line of it never comes through.
        """
        request = dump_request(first_byte, last_byte)
        start = first_byte // DUMP_BLOCK_BYTES * DUMP_BLOCK_BYTES
        wanted = set(range(start, last_byte + 1, DUMP_LINE_BYTES))
        deadline_s = time.monotonic() + DUMP_S
        found: dict[int, bytes] = {}
        while time.monotonic() < deadline_s:
            self.speak(request, deadline_s)
            for line in self.lines(deadline_s):
                part = parse_dump(line)
                if part is not None:
                    found[part[0]] = part[1]
                elif f"{ANSWER}{request[1:]}" in line:
                    break
            if wanted <= found.keys():
                data = b"".join(found[address] for address in sorted(wanted))
                return data[first_byte - start : last_byte + 1 - start]
            self.unheard += 1
        raise RigError(f"{self.port}: its EEPROM could not be read whole; look at the cable")

    def banner(self) -> Banner:
        """Return what the chip's EEPROM says that it is; no more of it is read than that takes.

        Raises:
            IdentityError: it holds no banner of ours.
        """
        read = b""
        for first in range(0, EEPROM_BYTES, BANNER_PIECE):
            read += self.dump(first, first + BANNER_PIECE - 1)
            found = banner_in(read)
            if found is not None:
                return found
        raise IdentityError(
            f"{self.port}: no banner of cgagen's firmware in the chip; load the build first"
        )

    def _sign(self) -> str:
        """Return two characters, others than the last time."""
        number = next(self._numbers)
        return SIGNS[number // len(SIGNS) % len(SIGNS)] + SIGNS[number % len(SIGNS)]

    def _order(self, letter: Letter, first: str, second: str) -> None:
        """Say a request until it is acknowledged."""
        request = request_text(letter, first, second)
        deadline_s = time.monotonic() + ANSWER_S
        while time.monotonic() < deadline_s:
            self.speak(request, deadline_s)
            for line in self.lines(deadline_s):
                if f"{ANSWER}{request[1:]}" in line:
                    return
                if f"{ANSWER}{Letter.REFUSED}{request[2:]}" in line:
                    raise RigError(
                        f"{self.port}: the chip does not take {request}; look whether it is the "
                        "other controller's"
                    )
            self.unheard += 1
        self.give_up(f"no answer to {request} in {ANSWER_S:g} s")


def _soon(deadline_s: float) -> float:
    return min(deadline_s, time.monotonic() + GONE_S)
