"""An emulated Stamp's programming port as a socket or a pty, for real drivers to talk to."""

from cgagen.emulator.bench import Bench
from cgagen.serve import Server, endpoint_of


class BytePipe(Server):
    """A chip of a bench behind a byte stream; use it in a `with`.

    Args:
        bench: nobody else may run it meanwhile.
        chip: whose programming port it is.
        kind: "tcp" (or "socket"), "rfc2217" or "pty".
    """

    def __init__(self, bench: Bench, chip: str = "main", kind: str = "tcp") -> None:
        word = "tcp" if kind == "socket" else kind
        endpoint = endpoint_of(bench, chip, word)
        endpoint.outgoing = self.outgoing
        super().__init__(bench, [endpoint])

    def outgoing(self, data: bytes) -> bytes:
        """Return what the host is given of what the chip has sent; whoever spoils it overrides."""
        return data
