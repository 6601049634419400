"""A real Stamp on a cable: the bench hook of PROTOCOL.md, spoken over pyserial.

The chip must be in bench mode or have just been reset; opening a port resets nothing. A host
speaks after a prompt only, repeats what was not heard, and takes an answer for its own only by
the number of its question.
"""

import string
import time
from itertools import count
from typing import Never

import serial

from cgagen.bench_protocol import (
    BANNER,
    BAUD,
    BYTE_GAP_MS,
    DUMP_BLOCKS,
    DUMP_LINE_BYTES,
    END,
    PROMPT,
    PROMPT_GAP_MS,
    Banner,
    Letter,
    dump_request,
    parse_answer,
    parse_banner,
    parse_dump,
    reading_text,
    request_text,
)
from cgagen.errors import IdentityError, RigError, TargetTimeout
from cgagen.link.port import PortLock, open_port
from cgagen.stamp.chips import EEPROM_BYTES
from cgagen.stamp.image import Image
from hil.subject import Subject
from hil.target import IMAGE, STATE, Identity, Observation, Stimulus

SIGNS = string.ascii_letters + string.digits
"""Characters of which questions are numbered; none of them begins anything else."""

HELLO_S = 6.0
"""How long a chip may take to say hello: its banner and its tries. Choice."""

ANSWER_S = 10.0
"""How long one question may take, with all repetitions. Choice."""

DUMP_S = 60.0
"""The whole EEPROM takes 26 s from a BS2."""

LIFE_S = 1.0
"""A chip from which something came so short a time ago lives: it prompts every 50 ms. Choice."""

UNHEARD_PROMPTS = 2
"""So many prompts after a request without an answer: it was not heard."""

ATN_S = 0.05
"""How long DTR is held for a reset. Choice."""


class WiredTarget:
    """The main controller on a port.

    Args:
        port: device path, or a URL of pyserial's: `socket://HOST:PORT`, `rfc2217://HOST:PORT`.
        subject: what is to be in the chip.
        gaps: leave the pauses that a Stamp needs; a pipe to an emulated one leaves them itself.

    Attributes:
        stale: answers to earlier questions.
        unheard: requests that had to be repeated.
    """

    caps = frozenset({STATE, IMAGE})

    def __init__(self, port: str, subject: Subject, gaps: bool = True) -> None:
        self.url = f"serial:{port}"
        self.stale = 0
        self.unheard = 0
        self._port = port
        self._subject = subject
        self._gaps = gaps
        self._lock = PortLock(port)
        self._serial: serial.SerialBase | None = None
        self._questions = count(0)
        self._heard_s = -LIFE_S

    def open(self) -> None:
        """Open the port, say hello, and make sure that the chip holds the subject's bytes.

        Raises:
            RigError: no such port, or nobody answers.
            IdentityError: another program is in the chip.
        """
        self._lock.take()
        try:
            self._serial = open_port(self._port)
            self._hello()
            self._prove()
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Close the port; the chip stays in bench mode, so that it does not walk away."""
        if self._serial is not None:
            self._serial.close()
            self._serial = None
        self._lock.release()

    def reset(self) -> None:
        """Pulse ATN by DTR, and say hello again.

        Raises:
            RigError: this port has no DTR, or nobody answers afterwards.
        """
        port = self._open_port()
        try:
            port.dtr = True
            time.sleep(ATN_S)
            port.dtr = False
        except OSError as error:
            raise RigError(
                f"{self._port}: has no DTR to reset the Stamp with; reset it by hand"
            ) from error
        self._hello()

    def identity(self) -> Identity:
        """Return what the banner in the EEPROM says, with the digest of all of it."""
        eeprom = self.dump()
        banner = _banner_in(eeprom)
        if banner is None:
            raise IdentityError(
                f"{self._port}: no banner of cgagen's firmware in the chip; load the build first"
            )
        digest = Image(self._subject.images["main"].model, eeprom).digest
        return Identity(banner.robot, banner.genome, {"main": digest}, self._nonce)

    def dump(self) -> bytes:
        """Return the EEPROM of the running slot, all 2,048 bytes."""
        request = dump_request(0, DUMP_BLOCKS * 32 - 1)
        deadline = time.monotonic() + DUMP_S
        found: dict[int, bytes] = {}
        wanted = EEPROM_BYTES // DUMP_LINE_BYTES
        while time.monotonic() < deadline:
            self._speak(request, deadline)
            for line in self._lines(deadline):
                part = parse_dump(line)
                if part is not None:
                    found[part[0]] = part[1]
                elif f"!{request[1:]}" in line:
                    break
            if len(found) == wanted:
                return b"".join(found[address] for address in sorted(found))
        raise RigError(f"{self._port}: its EEPROM could not be read whole; look at the cable")

    def decide(self, stimulus: Stimulus) -> Observation:
        """Ask for a decision.

        Raises:
            TargetTimeout: it listens and does not answer.
            RigError: nothing comes from it any more.
        """
        number = next(self._questions)
        first, second = (SIGNS[number // len(SIGNS) % len(SIGNS)], SIGNS[number % len(SIGNS)])
        left, right = stimulus.touched
        reading = reading_text((not left) | (not right) << 1, (*stimulus.sonars, *stimulus.lights))
        deadline = time.monotonic() + ANSWER_S
        while time.monotonic() < deadline:
            self._speak(request_text(Letter.QUESTION, first, second), deadline)
            if self._await_prompt(deadline):
                self._write(reading, BYTE_GAP_MS)
                for line in self._lines(deadline):
                    answer = parse_answer(line)
                    if answer is not None and answer.sequence == first + second:
                        return Observation(number, answer.command, answer.state)
                    if answer is not None:
                        self.stale += 1
                    elif f"!{Letter.REFUSED}" in line:
                        break
            self.unheard += 1
        self._give_up(f"no answer to {stimulus.text()} in {ANSWER_S:g} s")

    # -- Talking ------------------------------------------------------------------------------

    def _hello(self) -> None:
        deadline = time.monotonic() + HELLO_S
        nonces = count(0)
        while time.monotonic() < deadline:
            number = next(nonces)
            self._nonce = SIGNS[number % 26] + SIGNS[26 + number % 26]
            self._speak(request_text(Letter.HELLO, *self._nonce), deadline)
            for line in self._lines(deadline):
                if f"!{Letter.HELLO}{self._nonce}" in line:
                    return
        self._give_up("does not say hello")

    def _prove(self) -> None:
        seen, subject = self.identity(), self._subject
        wanted = subject.images["main"].digest
        if (seen.robot, seen.genome) != (subject.robot.name, subject.genome_digest):
            raise IdentityError(
                f"{self._port}: the chip holds {seen.robot} with genome {seen.genome}, not "
                f"{subject.robot.name} with {subject.genome_digest}; load that build"
            )
        if seen.images["main"] != wanted:
            raise IdentityError(
                f"{self._port}: the chip's EEPROM has digest {seen.images['main'][:8]}, the image "
                f"{wanted[:8]}; load the image again"
            )

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

    def _write(self, text: str, gap_ms: int) -> None:
        port = self._open_port()
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
        except OSError as error:
            raise RigError(
                f"{self._port}: lost while sending ({error}); look at the cable"
            ) from error

    def _lines(self, deadline: float) -> "Lines":
        return Lines(self, deadline)

    def _read(self) -> str:
        """Return the next character; "" when none came for a while."""
        try:
            data: bytes = self._open_port().read(1)
        except (OSError, serial.SerialException) as error:
            raise RigError(f"{self._port}: lost ({error}); look at the cable") from error
        if data:
            self._heard_s = time.monotonic()
        return data.decode("latin-1")

    def _open_port(self) -> serial.SerialBase:
        if self._serial is None:
            raise RigError(f"{self._port}: is not open; open it first")
        return self._serial

    def _give_up(self, what: str) -> Never:
        if time.monotonic() - self._heard_s < LIFE_S:
            raise TargetTimeout(f"{self._port}: {what}, though the chip is alive; reset it")
        raise RigError(
            f"{self._port}: {what}, and nothing else comes either; look at the cable, switch the "
            "robot on, or reset it"
        )

    _nonce: str = ""


class Lines:
    """Lines from a chip after a request; ends when it prompts so often that it has not heard."""

    def __init__(self, target: WiredTarget, deadline: float) -> None:
        self._target = target
        self._deadline = deadline
        self._prompts = 0
        self._text = ""

    def __iter__(self) -> "Lines":
        return self

    def __next__(self) -> str:
        while time.monotonic() < self._deadline:
            one = self._target._read()
            if one == END:
                line, self._text = self._text, ""
                return line
            self._text += one
            if one == PROMPT:
                self._prompts += 1
                if self._prompts == UNHEARD_PROMPTS:
                    raise StopIteration
        raise StopIteration


def _banner_in(eeprom: bytes) -> Banner | None:
    text = eeprom.split(END.encode(), 1)[0]
    return parse_banner(text.decode("latin-1")) if text.startswith(BANNER.encode()) else None
