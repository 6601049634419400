"""An emulated Stamp's programming port as a socket or a pty, for real drivers to talk to.

The chip's time stands still while it listens and the host has not spoken yet, so a slow host is
not late and a fast chip does not run away; it goes on by itself when the host has been silent for
a while. It begins when the host opens the port first. What the host sends while the chip does not
listen is lost, as on a Stamp.
"""

import os
import pty
import select
import socket
import threading
import tty
from types import TracebackType
from typing import Self

from cgagen.bench_protocol import BAUD, BYTE_GAP_MS, PROMPT_GAP_MS
from cgagen.emulator.bench import Bench
from cgagen.emulator.chip import Chip

SIN = 16
"""Number of the programming port's input."""

SILENCE_S = 0.02
"""How long a host may think about a prompt before the chip's time goes on. Choice."""

SLICE_NS = 5_000_000
"""How far the chip goes while it listens in vain, before the host is asked again. Choice."""

RUN_NS = 4_000_000
"""How far it goes at once otherwise. Choice: less than any slice in which a chip listens."""

BYTE_NS = 10 * 1_000_000_000 // BAUD + BYTE_GAP_MS * 1_000_000
"""A character and the gap behind it."""


class BytePipe:
    """A chip of a bench behind a byte stream; use it in a `with`.

    Args:
        bench: nobody else may run it meanwhile.
        chip: whose programming port it is.
        kind: "socket" or "pty".

    Attributes:
        url: what pyserial opens.
        failure: what ended it, if anything did.
    """

    def __init__(self, bench: Bench, chip: str = "main", kind: str = "socket") -> None:
        self.failure: BaseException | None = None
        self._bench = bench
        self._chip: Chip = bench.chip(chip)
        self._uart = bench.host(chip)
        self._ended = threading.Event()
        self._server: socket.socket | None = None
        self._master = -1
        if kind == "socket":
            self._server = socket.create_server(("127.0.0.1", 0))
            self._server.settimeout(SILENCE_S)
            self.url = f"socket://127.0.0.1:{self._server.getsockname()[1]}"
        else:
            self._master, host = pty.openpty()
            tty.setraw(host)
            self.url = os.ttyname(host)
            os.close(host)
        self._thread = threading.Thread(target=self._run, name=f"pipe {self.url}", daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._ended.set()
        self._thread.join()
        if self._server is not None:
            self._server.close()
        else:
            os.close(self._master)

    def outgoing(self, data: bytes) -> bytes:
        """Return what the host is given of what the chip has sent; whoever spoils it overrides."""
        return data

    def _run(self) -> None:
        try:
            while not self._ended.is_set():
                if self._server is None:
                    if _somebody_has(self._master):
                        self._serve(self._master)
                    else:
                        self._ended.wait(SILENCE_S)
                    continue
                try:
                    connection, _ = self._server.accept()
                except TimeoutError:
                    continue
                with connection:
                    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                    self._serve(connection.fileno())
        except BaseException as error:
            self.failure = error

    def _serve(self, handle: int) -> None:
        """Carry bytes until the host is gone or the pipe is closed."""
        while not self._ended.is_set():
            try:
                data = self._read(handle, SILENCE_S if self._listens() else 0.0)
                if data == b"":
                    return
                if data:
                    self._say(data)
                else:
                    self._advance(SLICE_NS if self._listens() else RUN_NS)
                os.write(handle, self.outgoing(self._uart.take()))
            except OSError:
                return

    def _read(self, handle: int, wait_s: float) -> bytes | None:
        """Return what the host has sent; None for nothing, no bytes for a host that is gone."""
        ready, _, _ = select.select([handle], [], [], wait_s)
        return os.read(handle, 256) if ready else None

    def _say(self, data: bytes) -> None:
        until_ns = self._bench.clock.now_ns + PROMPT_GAP_MS * 1_000_000
        while not self._listens() and self._bench.clock.now_ns < until_ns:
            self._advance(RUN_NS // 40)
        for byte in data:
            self._uart.send(bytes([byte]))
            self._advance(BYTE_NS)

    def _listens(self) -> bool:
        waiting = self._chip.waiting
        return waiting is not None and waiting.pin == SIN

    def _advance(self, ns: int) -> None:
        self._bench.run(self._bench.clock.now_ns + ns)


def _somebody_has(master: int) -> bool:
    """Say whether a host has opened the other end of a pty."""
    poll = select.poll()
    poll.register(master, select.POLLIN)
    return not any(event & select.POLLHUP for _, event in poll.poll(0))
