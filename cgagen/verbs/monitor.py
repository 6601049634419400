"""`cgagen monitor`: a DEBUG terminal on a real or emulated Stamp."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import click

from cgagen.verbs.baud import BaudType
from cgagen.verbs.console import Console, with_console
from cgagen.verbs.emulate import TimeType
from cgagen.verbs.written import OUTPUT, check, in_folder

PORT_HELP = (
    "A device, id:SERIAL, a URL of pyserial's, emu:BUILD (emulated), or auto: the only USB adapter."
)

LONGEST_LINE = 4_096
"""Characters of the chip's without a CR that become an object of JSON all the same. Choice."""

BAUD_HELP = "Bits per second; 2400-7E1 for seven bits and even parity."


@click.command("monitor")
@click.option("--port", default="auto", show_default=True, metavar="PORT", help=PORT_HELP)
@click.option(
    "--baud", type=BaudType(), default="9600", show_default=True, metavar="MODE", help=BAUD_HELP
)
@click.option("--raw", is_flag=True, help="Bytes as they come, on a terminal, too.")
@click.option("--timestamps", is_flag=True, help="Seconds since the start before every line.")
@click.option("--log", type=OUTPUT, metavar="FILE", help="Write what comes to a file, too.")
@click.option("--decode", is_flag=True, help="Our firmware's lines in words; --json: as objects.")
@click.option("--robot", metavar="NAME|FILE", help="With --decode: whose counts they are.")
@click.option(
    "--input", "text", metavar="TEXT", help="What is typed; - for stdin. Default: a terminal."
)
@click.option("--for", "limit_ns", type=TimeType(), help="Stop after this time.")
@click.option("--reset", is_flag=True, help="Reset the Stamp first; otherwise it is left alone.")
@click.option("--force", is_flag=True, help="Overwrite the log.")
@with_console
def monitor_verb(console: Console, /, port: str, **given: Any) -> None:
    """Show what a Stamp sends on its programming port, and send what is typed.

    On a terminal the control codes of DEBUG are rendered; otherwise stdout gets the bytes. The
    wiring sends back what is typed; that is left out. Ctrl-C, or the end of --for, ends it.

    With --json, each line of the chip's is an object: `time_s` since the start, `text` (a character
    a byte), and `ended`, which is false where no CR was behind it.

    With --decode, lines of our firmware are shown in words: readings in inches, situations,
    movements and faults.
    """
    from cgagen.verbs.emulated_port import EMULATED, named_port, robot_behind

    given["robot"] = given["robot"] or robot_behind(port)
    if given["log"] is not None:
        from cgagen.outputs import never

        given["log"] = in_folder(given["log"], "monitor.log")
        check([(given["log"], never("a log"))], force=given["force"])
    # What an emulated robot says while its port is being opened is lost; so it is switched on then.
    given["reset"] |= port.startswith(EMULATED)
    with named_port(port, "main", realtime=True) as name:
        _listen(console, name, given)


def _listen(console: Console, port: str, given: dict[str, Any]) -> None:
    """Carry bytes between a port and the user."""
    from cgagen.link.port import locked_port, reset_by_dtr
    from cgagen.monitor import Listener, listen
    from cgagen.verbs.keyboard import from_stdin, from_text, is_given

    began_s = time.monotonic()
    stack = ExitStack()
    sinks = [_shown(console, given, lambda: time.monotonic() - began_s, stack)]
    text = given["text"]
    if text == "-" or (text is None and is_given(at_once=True)):
        more = from_stdin(True, lambda: None)
    else:
        more = from_text(text or "")
    # The log comes second: a port that does not open costs nobody an older log.
    with (
        stack,
        locked_port(port, *given["baud"]) as wire,
        _log(given["log"]) as log,
    ):
        limit_s = None if given["limit_ns"] is None else given["limit_ns"] / 1e9
        ends = "" if limit_s is None else f", or --for after {limit_s:g} s"
        console.note(f"{port}: listening at {given['baud']} baud; Ctrl-C ends it{ends}")
        listener = Listener(port, wire, [*sinks, *log], console.note, baud=given["baud"].baud)
        try:
            if given["reset"]:
                reset_by_dtr(port, wire)
            listen(
                listener,
                lambda: more(False),
                lambda: limit_s is None or time.monotonic() - began_s < limit_s,
            )
        except KeyboardInterrupt:
            console.note("")
        listener.end()
    console.note(f"{port}: {listener.received} bytes in {time.monotonic() - began_s:.1f} s")


def _shown(
    console: Console, given: dict[str, Any], now_s: Callable[[], float], stack: ExitStack
) -> Callable[[bytes], Any]:
    """Return what puts the chip's bytes on stdout; what is left at the end, the stack does."""
    if given["decode"]:
        return _decoded(console, given, now_s)
    if console.as_json:
        lines = JsonLines(console, now_s)
        stack.callback(lines.close)
        return lines.write
    if given["raw"] or not (sys.stdout.isatty() or given["timestamps"]):
        stream = sys.stdout.buffer

        def raw(data: bytes) -> None:
            stream.write(data)
            stream.flush()

        return raw
    if given["timestamps"]:
        return _stamped(now_s)
    from cgagen.emulator.screen import Screen

    screen = Screen()

    def rendered(data: bytes) -> None:
        sys.stdout.write(screen.shown(data))
        sys.stdout.flush()

    return rendered


class JsonLines:
    """Writes an object for each line that a chip sends.

    Args:
        console: where to.
        now_s: seconds since the start.
    """

    def __init__(self, console: Console, now_s: Callable[[], float]) -> None:
        self._console = console
        self._now_s = now_s
        self._begun_s: float | None = None
        self._text = ""

    def write(self, data: bytes) -> None:
        """Take the next bytes."""
        for one in data.decode("latin-1"):
            if self._begun_s is None:
                self._begun_s = self._now_s()
            if one == "\r":
                self._say(True)
            else:
                self._text += one
                if len(self._text) == LONGEST_LINE:
                    self._say(False)
        sys.stdout.flush()

    def close(self) -> None:
        """Write what has come without an end."""
        if self._text:
            self._say(False)

    def _say(self, ended: bool) -> None:
        time_s = round(self._begun_s or 0.0, 6)
        self._console.result({"time_s": time_s, "text": self._text, "ended": ended}, "")
        self._begun_s, self._text = None, ""


def _stamped(now_s: Callable[[], float]) -> Callable[[bytes], None]:
    """Return what writes lines, each with the time of its first byte."""
    begun = False

    def write(data: bytes) -> None:
        nonlocal begun
        for one in data.decode("cp1252", "replace"):
            if one == "\r":
                click.echo("" if begun else f"[{now_s():9.3f}]")
                begun = False
            elif one.isprintable():
                click.echo(one if begun else f"[{now_s():9.3f}] {one}", nl=False)
                begun = True
        sys.stdout.flush()

    return write


def _decoded(
    console: Console, given: dict[str, Any], now_s: Callable[[], float]
) -> Callable[[bytes], None]:
    from cgagen.monitor import Decoder
    from cgagen.robot import load_robot

    decoder = Decoder(load_robot(given["robot"]) if given["robot"] else None)

    def write(data: bytes) -> None:
        for line in decoder.lines(data):
            stamp = f"[{now_s():9.3f}] " if given["timestamps"] else ""
            console.result(line.data, stamp + line.text)
            sys.stdout.flush()

    return write


@contextmanager
def _log(path: Path | None) -> Iterator[list[Callable[[bytes], Any]]]:
    """Give what writes a log that is whole up to the last byte; nothing where none is wanted."""
    if path is None:
        yield []
        return
    from cgagen.files import live_file

    with live_file(path) as file:
        yield [file.write]
