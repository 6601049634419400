"""`cgagen emulate --port`: the chips' programming ports for other programs, until Ctrl-C."""

import shlex
from collections.abc import Callable, Iterable, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cgagen.emulator.bench import Bench
from cgagen.emulator.chip import Chip
from cgagen.emulator.clock import NEVER_NS
from cgagen.emulator.programs import bench_of_image
from cgagen.link.steered import SIGN
from cgagen.stamp.chips import EEPROM_BYTES
from cgagen.stamp.chips import chip as chip_row
from cgagen.stamp.image import Image
from cgagen.stamp.serial_mode import SerialMode
from cgagen.verbs.console import Console
from cgagen.verbs.emulate_bench import chip_of, hold_pin, load_bench
from cgagen.verbs.emulate_files import check_files, recorded

if TYPE_CHECKING:
    from cgagen.serve import Server
    from cgagen.serve.paced import PacedPort

_ASTRAY = "; the chip does nothing until its next reset"


def serve_ports(console: Console, file: Path | None, given: dict[str, Any]) -> int:
    """Serve until the time is over or Ctrl-C; returns the exit code.

    Args:
        console: where the addresses go.
        file: what the chips hold; None for an erased one.
        given: the options of the verb.

    Raises:
        RigError: a place says nothing, or somebody else listens there.
        UsageError: what the options say cannot be.
    """
    from cgagen.serve import Atn, serve

    outputs = (given["vcd"], given["trace"], given["coverage"])
    check_files(file, *outputs, given["force"])
    bench = _erased(given["model"]) if file is None else load_bench(console, file, given["model"])
    chip = chip_of(bench, file or Path(), given["chip_name"])
    ports = _wanted_ports(bench, chip, given["ports"])
    with recorded(bench, chip, *outputs), ExitStack() as stack:
        for word in given["pins"]:
            hold_pin(bench, chip, word)
        server = serve(bench, ports, atn=Atn(given["atn"]), realtime=given["realtime"])
        stack.callback(server.close)
        for endpoint in server.endpoints:
            endpoint.port.port.on_fault = lambda error: console.note(f"note: {error}{_ASTRAY}")
            endpoint.port.on_other_rate = _other_rate(console, endpoint.port.port.chip.name)
            if given["baud"] is not None:
                _set_mode(endpoint.port, given["baud"])
        _tell(replace(console, as_json=given["as_json"] or console.as_json), file, ports, server)
        try:
            server.run(given["limit_ns"] or NEVER_NS)
        except KeyboardInterrupt:
            console.note(f"stopped at {bench.clock.now_ns / 1e9:.3f} s of the chips' time")
    return 0


def _set_mode(port: "PacedPort", mode: SerialMode) -> None:
    """Set what a host sees that sets no speed itself; one on RFC 2217 does."""
    port.baudrate = mode.baud
    if mode.seven_even:
        port.bytesize, port.parity = 7, "E"


def _other_rate(console: Console, chip: str) -> Callable[[SerialMode, SerialMode], None]:
    """Return what says that a host listens at another rate than a chip sends at."""
    return lambda sent, heard: console.note(
        f"note: {chip} sends at {sent}, and who is on its port listens at {heard}: set --baud "
        f"{sent} there, or here where that sets none"
    )


def _erased(model: str | None) -> Bench:
    """Return a bench with one chip that holds nothing.

    Raises:
        UsageError: nobody says which model.
        ImageError: there is no such model.
    """
    if model is None:
        raise click.UsageError("name a FILE, or the --model of an erased chip to be loaded")
    return bench_of_image(Image(chip_row(model), bytes(EEPROM_BYTES)))


def _wanted_ports(bench: Bench, chip: Chip, words: Sequence[str]) -> dict[str, str]:
    """Return where each chip is to be served, by name.

    Args:
        bench: what runs.
        chip: who is meant where no name is given.
        words: `PLACE` or `CHIP=PLACE`, such as `tcp:0` and `legs=pty`.

    Raises:
        BenchError: there is no such chip.
        UsageError: one chip at two places.
    """
    ports: dict[str, str] = {}
    for word in words:
        owner, named, place = word.rpartition("=")
        name = bench.chip(owner).name if named else chip.name
        if name in ports:
            raise click.UsageError(f"--port {word}: {name} has one port; name another chip")
        ports[name] = place
    return ports


def _tell(console: Console, file: Path | None, ports: Iterable[str], server: "Server") -> None:
    """Say where everything is, before anything happens."""
    rows, lines = [], []
    for name, endpoint in zip(ports, server.endpoints, strict=True):
        control = endpoint.control
        port = f"{endpoint.url}{SIGN}{control}" if control else endpoint.url
        rows.append({"chip": name, "url": endpoint.url, "control": control, "port": port})
        lines.append(f"{name}: {endpoint.url}" + (f"  DTR and BREAK: {control}" if control else ""))
        if control:
            lines.append(f"  as a --port of cgagen: {shlex.quote(port)}")
    data = {"file": None if file is None else str(file), "ports": rows}
    console.result(data, "\n".join(lines))
    console.note("(until Ctrl-C; the chips' time begins when a host has come)")
