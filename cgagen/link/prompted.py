"""A port with a chip that prompts: its lock, its characters, its prompts, all waits bounded."""

import time
from collections.abc import Iterator
from contextlib import ExitStack
from typing import Never

import serial

from cgagen.bench_protocol import BAUD, END, PROMPT, PROMPT_GAP_MS
from cgagen.closing import Closing
from cgagen.errors import RigError, TargetTimeout
from cgagen.link.port import locked_port
from cgagen.link.ports import choose_port
from cgagen.link.why import LOST

LIFE_S = 1.0
"""A chip from which something came so short a time ago lives: it prompts every 50 ms. Choice."""

UNHEARD_PROMPTS = 2
"""So many prompts after a request without an answer: it was not heard."""


class PromptedPort(Closing):
    """A port whose chip says when it listens.

    Args:
        port: see `choose_port`; asked for only when it is opened.
        gaps: leave the pauses that a Stamp needs; a server of emulated chips leaves them itself.

    Attributes:
        port: its name.
    """

    def __init__(self, port: str, gaps: bool = True) -> None:
        self.port = port
        self._gaps = gaps
        self._held = ExitStack()
        self._serial: serial.SerialBase | None = None
        self._heard_s = -LIFE_S

    def open(self) -> None:
        """Open the port and take its lock; the chip notices nothing.

        Raises:
            RigError: no such port, or another session has it.
        """
        self.port = choose_port(self.port)
        self._serial = self._held.enter_context(locked_port(self.port))

    def close(self) -> None:
        """Close the port; the chip stays in bench mode. Harmless when repeated."""
        self._serial = None
        self._held.close()

    def speak(self, request: str, deadline_s: float) -> None:
        """Wait for a prompt and send a request behind it."""
        if not self.await_prompt(deadline_s):
            self.give_up("no prompt came")
        self.write(request, 0)

    def await_prompt(self, deadline_s: float) -> bool:
        """Wait for a prompt; says whether one came in time.

        One with something behind it is old: a host that was away for a while would stay behind
        for ever.
        """
        while time.monotonic() < deadline_s:
            if self.read() == PROMPT and not self._waiting():
                return True
        return False

    def lines(self, deadline_s: float) -> Iterator[str]:
        """Yield lines behind a request; ends when prompts say that it was not heard."""
        prompts, text = 0, ""
        while time.monotonic() < deadline_s:
            one = self.read()
            if one == END:
                yield text
                text = ""
                continue
            text += one
            prompts += one == PROMPT
            if prompts == UNHEARD_PROMPTS:
                return

    def write(self, text: str, gap_ms: int) -> None:
        """Send behind a prompt, with the pauses that the chip needs. Raises RigError."""
        port = self.opened()
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
        except LOST as error:
            raise RigError(
                f"{self.port}: lost while sending ({error}); look at the cable"
            ) from error

    def read(self) -> str:
        """Return the next character; "" when none came for a while."""
        try:
            data: bytes = self.opened().read(1)
        except LOST as error:
            raise RigError(f"{self.port}: lost ({error}); look at the cable") from error
        if data:
            self._heard_s = time.monotonic()
        return data.decode("latin-1")

    def _waiting(self) -> int:
        """Return whether characters have come that were not read."""
        try:
            count: int = self.opened().in_waiting
        except LOST as error:
            raise RigError(f"{self.port}: lost ({error}); look at the cable") from error
        return count

    def opened(self) -> serial.SerialBase:
        """Return the open port. Raises RigError."""
        if self._serial is None:
            raise RigError(f"{self.port}: is not open; open it first")
        return self._serial

    def give_up(self, what: str, advice: str = "reset it") -> Never:
        """Raise TargetTimeout where the chip still lives, and RigError where it is silent."""
        if time.monotonic() - self._heard_s < LIFE_S:
            raise TargetTimeout(f"{self.port}: {what}, though the chip is alive; {advice}")
        raise RigError(
            f"{self.port}: {what}, and nothing else comes either; look at the cable, switch the "
            "robot on, or reset it"
        )
