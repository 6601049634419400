"""Emulated chips for real programs: their programming ports on sockets and ptys.

::

    from cgagen.serve import serve

    with serve(bench, "rfc2217:0") as server:          # or tcp:0, or pty; chip "main"
        port = serial.serial_for_url(server.url)

    server = serve(bench, {"main": "tcp:0", "locomotion": "pty"}, realtime=True)
    for endpoint in server.endpoints:
        print(endpoint.url, endpoint.control)           # where the bytes are, and DTR and BREAK
    server.run()

The chip's time begins when a host has come, stands still while the chip listens and the host
thinks, and stands still when the host is gone.
"""

from collections.abc import Mapping

from cgagen.emulator.bench import Bench
from cgagen.emulator.host_port import HostPort
from cgagen.emulator.loader import Atn
from cgagen.emulator.programs import MAIN
from cgagen.serve.address import Address
from cgagen.serve.endpoint import Endpoint, TcpEndpoint
from cgagen.serve.paced import PacedPort
from cgagen.serve.server import Server
from cgagen.serve.telnet import Rfc2217Endpoint
from cgagen.serve.terminal import PtyEndpoint

__all__ = ["Address", "Atn", "Endpoint", "Server", "endpoint_of", "serve"]


def serve(
    bench: Bench,
    ports: str | Address | Mapping[str, str | Address] = "tcp:0",
    *,
    atn: Atn = Atn.CAPACITOR,
    legs: int = 24,
    version: int = 0,
    realtime: bool = False,
) -> Server:
    """Return a server for ports of a bench, not running yet.

    Args:
        bench: with nothing else on those chips' programming ports.
        ports: where the chip `main` is served, or where each chip is, by name; see `Address`.
        atn: the boards' circuit between DTR and ATN.
        legs: of a BS2p or BS2pe: 24 or 40.
        version: place of the loaders' version among those of the model, 0 is the oldest.
        realtime: see `Server`.

    Raises:
        RigError: an address that says nothing, or that somebody else listens on.
        BenchError: no such chip, or something else is on its port.
    """
    wanted = ports if isinstance(ports, Mapping) else {MAIN: ports}
    endpoints: list[Endpoint] = []
    try:
        for chip, word in wanted.items():
            endpoints.append(endpoint_of(bench, chip, word, atn=atn, legs=legs, version=version))
    except BaseException:
        for endpoint in endpoints:
            endpoint.close()
        raise
    return Server(bench, endpoints, realtime)


def endpoint_of(
    bench: Bench,
    chip: str = MAIN,
    address: str | Address = "tcp:0",
    *,
    atn: Atn = Atn.CAPACITOR,
    legs: int = 24,
    version: int = 0,
) -> Endpoint:
    """Return where one chip is served; see `serve`.

    Raises:
        RigError: see `serve`.
        BenchError: likewise.
    """
    kind, host, number = address if isinstance(address, Address) else Address.parse(address)
    port = PacedPort(HostPort(bench, chip, atn=atn, legs=legs, version=version))
    if kind == "pty":
        return PtyEndpoint(port, host)
    if kind == "tcp":
        return TcpEndpoint(port, host, number)
    return Rfc2217Endpoint(port, host, number)
