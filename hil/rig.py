"""An emulated rig on a bus: python-can's virtual one, or a serial adapter on a pty or a TCP port.

`python -m hil.rig BUILD` serves one to other programs until it is stopped.
"""

import os
import pty
import select
import socket
import threading
import time
import tty
from abc import abstractmethod
from contextlib import suppress
from pathlib import Path

import click

from cgagen.closing import Closing
from cgagen.errors import CgagenError, RigError
from hil.frames import Frame
from hil.rig_protocol import Rig
from hil.slcan import SlcanAdapter
from hil.subject import read_subject

HEARTBEAT_S = 0.2
"""The least time between two signs of life, and the longest that a rig waits for a question.
Choice; PROTOCOL.md asks for one twice a second."""

READ_BYTES = 256

MOST_PORT = 65_535

MOST_WAITING_BYTES = 65_536
"""For a host that does not read; what comes beyond that is lost, as on a real adapter. Choice."""


class _Service(Closing):
    """A thread that serves a rig; use it in a `with`.

    Attributes:
        failure: what ended it, if anything did.
    """

    def __init__(self, name: str) -> None:
        self.failure: BaseException | None = None
        self._ended = threading.Event()
        self._beaten_s = time.monotonic()
        self._thread = threading.Thread(target=self._guard, name=name, daemon=True)

    def open(self) -> None:
        """Serve in a thread of its own."""
        self._thread.start()

    def stop(self) -> None:
        """Let it end soon; may be called from its own thread."""
        self._ended.set()

    def close(self) -> None:
        """End the thread, and let go of what is open. Harmless when repeated."""
        self.stop()
        if self._thread.is_alive():
            self._thread.join()
        self._let_go()

    def _beats(self) -> bool:
        """Whether it is time for a sign of life, which is then taken as given."""
        now_s = time.monotonic()
        if now_s - self._beaten_s < HEARTBEAT_S:
            return False
        self._beaten_s = now_s
        return True

    def _guard(self) -> None:
        try:
            self._run()
        except BaseException as error:
            self.failure = error
        finally:
            self._let_go()

    @abstractmethod
    def _run(self) -> None:
        """Serve until the service ends."""

    @abstractmethod
    def _let_go(self) -> None:
        """Close what is open. Harmless when repeated."""


class RigOnBus(_Service):
    """A rig on a bus of python-can's.

    Args:
        rig: open.
        channel: of the virtual interface; seen by this process alone.
    """

    def __init__(self, rig: Rig, channel: str) -> None:
        import can

        super().__init__(f"rig on {channel}")
        self.url = f"can:virtual:{channel}"
        self._rig = rig
        self._bus = can.Bus(interface="virtual", channel=channel, ignore_config=True)

    def _run(self) -> None:
        while not self._ended.is_set():
            message = self._bus.recv(HEARTBEAT_S)
            if self._beats():
                self.send(self._rig.heartbeat())
            if message is None:
                continue
            if not (message.is_extended_id or message.is_remote_frame or message.is_error_frame):
                for answer in self._rig.receive(Frame(message.arbitration_id, bytes(message.data))):
                    self.send(answer)

    def send(self, one: Frame) -> None:
        """Put a frame on the bus; whoever spoils it overrides."""
        import can

        self._bus.send(can.Message(arbitration_id=one.id, data=one.data, is_extended_id=False))

    def _let_go(self) -> None:
        self._bus.shutdown()


class SlcanPort(_Service):
    """A rig behind a serial adapter.

    Args:
        rig: open.
        kind: "pty", or "tcp" for a port of this machine.
        port: number for "tcp", 0 for any.

    Attributes:
        url: what a target is called that is to talk to it.
    """

    def __init__(self, rig: Rig, kind: str = "pty", port: int = 0) -> None:
        super().__init__(f"rig behind {kind}")
        self.adapter = SlcanAdapter(rig)
        self._server: socket.socket | None = None
        self._master = self._slave = -1
        self._waiting = bytearray()
        if kind == "tcp":
            self._server = _server_on(port)
            self._server.settimeout(HEARTBEAT_S)
            self.url = f"can:slcan:socket://127.0.0.1:{self._server.getsockname()[1]}"
        else:
            self._master, self._slave = pty.openpty()
            tty.setraw(self._slave)
            os.set_blocking(self._master, False)
            self.url = f"can:slcan:{os.ttyname(self._slave)}"

    def _run(self) -> None:
        while not self._ended.is_set():
            if self._server is None:
                self._serve(self._master)
                continue
            try:
                connection, _ = self._server.accept()
            except TimeoutError:
                continue
            with connection:
                connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                connection.setblocking(False)
                self._serve(connection.fileno())

    def _serve(self, handle: int) -> None:
        """Carry bytes until the host is gone or the service ends."""
        self.adapter.is_open, self._waiting = False, bytearray()
        while not self._ended.is_set():
            try:
                pending = [handle] if self._waiting else []
                readable, _, _ = select.select([handle], pending, [], HEARTBEAT_S)
                if readable:
                    data = os.read(handle, READ_BYTES)
                    if not data:
                        return
                    for answer in self.adapter.feed(data):
                        self.write(handle, answer)
                if not self._waiting and self._beats():
                    self.write(handle, self.adapter.heartbeat())
                self._flush(handle)
            except OSError:
                return  # the host is gone

    def write(self, handle: int, data: bytes) -> None:
        """Give the host what comes from the bus; whoever spoils it overrides."""
        if len(self._waiting) < MOST_WAITING_BYTES:
            self._waiting += data
        self._flush(handle)

    def _flush(self, handle: int) -> None:
        with suppress(BlockingIOError):
            while self._waiting:
                del self._waiting[: os.write(handle, self._waiting)]

    def _let_go(self) -> None:
        for handle in (self._master, self._slave):
            if handle >= 0:
                os.close(handle)
        self._master = self._slave = -1
        if self._server is not None:
            self._server.close()


def _server_on(port: int) -> socket.socket:
    try:
        if port > MOST_PORT:
            raise OSError(f"ports end at {MOST_PORT}")
        return socket.create_server(("127.0.0.1", port))
    except OSError as error:
        raise RigError(
            f"port {port} of this machine cannot be served ({error}); take another"
        ) from error


@click.command()
@click.argument("build", type=click.Path(path_type=Path, file_okay=False, exists=True))
@click.option("--slcan", "place", default="pty", show_default=True, metavar="pty|tcp:PORT")
def main(build: Path, place: str) -> None:
    """Serve the emulated robot of a BUILD folder on a rig behind a serial CAN adapter.

    Prints what `cgagen verify --target` and `pytest --hil-target` are to be given, and serves
    until Ctrl-C.
    """
    kind, _, port = place.partition(":")
    if (kind, bool(port)) not in (("pty", False), ("tcp", True)) or not (port or "0").isdigit():
        raise click.UsageError(f"--slcan {place}: say pty, or tcp:PORT with 0 for any")
    try:
        rig = Rig(read_subject(build))
        rig.open()
        service = SlcanPort(rig, kind, int(port or 0))
    except CgagenError as error:
        click.echo(f"cgagen: {error}", err=True)
        raise SystemExit(error.exit_code) from None
    with service, suppress(KeyboardInterrupt):
        click.echo(service.url)
        while service.failure is None:
            time.sleep(HEARTBEAT_S)
    if service.failure is not None:
        raise service.failure


if __name__ == "__main__":
    main()
