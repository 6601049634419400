"""The host's side of PROTOCOL.md: a conversation with the bench hook of either controller.

::

    from cgagen.link.bench_hook import BenchHook

    with BenchHook("/dev/ttyUSB0") as hook:     # opens the port; resets nothing
        hook.reset()                            # DTR; or somebody presses the button
        hook.hello()                            # bench mode from here on
        print(hook.banner())
        hook.move(0)

A host speaks after a prompt only, repeats what was not heard, and takes an answer for its own
only by its number. All waits are bounded.
"""

import string
import time
from collections.abc import Iterator
from itertools import count
from types import TracebackType
from typing import Never, Self

import serial

from cgagen.bench_protocol import (
    ANSWER,
    BANNER,
    BAUD,
    BYTE_GAP_MS,
    DUMP_BLOCK_BYTES,
    DUMP_LINE_BYTES,
    END,
    PROMPT,
    PROMPT_GAP_MS,
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
from cgagen.errors import IdentityError, RigError, TargetTimeout
from cgagen.link.port import PortLock, open_port, reset_by_dtr
from cgagen.stamp.chips import EEPROM_BYTES

__all__ = ["BenchHook", "banner_in"]

SIGNS = string.ascii_letters + string.digits
"""Characters of which requests are numbered; none of them begins anything else."""

HELLO_S = 6.0
"""How long a chip may take to say hello: its banner and its tries. Choice."""

ANSWER_S = 10.0
"""How long one request may take, with all repetitions. Choice."""

WALK_S = 20.0
"""How long a movement may take until the legs stand. Choice: ten times a shipped robot's."""

DUMP_S = 60.0
"""The whole EEPROM takes 26 s from a BS2."""

BANNER_PIECE = 128
"""Bytes that are read at a time in search of the banner, which lies among the first DATA: 1.6 s
from a BS2. Choice."""

LIFE_S = 1.0
"""A chip from which something came so short a time ago lives: it prompts every 50 ms. Choice."""

UNHEARD_PROMPTS = 2
"""So many prompts after a request without an answer: it was not heard."""


class BenchHook:
    """A controller on a port, as a host talks to it.

    Args:
        port: device path, or a URL of pyserial's: `socket://HOST:PORT`, `rfc2217://HOST:PORT`.
        gaps: leave the pauses that a Stamp needs; a server of emulated chips leaves them itself.

    Attributes:
        port: its name.
        nonce: of the last hello; "" before.
        stale: answers to earlier questions.
        unheard: requests that had to be repeated.
        greeting: the banner that was heard after the last reset; None where none was.
    """

    def __init__(self, port: str, gaps: bool = True) -> None:
        self.port = port
        self.nonce = ""
        self.stale = 0
        self.unheard = 0
        self.greeting: Banner | None = None
        self._gaps = gaps
        self._lock = PortLock(port)
        self._serial: serial.SerialBase | None = None
        self._numbers = count(0)
        self._nonces = count(0)
        self._heard_s = -LIFE_S

    # -- The port -----------------------------------------------------------------------------

    def open(self) -> None:
        """Open the port and take its lock; the chip notices nothing.

        Raises:
            RigError: no such port, or another session has it.
        """
        self._lock.take()
        try:
            self._serial = open_port(self.port)
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Close the port; the chip stays in bench mode. Harmless when repeated."""
        if self._serial is not None:
            self._serial.close()
            self._serial = None
        self._lock.release()

    def __enter__(self) -> Self:
        self.open()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def reset(self) -> Banner:
        """Pulse ATN by DTR and wait for the banner; `hello` has half a second from then on.

        Raises:
            RigError: this port has no DTR, or no banner of ours follows.
        """
        reset_by_dtr(self.port, self._opened())
        self.greeting = None
        line, deadline = "", time.monotonic() + HELLO_S
        while self.greeting is None and time.monotonic() < deadline:
            one = self._read()
            line = "" if one == BANNER else line + one
            if one == END:
                self.greeting = parse_banner(BANNER + line.rstrip(END))
        if self.greeting is None:
            self._give_up("DTR was pulsed and no banner came")
        return self.greeting

    # -- Requests -----------------------------------------------------------------------------

    def hello(self) -> str:
        """Enter bench mode, or make sure of it; returns the nonce that was echoed.

        Raises:
            RigError: nobody answers.
            TargetTimeout: something comes, and no hello.
        """
        deadline = time.monotonic() + HELLO_S
        while time.monotonic() < deadline:
            number = next(self._nonces)
            self.nonce = SIGNS[number % 26] + SIGNS[26 + number % 26]
            self._speak(request_text(Letter.HELLO, *self.nonce), deadline)
            for line in self._lines(deadline):
                if f"{ANSWER}{Letter.HELLO}{self.nonce}" in line:
                    return self.nonce
        self._give_up("does not say hello")

    def leave(self) -> None:
        """Let the robot go its own way again: it hunts, flees, or waits for GO."""
        self._order(Letter.LEAVE, *self._sign())

    def question(self, readings: str) -> Answer:
        """Ask a main controller what it makes of these readings.

        Args:
            readings: of `cgagen.bench_protocol.reading_text`.

        Raises:
            TargetTimeout: it listens and does not answer.
            RigError: nothing comes from it any more.
        """
        sign = self._sign()
        deadline = time.monotonic() + ANSWER_S
        while time.monotonic() < deadline:
            self._speak(request_text(Letter.QUESTION, *sign), deadline)
            if self._await_prompt(deadline):
                self._write(readings, BYTE_GAP_MS)
                for line in self._lines(deadline):
                    answer = parse_answer(line)
                    if answer is not None and answer.sequence == sign:
                        return answer
                    if answer is not None:
                        self.stale += 1
                    elif f"{ANSWER}{Letter.REFUSED}{sign}" in line:
                        break
            self.unheard += 1
        self._give_up(f"no answer to the readings {readings.strip()} in {ANSWER_S:g} s")

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
        if not self._await_prompt(time.monotonic() + WALK_S):
            self._give_up(f"movement {command} is not over after {WALK_S:g} s")

    def centre(self) -> None:
        """Have a locomotion controller put all legs down and straight out."""
        self._order(Letter.CENTRE, *self._sign())

    def dump(self, first_byte: int = 0, last_byte: int = EEPROM_BYTES - 1) -> bytes:
        """Return a range of the EEPROM of the running slot, read until it is whole.

        Raises:
            RigError: a line of it never comes through.
        """
        request = dump_request(first_byte, last_byte)
        start = first_byte // DUMP_BLOCK_BYTES * DUMP_BLOCK_BYTES
        wanted = set(range(start, last_byte + 1, DUMP_LINE_BYTES))
        deadline = time.monotonic() + DUMP_S
        found: dict[int, bytes] = {}
        while time.monotonic() < deadline:
            self._speak(request, deadline)
            for line in self._lines(deadline):
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

    # -- Talking ------------------------------------------------------------------------------

    def _sign(self) -> str:
        """Return two characters, others than the last time."""
        number = next(self._numbers)
        return SIGNS[number // len(SIGNS) % len(SIGNS)] + SIGNS[number % len(SIGNS)]

    def _order(self, letter: Letter, first: str, second: str) -> None:
        """Say a request until it is acknowledged."""
        request = request_text(letter, first, second)
        deadline = time.monotonic() + ANSWER_S
        while time.monotonic() < deadline:
            self._speak(request, deadline)
            for line in self._lines(deadline):
                if f"{ANSWER}{request[1:]}" in line:
                    return
                if f"{ANSWER}{Letter.REFUSED}{request[2:]}" in line:
                    raise RigError(
                        f"{self.port}: the chip does not take {request}; look whether it is the "
                        "other controller's"
                    )
            self.unheard += 1
        self._give_up(f"no answer to {request} in {ANSWER_S:g} s")

    def _speak(self, request: str, deadline: float) -> None:
        """Wait for a prompt and send a request behind it."""
        if not self._await_prompt(deadline):
            self._give_up("no prompt came")
        self._write(request, 0)

    def _await_prompt(self, deadline: float) -> bool:
        while time.monotonic() < deadline:
            if self._read() == PROMPT:
                return True
        return False

    def _lines(self, deadline: float) -> Iterator[str]:
        """Yield lines behind a request; ends when prompts say that it was not heard."""
        prompts, text = 0, ""
        while time.monotonic() < deadline:
            one = self._read()
            if one == END:
                yield text
                text = ""
                continue
            text += one
            prompts += one == PROMPT
            if prompts == UNHEARD_PROMPTS:
                return

    def _write(self, text: str, gap_ms: int) -> None:
        port = self._opened()
        try:
            if not self._gaps:
                port.write(text.encode("ascii"))
                return
            time.sleep(PROMPT_GAP_MS / 1_000)
            for piece in text if gap_ms else (text,):
                port.write(piece.encode("ascii"))
                if gap_ms:
                    port.flush()
                    time.sleep(10 / BAUD + gap_ms / 1_000)
        except (OSError, serial.SerialException) as error:
            raise RigError(
                f"{self.port}: lost while sending ({error}); look at the cable"
            ) from error

    def _read(self) -> str:
        """Return the next character; "" when none came for a while."""
        try:
            data: bytes = self._opened().read(1)
        except (OSError, TypeError, serial.SerialException) as error:
            raise RigError(f"{self.port}: lost ({error}); look at the cable") from error
        if data:
            self._heard_s = time.monotonic()
        return data.decode("latin-1")

    def _opened(self) -> serial.SerialBase:
        if self._serial is None:
            raise RigError(f"{self.port}: is not open; open it first")
        return self._serial

    def _give_up(self, what: str) -> Never:
        if time.monotonic() - self._heard_s < LIFE_S:
            raise TargetTimeout(f"{self.port}: {what}, though the chip is alive; reset it")
        raise RigError(
            f"{self.port}: {what}, and nothing else comes either; look at the cable, switch the "
            "robot on, or reset it"
        )
